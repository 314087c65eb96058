//! What volumes are shown as: iso-surfaces at given values, and media as transfer functions say.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use mobula::camera::Up;
use mobula::geometry::{Field, IsoSurfaces, Series};
use mobula::load::{Place, load_transfer, printable};
use mobula::material::Phong;
use mobula::medium::{self, Between, DEFAULT_STEP};
use mobula::scene::SceneDescription;
use mobula::volume::{Grid, Preset, Statistics, TransferFunction, Volume};

use super::args::VolumeOptions;
use super::failure::Failure;
use super::values::{Plane, Point, Shading, Transfer};
use super::{say, tell};

/// Colours of iso-surfaces, in the order of their values: bone, skin, and others that are told apart from these.
const COLORS: [[f32; 3]; 6] = [
    [0.86, 0.80, 0.68],
    [0.80, 0.47, 0.33],
    [0.35, 0.55, 0.75],
    [0.55, 0.70, 0.35],
    [0.70, 0.45, 0.65],
    [0.85, 0.75, 0.30],
];

/// Adds to a scene what its volumes are shown as. With `all_steps` those may be changed to other steps of time; else there is only the
/// one that was asked for.
pub(crate) fn show(
    scene: &mut SceneDescription,
    options: &VolumeOptions,
    place: &Place,
    all_steps: bool,
) -> Result<(), Failure> {
    let cuts: Vec<[f64; 4]> = options.cut.iter().map(|cut| put(cut, place)).collect();
    if scene.geometry.is_empty() && !scene.volumes.is_empty() {
        // As scanners, weather and the ground have it.
        scene.up = scene.up.or(Some(Up::Z));
    }
    let steps = scene.volumes.iter().map(|volume| volume.steps.len());
    let longest = steps.chain(scene.particles.iter().map(|particles| particles.steps.len())).max().unwrap_or(0);
    if let Some(particles) = scene.particles.first().filter(|_| options.step >= longest) {
        return Err(no_step(&particles.name, particles.steps.len(), options.step));
    }
    for (number, mut volume) in std::mem::take(&mut scene.volumes).into_iter().enumerate() {
        if let Some(Point(origin)) = options.volume_origin {
            volume = moved_to(volume, place.put(origin))?;
        }
        let series = series(&volume, options.step, longest, all_steps)?;
        let transfer = options.transfer.get(number).or(options.transfer.last());
        if let Some(transfer) = transfer {
            add_medium(scene, &volume, &series, transfer, options, &cuts)?;
        }
        if transfer.is_none() || !options.iso.is_empty() {
            add_surfaces(scene, &volume, series, options, &cuts)?;
        }
        scene.volumes.push(volume);
    }
    Ok(())
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
        ("--step", *step > 0 && scene.particles.is_empty()),
    ];
    let names = |options: &[(&str, bool)]| {
        let given = options.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect::<Vec<_>>();
        (!given.is_empty()).then(|| given.join(", "))
    };
    let mut warnings = Vec::new();
    if scene.volumes.is_empty() {
        warnings.extend(names(&[&others[..], &media].concat()).map(|names| format!("{names}: there is no volume")));
    } else if transfer.is_empty() {
        warnings.extend(names(&media).map(|names| format!("{names}: this is for --transfer, which is not given")));
    } else if transfer.len() > scene.volumes.len() {
        let (more, volumes) = (transfer.len() - scene.volumes.len(), scene.volumes.len());
        warnings.push(format!("--transfer: there are {more} more of it than volumes ({volumes})"));
    }
    if !scene.volumes.is_empty() && !transfer.is_empty() && iso.is_empty() && !transparent.is_empty() {
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

/// The steps of a volume, made ready for rays. Behind its last step comes its first again, up to the last step of any volume.
fn series(volume: &Volume, step: usize, longest: usize, all: bool) -> Result<Series, Failure> {
    let name = printable(&volume.name);
    let count = volume.steps.len();
    if step >= longest.max(1) || count == 0 {
        return Err(no_step(&volume.name, count, step));
    }
    let field = |grid| {
        let field = Field::new(Arc::clone(grid)).map_err(|error| Failure::Output(format!("{name}: {error}")));
        field.map(Arc::new)
    };
    if all {
        let fields: Result<Vec<_>, _> = volume.steps.iter().map(field).collect();
        return Ok(Series::new(fields?).at(step));
    }
    // Colours go by all steps, whichever is shown.
    let ranges = volume.steps.iter().filter_map(|grid| grid.range());
    let range = ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or_default();
    Ok(Series::new(vec![field(&volume.steps[step % count])?]).of_range(range))
}

/// The failure where there is no step of a number.
fn no_step(name: &str, count: usize, step: usize) -> Failure {
    let (name, steps) = (printable(name), if count == 1 { "1 step".to_owned() } else { format!("{count} steps") });
    Failure::Usage(format!("{name} has {steps} of time, from 0; there is no step {step}"))
}

fn add_medium(
    scene: &mut SceneDescription,
    volume: &Volume,
    series: &Series,
    transfer: &Transfer,
    options: &VolumeOptions,
    cuts: &[[f64; 4]],
) -> Result<(), Failure> {
    let (range, labels) = (series.range(), matches!(transfer, Transfer::Labels));
    if volume.steps.iter().all(|grid| grid.range().is_none()) {
        return Err(Failure::Output(format!("{}: no value is a number", printable(&volume.name))));
    }
    let function = match transfer {
        Transfer::Preset(preset) => preset.function(range),
        Transfer::Labels => labels_of(volume, range)?,
        Transfer::File(file) if !file.exists() => {
            let known = Preset::NAMES.join(", ");
            let name = printable(&file.display().to_string()).into_owned();
            return Err(Failure::Usage(format!(
                "--transfer {name}: there is neither a transfer function of this name nor such a file; there are {known} and labels"
            )));
        }
        Transfer::File(file) => load_transfer(file)?,
    };
    let lit = match options.shading {
        Shading::Auto => matches!(transfer, Transfer::Preset(preset) if preset.is_lit()),
        Shading::On => true,
        Shading::Off => false,
    };
    let mut shown = medium::Volume::new(volume.name.clone(), series.clone(), Arc::new(function));
    if let Some(window) = options.window {
        shown = shown.with_window(window.0);
    }
    (shown.lit, shown.step, shown.cuts) = (lit, options.step_length, cuts.to_vec());
    shown.between = if labels { Between::Nearest } else { Between::Linear };
    scene.media.push(Arc::new(shown));
    Ok(())
}

/// A colour for each label of a volume: the whole numbers among its values.
fn labels_of(volume: &Volume, [low, high]: [f64; 2]) -> Result<TransferFunction, Failure> {
    let name = printable(&volume.name);
    if low.ceil() < f64::from(i32::MIN) || high.floor() > f64::from(i32::MAX) || high - low > f64::from(1 << 24) {
        return Err(Failure::Output(format!(
            "{name}: its values from {low} to {high} are no labels: these are 32-bit numbers, at most 2^24 apart"
        )));
    }
    let first = low.ceil() as i32;
    let mut there = vec![false; (high.floor() - low.ceil()).max(0.0) as usize + 1];
    for grid in &volume.steps {
        for i in 0..grid.voxels().len() {
            let value = grid.value_of(grid.voxels().get(i));
            if value.fract() == 0.0
                && let Some(there) = there.get_mut((value - f64::from(first)) as usize)
            {
                *there = true;
            }
        }
    }
    let labels: Vec<_> = (first..).zip(there).filter(|(_, there)| *there).map(|(label, _)| label).collect();
    if labels.is_empty() {
        return Err(Failure::Output(format!("{name}: none of its values is a whole number, so it has no labels")));
    }
    TransferFunction::labels("labels", labels).map_err(|error| Failure::Output(format!("{name}: {error}")))
}

/// A plane where files were put.
fn put(&Plane([a, b, c, d]): &Plane, place: &Place) -> [f64; 4] {
    let [x, y, z] = place.offset;
    [a, b, c, (d - a * x - b * y - c * z) * place.scale]
}

/// A volume with its first sample elsewhere.
fn moved_to(volume: Volume, origin: [f32; 3]) -> Result<Volume, Failure> {
    let to = |grid: Arc<Grid>| {
        let moved = Arc::unwrap_or_clone(grid).moved_to(DVec3::from(origin.map(f64::from)));
        moved.map(Arc::new).map_err(|error| Failure::Usage(format!("--volume-origin: {error}")))
    };
    let steps: Result<_, _> = volume.steps.into_iter().map(to).collect();
    Ok(Volume { steps: steps?, ..volume })
}

fn add_surfaces(
    scene: &mut SceneDescription,
    volume: &Volume,
    series: Series,
    options: &VolumeOptions,
    cuts: &[[f64; 4]],
) -> Result<(), Failure> {
    let name = printable(&volume.name);
    let mut values = options.iso.clone();
    if values.is_empty() {
        let one = Volume { name: String::new(), steps: vec![Arc::clone(series.field().grid())] };
        let (range, threshold) = Statistics::of(&one).threshold();
        let range = range.ok_or_else(|| Failure::Output(format!("{name}: no value is a number")))?;
        let value = rounded(threshold, range);
        let [low, high] = range;
        tell!("mobula: {name}: iso-surface at {value}; choose others from {low} to {high} with --iso");
        values.push(value);
    } else {
        let [low, high] = series.range();
        for value in values.iter().filter(|value| !(low < **value && **value <= high)) {
            say!("mobula: warning: {name} has no surface at {value}: its values are from {low} to {high}");
        }
    }
    let material = |number: usize| {
        let transparency = options.transparent.get(number).or(options.transparent.last()).copied().unwrap_or(0.0);
        let name = format!("iso-surface at {}", values[number]);
        let diffuse = Vec3::from(COLORS[number % COLORS.len()]);
        (name, Phong { diffuse, specular: Vec3::splat(0.15), transparency, refractive_index: 1.0, ..Phong::default() })
    };
    let materials = (0..values.len()).map(|number| {
        let (name, phong) = material(number);
        scene.add_material(name, phong)
    });
    let materials = materials.collect();
    scene.add(IsoSurfaces { name: volume.name.clone(), series, values, materials, cuts: cuts.to_vec() });
    Ok(())
}

/// A value with no more digits than its range makes sense of.
fn rounded(value: f64, [low, high]: [f64; 2]) -> f64 {
    let digits = 10_f64.powf(((high - low) / 1000.0).abs().max(1e-300).log10().ceil());
    let rounded = (value / digits).round() * digits;
    // Not 0.30000000000000004.
    let short: f64 = format!("{rounded:.12e}").parse().unwrap_or(rounded);
    if low < short && short <= high { short } else { value }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_rounded_within_their_range() {
        assert_eq!(rounded(216.33, [-1024.0, 3071.0]), 220.0);
        assert_eq!(rounded(0.312_345, [0.0, 1.0]), 0.312);
        assert_eq!(rounded(5.0, [5.0, 5.0]), 5.0);
    }
}
