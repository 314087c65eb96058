//! Geometry is made of particles: which of them are shown, how large, and in which colours.

use std::sync::Arc;

use glam::Vec3;

use super::description::SceneDescription;
use super::particle_look::{ColorBy, Map, OpacityBy, ParticleLook};
use super::particle_notes::{ParticleError, ParticleNote};
use super::particle_steps::{Maker, series};
use super::volumes::Steps;
use crate::accel::Build;
use crate::geometry::{CloudSeries, Coloring, Cropping, Opacity, OpacityCurve, Particles};
use crate::material::Phong;
use crate::particles::{self, ParticleStep, Values, element_colors};
use crate::volume::{ColorMap, Preset, TransferError, TransferFunction};

/// Makes geometry of the particles of a scene, which are taken out of it. Those of which [`SceneDescription::particle_looks`] says
/// nothing are shown as `others` says, which is called with 0, 1, ... for one after the other. Behind the last step of some comes their
/// first again, up to the last step of anything. Returns what people should know.
///
/// # Errors
/// If they cannot be shown so.
pub fn show_particles(
    scene: &mut SceneDescription,
    others: impl Fn(usize) -> ParticleLook,
    steps: Steps,
    build: &Build,
) -> Result<Vec<ParticleNote>, ParticleError> {
    if let Some(first) = scene.particles.first().filter(|_| steps.shown >= scene.steps().max(1)) {
        let (particles, count) = (first.name.clone(), first.steps.len());
        return Err(ParticleError::Step { particles, steps: count, step: steps.shown });
    }
    let in_steps = scene.particles.iter().filter(|particles| particles.source.is_some()).count().max(1);
    let steps = Steps { memory: steps.memory / in_steps as u64, ..steps };
    let mut said = std::mem::take(&mut scene.particle_looks).into_iter();
    let (mut notes, mut unsaid) = (Vec::new(), 0);
    for all in std::mem::take(&mut scene.particles) {
        let look = said.next().flatten().unwrap_or_else(|| {
            unsaid += 1;
            others(unsaid - 1)
        });
        let geometry = geometry(scene, all, &look, steps, build, &mut notes)?;
        scene.add(geometry);
    }
    Ok(notes)
}

fn geometry(
    scene: &mut SceneDescription,
    mut all: particles::Particles,
    look: &ParticleLook,
    steps: Steps,
    build: &Build,
    notes: &mut Vec<ParticleNote>,
) -> Result<Particles, ParticleError> {
    let name = all.name.clone();
    let count = all.steps.len().max(1);
    let at = steps.shown % count;
    // What is shown first decides with the others in memory about colours and radii.
    if let (Some(step @ None), Some(source)) = (all.steps.get_mut(at), &all.source) {
        *step = Some(Arc::new(source.read(at).map_err(ParticleError::Read)?));
    }
    for Cropping { attribute, .. } in &look.crops {
        known(&all, attribute)?;
    }
    if let Some(attribute) = &look.radius_by {
        known(&all, attribute)?;
    }
    let coloring = coloring(&all, &look.color)?;
    let opacity = opacity(&all, look)?;
    if let (Some(Coloring { attribute, map }), ColorBy::Attribute { name: None, .. }) = (&coloring, &look.color) {
        let [low, high] = map.range();
        let (attribute, map) = (attribute.clone(), map.name.clone());
        notes.push(ParticleNote::Colored { particles: name.clone(), attribute, range: [low, high], map });
    }
    let radius = look.radius.unwrap_or_else(|| all.guessed_radius());
    let guessed =
        look.radius.is_none() && look.radius_by.is_none() && all.sample().is_some_and(|step| step.radii.is_empty());
    if guessed {
        notes.push(ParticleNote::Guessed { particles: name.clone(), radius });
    }
    let material = look.material.unwrap_or_else(|| scene.add_material("particles", grain(GRAIN)));
    let maker = Maker { look: look.clone(), name: name.clone(), radius, build: build.clone() };
    let reach = maker.reach(&all)?;
    let ranges: Vec<_> = look.crops.iter().map(|crop| range_of(&all, &crop.attribute)).collect();
    let series = if steps.all {
        series(all, maker, at, steps.memory)?
    } else {
        let step = all.steps.into_iter().nth(at).flatten();
        CloudSeries::new(vec![Arc::new(maker.cloud_of(Arc::unwrap_or_clone(step.unwrap_or_default()))?)])
    };
    for (Cropping { attribute, ranges }, all) in look.crops.iter().zip(ranges) {
        if !ranges.iter().any(|[low, high]| *low <= all[1] && all[0] <= *high) {
            let (particles, attribute) = (name.clone(), attribute.clone());
            notes.push(ParticleNote::NothingShown { particles, attribute, range: all });
        }
    }
    if series.in_memory().len() < count && steps.all {
        notes.push(ParticleNote::NotInMemory {
            particles: name.clone(),
            in_memory: series.in_memory().len(),
            steps: count,
            radius: guessed.then_some(radius),
            coloring: coloring.as_ref().map(|by| (by.attribute.clone(), by.map.range())),
        });
    }
    let particles = Particles::of_series(name, Arc::new(series), at, material);
    let mut particles = particles.expect("the step that is shown is in memory").reaching(reach);
    (particles.crops, particles.coloring, particles.opacity) = (look.crops.clone(), coloring, opacity);
    Ok(particles)
}

/// The colour of particles where nothing decides about it, linear RGB.
pub const GRAIN: [f32; 3] = [0.85; 3];

/// What particles of a colour are made of, unless somebody says so.
pub fn grain(color: [f32; 3]) -> Phong {
    Phong { diffuse: color.into(), specular: Vec3::splat(0.12), ..Phong::default() }
}

/// An error if there is no attribute of a name.
fn known(all: &particles::Particles, name: &str) -> Result<(), ParticleError> {
    let sample = all.sample();
    if sample.is_none_or(|step| step.centers.is_empty() || step.attribute(name).is_some()) {
        return Ok(());
    }
    let names: Vec<_> = sample.iter().flat_map(|step| &step.attributes).map(|one| one.name.as_str()).collect();
    let known = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
    Err(ParticleError::NoAttribute { particles: all.name.clone(), name: name.to_owned(), known })
}

/// Attributes that are parts of something else.
const PARTS: [&str; 13] = ["id", "mol", "vx", "vy", "vz", "nx", "ny", "nz", "red", "green", "blue", "alpha", "radius"];

fn coloring(all: &particles::Particles, color: &ColorBy) -> Result<Option<Coloring>, ParticleError> {
    let sample = all.sample();
    let attributes = || sample.iter().flat_map(|step| &step.attributes).map(|one| &*one.name);
    let (name, map, range) = match color {
        ColorBy::Material => return Ok(None),
        ColorBy::Attribute { name: None, map, range } => {
            let chosen = attributes().find(|name| *name == "element");
            let chosen = chosen.or_else(|| attributes().find(|name| !PARTS.contains(name)));
            let Some(name) = chosen else { return Ok(None) };
            (name, map.clone(), *range)
        }
        ColorBy::Attribute { name: Some(name), map, range } => {
            known(all, name)?;
            (&**name, map.clone(), *range)
        }
    };
    let whole = sample.and_then(|step| step.attribute(name)).is_some_and(|one| matches!(one.values, Values::U8(_)));
    let map = color_map(name, whole, map, range, || range_of(all, name));
    let map = map.map_err(|error| ParticleError::Map(all.name.clone(), error))?;
    Ok(Some(Coloring { attribute: name.to_owned(), map: Arc::new(map) }))
}

/// The colours of an attribute, which may have `whole` numbers only: those of a map, or as go with it. `range` are the values at the ends
/// of the map, usually `all` that there are.
pub(crate) fn color_map(
    attribute: &str,
    whole: bool,
    map: Option<Map>,
    range: Option<[f32; 2]>,
    all: impl FnOnce() -> [f32; 2],
) -> Result<ColorMap, TransferError> {
    let map = map.unwrap_or(match attribute {
        "element" => Map::Elements,
        _ if whole => Map::Labels,
        _ => Map::Preset(Preset::Viridis),
    });
    let range = match (&map, range) {
        (_, Some(range)) => range,
        (Map::Elements, None) => [0.0, 118.0],
        (Map::Labels, None) => all(),
        _ => match all() {
            // Of a single value: it is the least, and there is room above.
            [low, high] if low == high => [low, low + (low.abs() * 1e-3).max(1.0)],
            range => range,
        },
    };
    let function = match map {
        Map::Preset(preset) => Arc::new(preset.function(range.map(f64::from))),
        Map::Labels => {
            let first = range[0].floor().clamp(-1e9, 1e9) as i32;
            let numbers = (0..=(range[1] - range[0]).clamp(0.0, 4095.0) as i32).map(|i| first + i);
            Arc::new(TransferFunction::labels("labels", numbers)?)
        }
        Map::Elements => Arc::new(element_colors()?),
        Map::Function(function) => function,
    };
    Ok(ColorMap::new(&function, range))
}

fn opacity(all: &particles::Particles, look: &ParticleLook) -> Result<Opacity, ParticleError> {
    let factor = look.opacity.unwrap_or(1.0);
    if !(0.0..=1.0).contains(&factor) {
        return Err(ParticleError::Opacity(all.name.clone(), factor));
    }
    let Some(OpacityBy { name, curve }) = &look.opacity_by else { return Ok(Opacity::All(factor)) };
    known(all, name)?;
    let curve = curve.clone().unwrap_or_else(|| OpacityCurve::rising(range_of(all, name)));
    Ok(Opacity::By { attribute: name.clone(), curve: curve.scaled(factor) })
}

/// The least and the greatest finite value of an attribute in all steps that are in memory; 0 to 1 if there is none.
fn range_of(all: &particles::Particles, name: &str) -> [f32; 2] {
    let ends = |step: &Arc<ParticleStep>| {
        let values = &step.attribute(name)?.values;
        let finite = (0..values.len()).map(|i| values.get(i)).filter(|value| value.is_finite());
        finite.map(|value| [value; 2]).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    };
    all.read().filter_map(ends).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)]).unwrap_or([0.0, 1.0])
}
