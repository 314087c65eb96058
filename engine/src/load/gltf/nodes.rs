//! The nodes of a document's scene: where they are, and the cameras and lights among them.

use std::f32::consts::PI;
use std::sync::Arc;

use glam::{DMat4, DVec3, Vec3};
use gltf::camera::Projection;
use gltf::khr_lights_punctual::Kind;
use gltf::{Document, Node};

use crate::camera::CameraKind;
use crate::light::{Directional, Light, Point, Spot};
use crate::load::Place;
use crate::scene::SceneDescription;
use crate::view::View;

/// A node, and how its own coordinates become those of the scene.
pub(super) struct Placed<'a> {
    pub(super) node: Node<'a>,
    pub(super) transform: DMat4,
}

/// The nodes of the scene that is to be shown, parents first. A node counts once, whatever a broken document says.
pub(super) fn placed(document: &Document) -> Vec<Placed<'_>> {
    let mut seen = vec![false; document.nodes().len()];
    let mut waiting: Vec<(Node<'_>, DMat4)> = Vec::new();
    let roots: Vec<Node<'_>> = match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => scene.nodes().collect(),
        None => document.nodes().collect(),
    };
    waiting.extend(roots.into_iter().rev().map(|node| (node, DMat4::IDENTITY)));
    let mut all = Vec::new();
    while let Some((node, parent)) = waiting.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            continue;
        }
        let columns = node.transform().matrix().map(|column| column.map(f64::from));
        let transform = parent * DMat4::from_cols_array_2d(&columns);
        let children: Vec<Node<'_>> = node.children().collect();
        waiting.extend(children.into_iter().rev().map(|child| (child, transform)));
        all.push(Placed { node, transform });
    }
    all
}

/// Looks through the first camera, if there is one, at what is before it.
pub(super) fn look(nodes: &[Placed<'_>], positions: &[[f64; 3]], place: &Place, scene: &mut SceneDescription) {
    let Some((node, camera)) = nodes.iter().find_map(|node| Some((node, node.node.camera()?))) else { return };
    let direction = |v: DVec3| node.transform.transform_vector3(v).normalize_or_zero();
    let (forward, up) = (direction(DVec3::NEG_Z), direction(DVec3::Y));
    let eye = node.transform.transform_point3(DVec3::ZERO);
    // What is looked at is as far as the middle of everything.
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for position in positions.iter().map(|&position| DVec3::from(position)).filter(|position| position.is_finite()) {
        (low, high) = (low.min(position), high.max(position));
    }
    let depth = (0.5 * (low + high) - eye).dot(forward);
    let size = (high - low).length();
    let depth = if depth > 1e-3 * size { depth } else { 0.5 * size };
    let (fov, kind) = match camera.projection() {
        Projection::Perspective(lens) => (lens.yfov().to_degrees(), CameraKind::Pinhole),
        Projection::Orthographic(lens) => {
            (2.0 * libm::atanf(lens.ymag().abs() / depth as f32).to_degrees(), CameraKind::Orthographic)
        }
    };
    let put = |p: DVec3| Vec3::from(place.put(p.to_array()));
    let (eye, at) = (put(eye), put(eye + forward * depth));
    let sound = eye.is_finite() && at.is_finite() && eye != at && up != DVec3::ZERO && (0.01..179.0).contains(&fov);
    if sound {
        scene.view = Some(View { eye, at, up: up.as_vec3(), fov });
        scene.rendering.camera = (kind != CameraKind::Pinhole).then_some(kind);
    }
}

/// Adds the lights. Radiance is that of a white surface: intensities over pi.
pub(super) fn light(nodes: &[Placed<'_>], place: &Place, scene: &mut SceneDescription) {
    for node in nodes {
        let Some(light) = node.node.light() else { continue };
        let color = Vec3::from(light.color()).max(Vec3::ZERO) * (light.intensity().max(0.0) / PI);
        let position = Vec3::from(place.put(node.transform.transform_point3(DVec3::ZERO).to_array()));
        let backward = node.transform.transform_vector3(DVec3::Z).normalize_or_zero().as_vec3();
        if !(color.is_finite() && position.is_finite()) {
            continue;
        }
        let scale = (place.scale * place.scale) as f32;
        let light: Option<Arc<dyn Light>> = match light.kind() {
            Kind::Directional => {
                (backward != Vec3::ZERO).then(|| Arc::new(Directional { direction: backward, color }) as _)
            }
            Kind::Point => Some(Arc::new(Point { position, color: color * scale, falloff: true })),
            Kind::Spot { inner_cone_angle, outer_cone_angle } => (backward != Vec3::ZERO).then(|| {
                let [inner, outer] = [inner_cone_angle, outer_cone_angle].map(f32::to_degrees);
                Arc::new(Spot { position, direction: -backward, color: color * scale, inner, outer, falloff: true })
                    as _
            }),
        };
        scene.lights.extend(light);
    }
}
