//! What is in a scene, as plain data: what loaders and the built-in scene produce, and `Scene::build` compiles.
//!
//! Nothing here knows the packet width. A description may be wrong in every way that a file can be wrong: indices out of
//! range, NaN, zero area. Building a scene from it counts what it had to leave out, and never panics.

use std::sync::Arc;

use glam::Vec3;

use super::{Mesh, Spheres};
use crate::camera::{Up, View};

/// "The scene's default material", as an index of a material. So does every index that is out of range.
pub const DEFAULT_MATERIAL: u32 = u32::MAX;

/// Everything that a picture needs, but the image size.
#[derive(Clone, Debug, Default)]
pub struct SceneDescription {
    /// What people call it: usually a file's name.
    pub name: String,
    /// What is seen.
    pub objects: Vec<Object>,
    /// What the objects' material indices refer to.
    pub materials: Vec<NamedMaterial>,
    /// Where light comes from; none gives the default lights, placed around the objects.
    pub lights: Vec<LightDescription>,
    /// Light that comes from everywhere.
    pub ambient: AmbientDescription,
    /// What is seen where nothing is.
    pub background: BackgroundDescription,
    /// Which way is up; `None` guesses from the bounds.
    pub up: Option<Up>,
    /// Where to look from; `None` frames all objects.
    pub view: Option<View>,
}

/// Something to see.
#[derive(Clone, Debug)]
pub enum Object {
    /// Triangles.
    Mesh(Arc<Mesh>),
    /// Spheres.
    Spheres(Arc<Spheres>),
    /// Several objects.
    Group(Vec<Object>),
}

/// A material and what its file calls it.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMaterial {
    /// Name, for people.
    pub name: String,
    /// What it looks like.
    pub material: MaterialDescription,
}

/// How a surface looks. Colours are linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub enum MaterialDescription {
    /// Constant colour, not lit.
    Flat {
        /// The colour.
        color: Vec3,
    },
    /// The same brightness from all directions.
    Lambertian {
        /// Fraction of the light that is scattered (MTL `Kd`).
        diffuse: Vec3,
    },
    /// Lambertian, a highlight, mirror reflection, thin transparency.
    Phong(PhongDescription),
    /// The shading normal as a colour, for looking at geometry.
    NormalColor,
}

/// What [`MaterialDescription::Phong`] needs. The names in brackets are those of MTL files.
#[derive(Clone, Debug, PartialEq)]
pub struct PhongDescription {
    /// Fraction of the light that is scattered (`Kd`).
    pub diffuse: Vec3,
    /// Strength of the highlight (`Ks`).
    pub specular: Vec3,
    /// Sharpness of the highlight (`Ns`), 0 to about 1000.
    pub shininess: f32,
    /// Fraction of the light that is mirrored, seen head on; it grows towards grazing angles. `illum 3` and above with a
    /// high `Ks` means some.
    pub reflection: f32,
    /// Fraction of the light that comes from behind, unbent (`1 - d`, `Tr`).
    pub transparency: f32,
    /// Index of refraction (`Ni`): how fast mirroring grows towards grazing angles where there is transparency.
    pub refractive_index: f32,
}

impl Default for PhongDescription {
    fn default() -> Self {
        Self {
            diffuse: Vec3::splat(0.7),
            specular: Vec3::ZERO,
            shininess: 30.0,
            reflection: 0.0,
            transparency: 0.0,
            refractive_index: 1.5,
        }
    }
}

impl Default for MaterialDescription {
    /// A light grey, matt.
    fn default() -> Self {
        Self::Lambertian { diffuse: Vec3::splat(0.7) }
    }
}

/// Where light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightDescription {
    /// From a point.
    Point {
        /// Where it is.
        position: Vec3,
        /// Radiance that arrives (without falloff), or arrives at distance 1 (with it); linear RGB.
        color: Vec3,
        /// Does it get weaker with the square of the distance?
        falloff: bool,
    },
    /// From infinitely far away: the sun.
    Directional {
        /// Towards the light; need not be of unit length.
        direction: Vec3,
        /// Radiance that arrives, linear RGB.
        color: Vec3,
    },
}

/// Light that comes from everywhere, without shadows: `below` from straight below, `above` from straight above, blended
/// by the shading normal's height. Equal colours make it constant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AmbientDescription {
    /// What a surface that faces up gets, linear RGB.
    pub above: Vec3,
    /// What a surface that faces down gets, linear RGB.
    pub below: Vec3,
}

impl Default for AmbientDescription {
    fn default() -> Self {
        Self { above: Vec3::new(0.30, 0.33, 0.38), below: Vec3::new(0.12, 0.11, 0.10) }
    }
}

/// What is seen where nothing is. Colours are linear RGB.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BackgroundDescription {
    /// The same everywhere.
    Constant {
        /// The colour.
        color: Vec3,
    },
    /// Blended by the height of the direction.
    Gradient {
        /// Straight up.
        zenith: Vec3,
        /// Level.
        horizon: Vec3,
        /// Straight down.
        nadir: Vec3,
    },
}

impl Default for BackgroundDescription {
    /// A pale sky over a warm floor.
    fn default() -> Self {
        Self::Gradient {
            zenith: Vec3::new(0.30, 0.45, 0.70),
            horizon: Vec3::new(0.80, 0.85, 0.90),
            nadir: Vec3::new(0.32, 0.30, 0.28),
        }
    }
}

impl SceneDescription {
    /// Adds a material and returns its index.
    pub fn add_material(&mut self, name: impl Into<String>, material: MaterialDescription) -> u32 {
        self.materials.push(NamedMaterial { name: name.into(), material });
        (self.materials.len() - 1) as u32
    }

    /// Adds everything of `other`, whose material indices it shifts; keeps its own name, lights, background, up and view
    /// where it has them.
    pub fn merge(&mut self, mut other: SceneDescription) {
        let shift = self.materials.len() as u32;
        other.objects.iter_mut().for_each(|object| object.shift_materials(shift));
        self.objects.append(&mut other.objects);
        self.materials.append(&mut other.materials);
        self.lights.append(&mut other.lights);
        self.up = self.up.or(other.up);
        self.view = self.view.or(other.view);
        if self.name.is_empty() {
            self.name = other.name;
        }
    }
}

impl Object {
    /// Adds `shift` to every material index but [`DEFAULT_MATERIAL`].
    fn shift_materials(&mut self, shift: u32) {
        let add = |index: &mut u32| {
            if *index != DEFAULT_MATERIAL {
                *index = index.saturating_add(shift);
            }
        };
        match self {
            Self::Mesh(mesh) => {
                let mesh = Arc::make_mut(mesh);
                add(&mut mesh.material);
                mesh.materials.iter_mut().for_each(add);
            }
            Self::Spheres(spheres) => {
                let spheres = Arc::make_mut(spheres);
                add(&mut spheres.material);
                spheres.materials.iter_mut().for_each(add);
            }
            Self::Group(objects) => objects.iter_mut().for_each(|object| object.shift_materials(shift)),
        }
    }
}
