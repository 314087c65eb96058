//! What volumes are shown as: iso-surfaces at given values.

use std::sync::Arc;

use glam::Vec3;
use mobula::camera::Up;
use mobula::geometry::{Field, IsoSurfaces};
use mobula::load::printable;
use mobula::material::Phong;
use mobula::scene::SceneDescription;
use mobula::volume::{Statistics, Volume};

use super::args::VolumeOptions;
use super::failure::Failure;
use super::tell;

/// Colours of iso-surfaces, in the order of their values: bone, skin, and others that are told apart from these.
const COLORS: [[f32; 3]; 6] = [
    [0.86, 0.80, 0.68],
    [0.80, 0.47, 0.33],
    [0.35, 0.55, 0.75],
    [0.55, 0.70, 0.35],
    [0.70, 0.45, 0.65],
    [0.85, 0.75, 0.30],
];

/// Adds to a scene what its volumes are shown as.
pub(crate) fn show(scene: &mut SceneDescription, options: &VolumeOptions) -> Result<(), Failure> {
    if scene.geometry.is_empty() && !scene.volumes.is_empty() {
        // As scanners, weather and the ground have it.
        scene.up = scene.up.or(Some(Up::Z));
    }
    for volume in std::mem::take(&mut scene.volumes) {
        add(scene, &volume, options)?;
        scene.volumes.push(volume);
    }
    Ok(())
}

fn add(scene: &mut SceneDescription, volume: &Volume, options: &VolumeOptions) -> Result<(), Failure> {
    let name = printable(&volume.name);
    let count = volume.steps.len();
    let Some(grid) = volume.steps.get(options.step) else {
        return Err(Failure::Usage(format!(
            "{name} has {count} steps of time, from 0; there is no step {}",
            options.step
        )));
    };
    let field = Field::new(Arc::clone(grid)).map_err(|error| Failure::Output(format!("{name}: {error}")))?;
    let mut values = options.iso.clone();
    if values.is_empty() {
        let one = Volume { name: String::new(), steps: vec![Arc::clone(grid)] };
        let (range, threshold) = Statistics::of(&one).threshold();
        let range = range.ok_or_else(|| Failure::Output(format!("{name}: no value is a number")))?;
        let value = rounded(threshold, range);
        let [low, high] = range;
        tell!("mobula: {name}: iso-surface at {value}; choose others from {low} to {high} with --iso");
        values.push(value);
    } else if let Some([low, high]) = grid.range() {
        for value in values.iter().filter(|value| !(low < **value && **value <= high)) {
            tell!("mobula: warning: {name} has no surface at {value}: its values are from {low} to {high}");
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
    scene.add(IsoSurfaces {
        name: volume.name.clone(),
        field: Arc::new(field),
        values,
        materials,
        cuts: options.cut.iter().map(|cut| cut.0).collect(),
    });
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
