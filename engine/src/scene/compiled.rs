//! A scene made ready for one packet width.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::{AnyHitPacket, Hits, NO_HIT, RayPacket, SubPacket, Surface};

use super::{Geometry, LightDescription, MaterialDescription, SceneDescription, SceneError};
use crate::accel::AccelerationKind;
use crate::camera::{Up, View};
use crate::pipeline::fault::scope;
use crate::stack::{AccelerationStructure, Background, Context, Light, Material, NeedsRebuild};
use crate::{background, light, material};

/// All that rays meet: geometry, an acceleration structure over it, materials, lights, background.
///
/// Materials, lights and background may be replaced between frames; geometry and structure belong together.
pub struct Scene<const N: usize> {
    /// What primitives' material indices refer to; the last one is the default material.
    materials: Vec<Arc<dyn Material<N>>>,
    /// What faults in them are called.
    material_names: Vec<String>,
    /// Where light comes from.
    pub lights: Vec<Arc<dyn Light<N>>>,
    /// Light that comes from everywhere.
    pub ambient: light::Ambient,
    /// What is seen where nothing is.
    pub background: Arc<dyn Background<N>>,
    /// Are lights tested for what stands before them?
    pub shadows: bool,
    geometry: Arc<Geometry>,
    acceleration: Box<dyn AccelerationStructure<N>>,
    up: Up,
    view: Option<View>,
}

impl<const N: usize> Scene<N> {
    /// Compiles a description. What is wrong with it is left out and told by
    /// [`Geometry::report`]; a missing material becomes the default one.
    pub fn build(description: &SceneDescription, kind: AccelerationKind) -> Result<Self, SceneError> {
        Ok(Self::with_geometry(description, Arc::new(Geometry::new(&description.objects)?), kind))
    }

    /// As [`build`](Self::build), with the geometry of the same description, which may be shared between packet widths.
    pub fn with_geometry(description: &SceneDescription, geometry: Arc<Geometry>, kind: AccelerationKind) -> Self {
        let up = description.up.unwrap_or_else(|| Up::guess(geometry.bounds()));
        let default = MaterialDescription::default();
        let materials = description.materials.iter().map(|named| &named.material).chain([&default]);
        let names = description.materials.iter().map(|named| named.name.as_str()).chain(["default"]);
        let casts_shadow =
            |index: u32| description.materials.get(index as usize).is_none_or(|named| named.material.casts_shadow());
        let lights = match &description.lights[..] {
            [] => default_lights(geometry.bounds(), up),
            lights => lights.to_vec(),
        };
        Self {
            materials: materials.map(material::build).collect(),
            material_names: names.map(|name| format!("material {name}")).collect(),
            lights: lights.iter().map(light::build).collect(),
            ambient: light::Ambient::new(&description.ambient, up),
            background: background::build(&description.background, up),
            shadows: true,
            acceleration: kind.build(&geometry, &casts_shadow),
            geometry,
            up,
            view: description.view,
        }
    }

    /// Finds the nearest hit of each active ray, and its material.
    pub fn intersect(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        packet.check();
        scope("acceleration structure", || self.acceleration.intersect(context, packet));
        let default = self.materials.len() as u32 - 1;
        let (range, mut near) = (packet.range(), 0);
        let Hits { primitive, material } = &mut packet.hits;
        for (material, &primitive) in material[range.clone()].iter_mut().zip(&primitive[range]) {
            if primitive != NO_HIT {
                *material = self.geometry.material(primitive, &mut near).min(default);
            }
        }
    }

    /// Finds which rays hit anything.
    pub fn occlude(&self, context: &Context<'_, N>, packet: &mut AnyHitPacket<N>) {
        packet.check();
        scope("acceleration structure", || self.acceleration.occlude(context, packet));
    }

    /// Colours rays that all hit the same material, or nothing.
    pub fn shade(&self, context: &Context<'_, N>, material: Option<u32>, rays: &mut SubPacket<'_, N>) {
        match material {
            None => scope("background", || self.background.shade(context, rays)),
            Some(index) => {
                let name = self.material_names.get(index as usize).map_or("material", String::as_str);
                scope(name, || self.material(index).shade(context, rays));
            }
        }
    }

    /// The material of an index that [`intersect`](Self::intersect) filled in.
    pub fn material(&self, index: u32) -> &dyn Material<N> {
        &*self.materials[(index as usize).min(self.materials.len() - 1)]
    }

    /// Replaces a material. Does nothing if there is no such index. Which materials cast shadows was settled when the
    /// scene was built.
    pub fn set_material(&mut self, index: u32, material: Arc<dyn Material<N>>) {
        if let Some(place) = self.materials.get_mut(index as usize) {
            *place = material;
        }
    }

    /// Who knows the surface at a hit.
    pub fn surface(&self) -> &dyn Surface<N> {
        &*self.geometry
    }

    /// All primitives.
    pub fn geometry(&self) -> &Arc<Geometry> {
        &self.geometry
    }

    /// Replaces the geometry by one whose primitives are the same, at other places, and
    /// [refits](AccelerationStructure::refit) the acceleration structure: what animation calls before a frame.
    ///
    /// # Errors
    /// [`NeedsRebuild`] if the primitives are not the same; then nothing has changed.
    pub fn refit(&mut self, geometry: Arc<Geometry>) -> Result<(), NeedsRebuild> {
        self.acceleration.refit(&geometry)?;
        self.geometry = geometry;
        Ok(())
    }

    /// Which way is up.
    pub fn up(&self) -> Up {
        self.up
    }

    /// Where to look from, for an image whose width is `aspect` times its height: as the description says, or so that
    /// everything is seen.
    pub fn view(&self, aspect: f32) -> View {
        self.view.unwrap_or_else(|| self.framed(aspect))
    }

    /// The view that shows everything.
    pub fn framed(&self, aspect: f32) -> View {
        View::frame_points(self.geometry.extremes(), self.geometry.bounds(), self.up, aspect)
    }
}

impl<const N: usize> std::fmt::Debug for Scene<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let materials = self.materials.len();
        f.debug_struct("Scene")
            .field("materials", &materials)
            .field("geometry", &self.geometry.report())
            .finish_non_exhaustive()
    }
}

/// The lights of a scene that has none: a key light from the upper left of the default view, far enough for even light,
/// near enough that its shadow rays share an origin.
fn default_lights((low, high): (Vec3, Vec3), up: Up) -> Vec<LightDescription> {
    let radius = (high * 0.5 - low * 0.5).length();
    let (middle, radius) = if radius.is_finite() && low.cmple(high).all() {
        (low * 0.5 + high * 0.5, radius.max(f32::MIN_POSITIVE))
    } else {
        (Vec3::ZERO, 1.0)
    };
    let position = middle + up.from_y_up(Vec3::new(-1.6, 3.4, 3.0)) * radius;
    if position.is_finite() {
        vec![LightDescription::Point { position, color: Vec3::new(0.95, 0.90, 0.82), falloff: false }]
    } else {
        vec![LightDescription::Directional { direction: up.vector(), color: Vec3::splat(0.9) }]
    }
}
