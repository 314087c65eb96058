//! What particles are shown as, and what people are told of them: attributes with their types, ranges and histograms.

use std::sync::Arc;

use mobula::geometry::Spheres;
use mobula::load::{Place, printable};
use mobula::particles::{ParticleStep, Particles, TilingError};
use mobula::scene::SceneDescription;
use mobula::volume::Statistics;
use serde_json::{Value, json};

use super::args::ParticleOptions;
use super::failure::Failure;
use super::histogram::{self, short};
use super::scene::grouped;
use super::tell;
use super::values::{Lengths, Tile};

/// Adds to a scene what its particles are shown as at a step of time; behind the last step comes the first.
pub(crate) fn show(
    scene: &mut SceneDescription,
    options: &ParticleOptions,
    step: usize,
    place: &Place,
) -> Result<(), Failure> {
    for number in 0..scene.particles.len() {
        let particles = &scene.particles[number];
        let Some(shown) = particles.steps.get(step % particles.steps.len().max(1)) else { continue };
        let guess = || {
            let guess = particles.guessed_radius();
            if shown.radii.is_empty() {
                let radius = short(f64::from(guess) / place.scale);
                let name = printable(&particles.name);
                tell!("mobula: {name}: particles have no radius; {radius} is guessed; choose another with --radius");
            }
            guess
        };
        let radius = options.radius.map(|radius| (f64::from(radius) * place.scale) as f32);
        let tiled = tiled(particles, shown, options, place)?;
        let spheres = spheres(&particles.name, &tiled, radius, guess);
        scene.add(spheres);
    }
    Ok(())
}

/// A step as geometry. `radius` is that of all; without it they have their own, or a guessed one.
fn spheres(name: &str, step: &ParticleStep, radius: Option<f32>, guess: impl Fn() -> f32) -> Spheres {
    let radii = match radius {
        Some(radius) => vec![radius],
        None if step.radii.is_empty() => vec![guess()],
        None => step.radii.clone(),
    };
    Spheres { name: name.to_owned(), centers: step.centers.clone(), radii, ..Spheres::default() }
}

/// A step with its periodic box repeated, as somebody asked for.
fn tiled(
    particles: &Particles,
    step: &Arc<ParticleStep>,
    options: &ParticleOptions,
    place: &Place,
) -> Result<Arc<ParticleStep>, Failure> {
    let Some(Tile(times)) = options.tile else { return Ok(Arc::clone(step)) };
    let mut step = (**step).clone();
    if let Some(Lengths(sides)) = options.periodic_box {
        let [x, y, z] = sides.map(|side| (side * place.scale) as f32);
        step.cell = Some([[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]);
    }
    let name = printable(&particles.name);
    step.tiled(times).map(Arc::new).map_err(|error| {
        Failure::Usage(match error {
            TilingError::NoBox => {
                format!("--tile: {name} does not say how large its periodic box is: give its edges with --box X,Y,Z")
            }
            TilingError::TooMany(count) => {
                format!("--tile: {name} would have {count} particles, which are too many: repeat it less often")
            }
        })
    })
}

/// What programs are told of particles.
pub(crate) fn object(particles: &Particles, place: &Place) -> Value {
    let Some(sample) = particles.sample() else { return json!({}) };
    let attribute = |(name, kind): (&str, &str), found: &Statistics, scale: f64| {
        let range = found.range.map(|range| range.map(|x| x / scale));
        json!({
            "name": name,
            "type": kind,
            "min": range.map(|[low, _]| low),
            "max": range.map(|[_, high]| high),
            "mean": found.mean.map(|mean| mean / scale),
            "histogram": found.histogram.as_slice(),
            "not_numbers": found.not_numbers,
            "infinite": found.infinite,
        })
    };
    let attributes = sample.attributes.iter().filter_map(|known| {
        let found = particles.statistics(&known.name)?;
        Some(attribute((&known.name, known.values.type_name()), &found, 1.0))
    });
    let counts: Vec<_> = particles.steps.iter().map(|step| step.centers.len()).collect();
    json!({
        "particle_set": particles.name,
        "steps": particles.steps.len(),
        "particles_by_step": counts,
        "attributes": attributes.collect::<Vec<_>>(),
        "radius": particles.radius_statistics().map(|found| attribute(("radius", "f32"), &found, place.scale)),
        "box": sample.cell.map(|cell| cell.map(|edge| edge.map(|x| f64::from(x) / place.scale))),
    })
}

/// What people are told of particles: names and values, a line each.
pub(crate) fn lines(particles: &Particles, place: &Place) -> Vec<(String, String)> {
    let Some(sample) = particles.sample() else { return Vec::new() };
    let mut lines = Vec::new();
    let mut line = |name: &str, value: String| lines.push((name.to_owned(), value));
    line("particle set", printable(&particles.name).into_owned());
    line("  steps of time", particles.steps.len().to_string());
    let counts = || particles.steps.iter().map(|step| step.centers.len());
    if let (Some(least), Some(most)) = (counts().min(), counts().max())
        && particles.steps.len() > 1
    {
        let between = if least == most {
            grouped(most as u64)
        } else {
            format!("{} to {}", grouped(least as u64), grouped(most as u64))
        };
        line("  in a step", between);
    }
    if let Some(cell) = sample.cell {
        let back = |x: f32| short(f64::from(x) / place.scale);
        let straight = (0..3).all(|k| (0..3).all(|i| i == k || cell[k][i] == 0.0));
        let edge = |edge: [f32; 3]| format!("({})", edge.map(back).join(", "));
        let sides = [0, 1, 2].map(|k| back(cell[k][k])).join(" x ");
        line("  periodic box", if straight { sides } else { cell.map(edge).join(" ") });
    }
    if sample.radii.is_empty() {
        line("  radius", "none".to_owned());
    }
    let mut values = |name: &str, kind: &str, found: &Statistics, scale: f64| {
        let range = match (found.range, found.mean) {
            (Some([low, high]), Some(mean)) => {
                let [low, high, mean] = [low, high, mean].map(|x| short(x / scale));
                format!("{kind}, {low} to {high}, mean {mean}")
            }
            _ => format!("{kind}, no finite value"),
        };
        let counted =
            |count: u64, what: &str| if count > 0 { format!(", {} {what}", grouped(count)) } else { String::new() };
        let odd = counted(found.not_numbers, "not numbers") + &counted(found.infinite, "infinite");
        line(&format!("  {}", printable(name)), range + &odd);
        if found.range.is_some_and(|[low, high]| low < high) {
            line("", histogram::row(found));
        }
    };
    if let Some(found) = particles.radius_statistics() {
        values("radius", "f32", &found, place.scale);
    }
    for known in &sample.attributes {
        if let Some(found) = particles.statistics(&known.name) {
            values(&known.name, known.values.type_name(), &found, 1.0);
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_are_those_of_somebody_of_the_file_or_guessed() {
        let mut step = ParticleStep { centers: vec![[0.0; 3]; 2], radii: vec![1.0, 2.0], ..ParticleStep::default() };
        let radii = |step: &ParticleStep, radius| spheres("", step, radius, || 7.0).radii;
        assert_eq!(radii(&step, None), [1.0, 2.0]);
        assert_eq!(radii(&step, Some(3.0)), [3.0]);
        step.radii.clear();
        assert_eq!(radii(&step, None), [7.0]);
    }
}
