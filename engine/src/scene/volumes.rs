//! Surfaces and media are made of volumes: iso-surfaces at given values, and media as transfer functions say.

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::description::SceneDescription;
use super::shown::{Shown, Transfer};
use crate::geometry::{Field, IsoSurfaces, Series};
use crate::material::Phong;
use crate::medium::{self, Between};
use crate::view::Up;
use crate::volume::{Grid, GridError, Statistics, TransferFunction, Volume};

/// Which steps of time are made ready.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Steps {
    /// The one that is shown, from 0.
    pub shown: usize,
    /// All may be shown later; else there is only this one.
    pub all: bool,
    /// So many bytes are for steps of particles that can be read again when they are wanted.
    pub memory: u64,
}

impl Default for Steps {
    /// The first, and no other.
    fn default() -> Self {
        Self { shown: 0, all: false, memory: u64::MAX }
    }
}

/// What people should know of what volumes are shown as, a line each.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Notes {
    /// What was chosen.
    pub chosen: Vec<String>,
    /// What is not as asked for.
    pub warnings: Vec<String>,
}

/// Why a volume cannot be shown.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ShowError {
    /// A step of time that no volume has.
    #[error("{volume} has {} of time, from 0; there is no step {step}", counted(*steps))]
    Step {
        /// The volume.
        volume: String,
        /// How many steps it has.
        steps: usize,
        /// Which one was asked for.
        step: usize,
    },
    /// A place where it cannot be.
    #[error("{0} cannot be put there: {1}")]
    Origin(String, GridError),
    /// A volume that is not suited to it.
    #[error("{0}: {1}")]
    Volume(String, String),
}

fn counted(steps: usize) -> String {
    format!("{steps} step{}", if steps == 1 { "" } else { "s" })
}

/// Colours of iso-surfaces, in the order of their values: bone, skin, and others that are told apart from these.
const COLORS: [[f32; 3]; 6] = [
    [0.86, 0.80, 0.68],
    [0.80, 0.47, 0.33],
    [0.35, 0.55, 0.75],
    [0.55, 0.70, 0.35],
    [0.70, 0.45, 0.65],
    [0.85, 0.75, 0.30],
];

/// Adds to a scene what its volumes are shown as. Those of which [`SceneDescription::shown`] says nothing are shown as `others`
/// says, which is called with 0, 1, ... for one after the other. Then it says of all of them what they are shown as.
///
/// # Errors
/// If a volume is not suited to it, or there is no such step of time.
pub fn show(scene: &mut SceneDescription, others: impl Fn(usize) -> Shown, steps: Steps) -> Result<Notes, ShowError> {
    if scene.geometry.is_empty() && !scene.volumes.is_empty() {
        // As scanners, weather and the ground have it.
        scene.up = scene.up.or(Some(Up::Z));
    }
    let longest = scene.steps();
    let said = std::mem::take(&mut scene.shown);
    let mut said = said.into_iter();
    let (mut notes, mut unsaid) = (Notes::default(), 0);
    for mut volume in std::mem::take(&mut scene.volumes) {
        let mut shown = said.next().flatten().unwrap_or_else(|| {
            unsaid += 1;
            others(unsaid - 1)
        });
        if let Some(origin) = shown.origin {
            volume = moved_to(volume, origin)?;
        }
        let series = series(&volume, steps, longest)?;
        if let Some(transfer) = &shown.transfer {
            add_medium(scene, &volume, &series, transfer, &shown)?;
        }
        if shown.transfer.is_none() || !shown.iso.is_empty() {
            shown.iso = add_surfaces(scene, &volume, series, &shown, &mut notes)?;
        }
        scene.volumes.push(volume);
        scene.shown.push(Some(shown));
    }
    Ok(notes)
}

/// The steps of a volume, made ready for rays. Behind its last step comes its first again, up to the last step of any volume.
fn series(volume: &Volume, steps: Steps, longest: usize) -> Result<Series, ShowError> {
    let (step, count) = (steps.shown, volume.steps.len());
    if step >= longest.max(1) || count == 0 {
        return Err(ShowError::Step { volume: volume.name.clone(), steps: count, step });
    }
    let field = |grid| {
        let field = Field::new(Arc::clone(grid));
        field.map(Arc::new).map_err(|error| ShowError::Volume(volume.name.clone(), error.to_string()))
    };
    if steps.all {
        let fields: Result<Vec<_>, _> = volume.steps.iter().map(field).collect();
        return Ok(Series::new(fields?).at(step));
    }
    // Colours go by all steps, whichever is shown.
    let ranges = volume.steps.iter().filter_map(|grid| grid.range());
    let range = ranges.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or_default();
    Ok(Series::new(vec![field(&volume.steps[step % count])?]).of_range(range))
}

fn add_medium(
    scene: &mut SceneDescription,
    volume: &Volume,
    series: &Series,
    transfer: &Transfer,
    shown: &Shown,
) -> Result<(), ShowError> {
    let range = series.range();
    if volume.steps.iter().all(|grid| grid.range().is_none()) {
        return Err(ShowError::Volume(volume.name.clone(), "no value is a number".to_owned()));
    }
    let function = match transfer {
        Transfer::Preset(preset) => Arc::new(preset.function(range)),
        Transfer::Labels => Arc::new(labels_of(volume, range)?),
        Transfer::Function(function) => Arc::clone(function),
    };
    let mut medium = medium::Volume::new(volume.name.clone(), series.clone(), function);
    if let Some(window) = shown.window {
        medium = medium.with_window(window);
    }
    medium.lit = shown.lit.unwrap_or(matches!(transfer, Transfer::Preset(preset) if preset.is_lit()));
    (medium.step, medium.cuts) = (shown.step_length, shown.cuts.clone());
    medium.between = if matches!(transfer, Transfer::Labels) { Between::Nearest } else { Between::Linear };
    scene.media.push(Arc::new(medium));
    Ok(())
}

/// A colour for each label of a volume: the whole numbers among its values.
fn labels_of(volume: &Volume, [low, high]: [f64; 2]) -> Result<TransferFunction, ShowError> {
    let wrong = |problem: String| ShowError::Volume(volume.name.clone(), problem);
    if low.ceil() < f64::from(i32::MIN) || high.floor() > f64::from(i32::MAX) || high - low > f64::from(1 << 24) {
        return Err(wrong(format!(
            "its values from {low} to {high} are no labels: these are 32-bit numbers, at most 2^24 apart"
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
        return Err(wrong("none of its values is a whole number, so it has no labels".to_owned()));
    }
    TransferFunction::labels("labels", labels).map_err(|error| wrong(error.to_string()))
}

/// A volume with its first sample elsewhere.
fn moved_to(volume: Volume, origin: [f32; 3]) -> Result<Volume, ShowError> {
    let Volume { name, steps } = volume;
    let to = |grid: Arc<Grid>| {
        let moved = Arc::unwrap_or_clone(grid).moved_to(DVec3::from(origin.map(f64::from)));
        moved.map(Arc::new).map_err(|error| ShowError::Origin(name.clone(), error))
    };
    let steps = steps.into_iter().map(to).collect::<Result<_, _>>()?;
    Ok(Volume { name, steps })
}

/// Adds iso-surfaces, and returns their values.
fn add_surfaces(
    scene: &mut SceneDescription,
    volume: &Volume,
    series: Series,
    shown: &Shown,
    notes: &mut Notes,
) -> Result<Vec<f64>, ShowError> {
    let name = &volume.name;
    let mut values = shown.iso.clone();
    if values.is_empty() {
        let one = Volume { name: String::new(), steps: vec![Arc::clone(series.field().grid())] };
        let (range, threshold) = Statistics::of(&one).threshold();
        let range = range.ok_or_else(|| ShowError::Volume(name.clone(), "no value is a number".to_owned()))?;
        let value = rounded(threshold, range);
        let [low, high] = range;
        notes.chosen.push(format!("{name}: iso-surface at {value}; choose others from {low} to {high} with --iso"));
        values.push(value);
    } else {
        let [low, high] = series.range();
        for value in values.iter().filter(|value| !(low < **value && **value <= high)) {
            notes.warnings.push(format!("{name} has no surface at {value}: its values are from {low} to {high}"));
        }
    }
    let material = |number: usize| {
        let transparency = shown.transparent.get(number).or(shown.transparent.last()).copied().unwrap_or(0.0);
        let diffuse = Vec3::from(COLORS[number % COLORS.len()]);
        Phong { diffuse, specular: Vec3::splat(0.15), transparency, refractive_index: 1.0, ..Phong::default() }
    };
    let materials = (0..values.len()).map(|number| {
        let given = shown.materials.get(number).copied().flatten();
        given.unwrap_or_else(|| scene.add_material(format!("iso-surface at {}", values[number]), material(number)))
    });
    let materials = materials.collect();
    let cuts = shown.cuts.clone();
    scene.add(IsoSurfaces { name: name.clone(), series, values: values.clone(), materials, cuts });
    Ok(values)
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
    use crate::volume::GridPlace;

    #[test]
    fn values_are_rounded_within_their_range() {
        assert_eq!(rounded(216.33, [-1024.0, 3071.0]), 220.0);
        assert_eq!(rounded(0.312_345, [0.0, 1.0]), 0.312);
        assert_eq!(rounded(5.0, [5.0, 5.0]), 5.0);
    }

    #[test]
    fn volumes_are_shown_as_said_and_the_others_in_turn() {
        let voxels: Vec<u8> = (0..8).collect();
        let grid = Grid::new([2; 3], voxels.into(), GridPlace::with_spacing([1.0; 3]), [1.0, 0.0]).unwrap();
        let volume = |name: &str| Volume { name: name.to_owned(), steps: vec![Arc::new(grid.clone())] };
        let mut scene = SceneDescription {
            volumes: ["a", "b", "c"].map(volume).into(),
            shown: vec![None, Some(Shown { iso: vec![2.0, 90.0], ..Shown::default() })],
            ..SceneDescription::default()
        };
        let others = |number: usize| Shown { iso: vec![number as f64 + 3.5], ..Shown::default() };
        let notes = show(&mut scene, others, Steps::default()).unwrap();
        let surfaces = scene.geometry.iter().map(|one| one.downcast_ref::<IsoSurfaces>().unwrap());
        let values: Vec<_> = surfaces.map(|one| (one.name.as_str(), one.values.clone())).collect();
        assert_eq!(values, [("a", vec![3.5]), ("b", vec![2.0, 90.0]), ("c", vec![4.5])]);
        assert_eq!(notes.warnings, ["b has no surface at 90: its values are from 0 to 7"]);
        let error = show(&mut scene, others, Steps { shown: 1, all: true, ..Steps::default() }).unwrap_err();
        assert_eq!(error.to_string(), "a has 1 step of time, from 0; there is no step 1");
    }
}
