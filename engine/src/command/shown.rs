//! What volumes are shown as that the options speak of.

use std::sync::Arc;

use mobula::load::{Place, load_transfer, printable};
use mobula::medium::DEFAULT_STEP;
use mobula::scene::{SceneDescription, ShowError, Shown, Steps, show};
use mobula::volume::{Grid, Preset, Volume};

use super::args::VolumeOptions;
use super::failure::Failure;
use super::values::{Plane, Point, Shading, Transfer};
use super::{say, tell};

/// Adds to a scene what its volumes are shown as: as it says itself, or else as the options do.
pub(crate) fn add(
    scene: &mut SceneDescription,
    options: &VolumeOptions,
    place: &Place,
    steps: Steps,
) -> Result<(), Failure> {
    let transfers = options.transfer.iter().map(function).collect::<Result<Vec<_>, _>>()?;
    let shown = Shown {
        iso: options.iso.clone(),
        materials: Vec::new(),
        transparent: options.transparent.clone(),
        transfer: None,
        window: options.window.map(|window| window.0),
        lit: match options.shading {
            Shading::Auto => None,
            Shading::On => Some(true),
            Shading::Off => Some(false),
        },
        step_length: options.step_length,
        origin: options.volume_origin.map(|Point(origin)| place.put(origin)),
        cuts: options.cut.iter().map(|Plane(plane)| place.put_plane(*plane)).collect(),
    };
    let others = |number: usize| {
        let transfer = transfers.get(number).or(transfers.last()).cloned();
        Shown { transfer, ..shown.clone() }
    };
    let notes = show(scene, others, steps).map_err(|error| {
        let text = printable(&error.to_string()).into_owned();
        if matches!(error, ShowError::Volume(..)) { Failure::Output(text) } else { Failure::Usage(text) }
    })?;
    notes.chosen.iter().for_each(|note| tell!("mobula: {}", printable(note)));
    notes.warnings.iter().for_each(|warning| say!("mobula: warning: {}", printable(warning)));
    Ok(())
}

/// The transfer function that a word means.
fn function(transfer: &Transfer) -> Result<mobula::scene::Transfer, Failure> {
    Ok(match transfer {
        Transfer::Preset(preset) => mobula::scene::Transfer::Preset(*preset),
        Transfer::Labels => mobula::scene::Transfer::Labels,
        Transfer::File(file) if !file.exists() => {
            let known = Preset::NAMES.join(", ");
            let name = printable(&file.display().to_string()).into_owned();
            return Err(Failure::Usage(format!(
                "--transfer {name}: there is neither a transfer function of this name nor such a file; there are {known} and labels"
            )));
        }
        Transfer::File(file) => mobula::scene::Transfer::Function(Arc::new(load_transfer(file)?)),
    })
}

/// Which options do nothing in a scene, and why: a line each.
pub(crate) fn without_effect(scene: &SceneDescription, options: &VolumeOptions) -> Vec<String> {
    let VolumeOptions { iso, transfer, shading, step_length, volume_origin, transparent, cut, step, .. } = options;
    let media = [("--shading", *shading != Shading::Auto), ("--step-length", *step_length != DEFAULT_STEP)];
    let others = [
        ("--iso", !iso.is_empty()),
        ("--transfer", !transfer.is_empty()),
        ("--volume-origin", volume_origin.is_some()),
        ("--transparent", !transparent.is_empty()),
        ("--cut", !cut.is_empty()),
        ("--step", step.is_some_and(|step| step > 0) && scene.steps() == 0),
    ];
    let names = |options: &[(&str, bool)]| {
        let given = options.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect::<Vec<_>>();
        (!given.is_empty()).then(|| given.join(", "))
    };
    // Of others the scene itself says what they are shown as.
    let volumes = scene.volumes.len() - scene.shown.iter().flatten().count();
    let mut warnings = Vec::new();
    if scene.volumes.is_empty() {
        warnings.extend(names(&[&others[..], &media].concat()).map(|names| format!("{names}: there is no volume")));
    } else if volumes == 0 {
        let all = [&others[..5], &media].concat();
        warnings
            .extend(names(&all).map(|names| format!("{names}: the scene says itself what its volumes are shown as")));
    } else if transfer.is_empty() {
        warnings.extend(names(&media).map(|names| format!("{names}: this is for --transfer, which is not given")));
    } else if transfer.len() > volumes {
        let more = transfer.len() - volumes;
        warnings.push(format!("--transfer: there are {more} more of it than volumes ({volumes})"));
    }
    if volumes > 0 && !transfer.is_empty() && iso.is_empty() && !transparent.is_empty() {
        warnings.push("--transparent: this is for iso-surfaces, of which there are none".to_owned());
    }
    for volume in &scene.volumes {
        let flat = |grid: &Arc<Grid>| grid.dims().iter().any(|&samples| samples < 2);
        if volume.steps.iter().any(flat) {
            let name = printable(&volume.name);
            warnings.push(format!("{name}: there is nothing between samples where an axis has only one of them"));
        }
        warnings.extend(imprecise(volume));
    }
    warnings
}

/// What to say about a volume whose values are not told apart, or not lit, in single precision.
fn imprecise(volume: &Volume) -> Option<String> {
    // As they are stored: in whole numbers of 8 and 16 bits all is well, whatever these stand for.
    let stored = |grid: &Arc<Grid>| grid.range().map(|range| range.map(|value| grid.voxel_of(value)));
    let [low, high] = volume.steps.iter().filter_map(stored).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])?;
    let (size, width) = (low.abs().max(high.abs()), (high - low).abs());
    let name = printable(&volume.name);
    if width > 0.0 && width < size * f64::from(f32::EPSILON) * 256.0 {
        return Some(format!(
            "{name}: values differ by {width:e} at {size:e}, which single precision hardly tells apart: subtract what they share"
        ));
    }
    if width > 1e20 || (width > 0.0 && width < 1e-20) {
        return Some(format!(
            "{name}: values differ by {width:e}, too much or too little for lights and colours: scale them to between 1e-20 and 1e20"
        ));
    }
    None
}
