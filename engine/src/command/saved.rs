//! What a window shows as a scene file: the one that it came from, or the options.

use std::path::Path;

use mobula::geometry::{OpacityCurve, Particles};
use mobula::light::Point;
use mobula::load::{FORMATS, Place, SavedParticles, SavedScene};
use mobula::scene::SceneDescription;
use mobula::stack::Scene;

use super::args::SceneOptions;
use super::particle_options::{Crop, ParticleOptions, Range, Tile};
use super::values::{self, BackgroundChoice};

/// The options that make the same whichever steps of time are in memory: with what was chosen of particles, and where there are steps that
/// are not in memory, with the light and the axis that follow from those that are.
pub(crate) fn options(
    options: &SceneOptions,
    particles: ParticleOptions,
    described: &SceneDescription,
    scene: &Scene,
    place: &Place,
) -> SceneOptions {
    let mut options = SceneOptions { particles, ..options.clone() };
    let mut all = scene.geometry.list().iter().filter_map(|one| one.downcast_ref::<Particles>());
    if all.any(|one| one.series().makes_steps()) {
        let light = scene.lights.first().and_then(|light| light.downcast_ref::<Point>());
        if let (true, None, Some(Point { position, .. })) = (described.lights.is_empty(), options.light, light) {
            options.light = Some(values::LightChoice::At(values::Point(place.back((*position).into()))));
        }
        options.up = values::UpChoice(Some(scene.up));
    }
    options
}

/// The scene, after it was decided what its volumes are shown as. None where no scene file can say what it is: one of several files is a
/// scene file, or something comes from standard input.
pub(crate) fn scene(
    options: &SceneOptions,
    scene: &SceneDescription,
    of_file: bool,
    place: Place,
) -> Option<SavedScene> {
    if options.scenes.iter().any(|name| name == Path::new("-")) {
        return None;
    }
    let mut saved = match (of_file, &options.scenes[..]) {
        (true, [file]) => SavedScene::of_file(file, place).ok()?,
        (true, _) => return None,
        (false, _) => SavedScene::of_objects(&scene.objects, place),
    };
    if !of_file {
        saved.describe_particles(&particles(&options.particles));
    }
    if let (false, Some(raw)) = (of_file, options.raw.raw()) {
        saved.describe_raw(&raw, is_raw);
    }
    if let (false, Some(raw)) = (of_file, options.raw.particles()) {
        saved.describe_raw_particles(&raw, is_raw);
    }
    let transfer = &options.volumes.transfer;
    saved.describe_volumes(&scene.objects, &scene.shown, |number| {
        transfer.get(number).or(transfer.last()).map(ToString::to_string)
    });
    if let Some(degrees) = options.smooth {
        saved.smooth(degrees);
    }
    match options.light {
        Some(values::LightChoice::At(values::Point(at))) => saved.light(at, Point::KEY.color.to_array()),
        Some(values::LightChoice::Camera) => saved.light_at_camera(),
        None => {}
    }
    if options.ground {
        saved.ground();
    }
    if let Some(fog) = &options.fog {
        saved.fog(&fog.value);
    }
    if let Some(background) = &options.background {
        match &background.value {
            BackgroundChoice::Plain(_) => saved.background(&background.words),
            BackgroundChoice::File(_) => saved.background_file(&background.words),
        }
    }
    Some(saved)
}

/// What the options say of particles.
fn particles(options: &ParticleOptions) -> SavedParticles {
    let ParticleOptions { radius, radius_by, tile, periodic_box, color_by, map, range, crop, opacity, opacity_by } =
        options;
    let points = |curve: &Option<OpacityCurve>| curve.as_ref().map(|curve| curve.points().to_vec());
    SavedParticles {
        radius: *radius,
        radius_by: radius_by.clone(),
        tile: tile.map(|Tile(times)| times),
        sides: periodic_box.map(|values::Lengths(sides)| sides),
        crops: crop.iter().map(|Crop { attribute, ranges }| (attribute.clone(), ranges.clone())).collect(),
        opacity: *opacity,
        opacity_by: opacity_by.as_ref().map(|by| (by.attribute.clone(), points(&by.curve))),
        color_by: color_by.clone(),
        map: map.as_ref().map(ToString::to_string),
        range: range.map(|Range(range)| range),
    }
}

/// Do only `--raw-dims` or `--raw-layout` say what is in a file?
fn is_raw(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    !FORMATS.iter().flat_map(|format| format.extensions).any(|end| name.ends_with(end)) && !name.starts_with("gen:")
}
