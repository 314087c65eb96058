//! A scene made ready to be rendered.

use std::sync::Arc;

use glam::Vec3;

use super::SceneDescription;
use super::bulk::{SAMPLES, bulk};
use super::front::quarter_turns;
use crate::accel::AccelerationKind;
use crate::geometry::{Geometries, SceneError};
use crate::light::{Directional, Light, Point};
use crate::material::{Lambertian, NamedMaterial};
use crate::stack::{Materials, Scene, bounds};
use crate::view::Up;

/// Builds a scene from its description. What is wrong with it is left out and told by the
/// [census](Geometries::census); a missing material becomes the default one.
///
/// # Errors
/// If a geometry has more primitives than there are numbers.
pub fn build(description: &SceneDescription, kind: AccelerationKind) -> Result<Scene, SceneError> {
    Ok(with_geometry(description, Geometries::build(description.geometry.clone(), &kind.into())?))
}

/// As [`build`], with the geometry of the same description.
pub fn with_geometry(description: &SceneDescription, mut geometry: Geometries) -> Scene {
    let media = &description.media;
    let of_media = |visit: &mut dyn FnMut(Vec3)| media.iter().for_each(|medium| medium.extremes(visit));
    let some = |visit: &mut dyn FnMut(Vec3)| {
        geometry.some_extremes(4 * SAMPLES, visit);
        of_media(visit);
    };
    let all = |visit: &mut dyn FnMut(Vec3)| {
        geometry.extremes(visit);
        of_media(visit);
    };
    let bulk = bulk(some, all, bounds(&geometry, media));
    let up = description.up.unwrap_or_else(|| Up::guess(bulk));
    let turns = if description.view.is_none() { quarter_turns(&geometry, bulk, up) } else { 0 };
    let mut materials = description.materials.clone();
    let ground = description.ground.and_then(|ground| ground.build(bulk, up, materials.len() as u32));
    if let Some((ground, surface)) = ground {
        geometry.stand_on(ground, &AccelerationKind::Bvh.into());
        materials.push(NamedMaterial { name: "ground".to_owned(), material: surface });
    }
    let default = NamedMaterial { name: "default".to_owned(), material: Arc::new(Lambertian::default()) };
    let mut lights = description.lights.clone();
    let mut ambient = description.ambient.clone();
    match description.background.light(up) {
        Some(sky) => {
            lights.extend(sky.lights);
            ambient = sky.ambient;
        }
        None if lights.is_empty() => lights.push(default_light(bulk, up, turns)),
        None => {}
    }
    materials.push(default);
    Scene {
        materials: Materials::new(materials),
        lights,
        ambient,
        background: description.background.clone(),
        media: media.clone(),
        occlusion: None,
        shadows: true,
        geometry,
        up,
        turns,
        view: description.view,
        bulk,
    }
}

/// The light of a scene that has none: a key light from the upper left of the default view, far enough for even light,
/// near enough that its shadow rays share an origin.
fn default_light((low, high): (Vec3, Vec3), up: Up, turns: u8) -> Arc<dyn Light> {
    let radius = (high * 0.5 - low * 0.5).length();
    let (middle, radius) = if radius.is_finite() && low.cmple(high).all() {
        (low * 0.5 + high * 0.5, radius.max(f32::MIN_POSITIVE))
    } else {
        (Vec3::ZERO, 1.0)
    };
    let position = middle + up.turned(Vec3::new(-1.6, 3.4, 3.0), turns) * radius;
    if position.is_finite() {
        Arc::new(Point { position, ..Point::KEY })
    } else {
        Arc::new(Directional { direction: up.vector(), color: Vec3::splat(0.9) })
    }
}
