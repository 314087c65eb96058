//! What particles are shown as, as plain data.

use std::sync::Arc;

use crate::geometry::{Cropping, OpacityCurve, shift_material};
use crate::volume::{Preset, TransferFunction};

/// What particles are shown as.
#[derive(Clone, Debug, Default)]
pub struct ParticleLook {
    /// The radius of all; `None`: their own, or a guess. With `radius_by`: what the values are multiplied by; `None`: 1.
    pub radius: Option<f32>,
    /// The attribute whose values are the radii.
    pub radius_by: Option<String>,
    /// How often they are repeated along each edge of their periodic box.
    pub tile: Option<[u32; 3]>,
    /// The edges of that box; `None`: as their file says.
    pub cell: Option<[[f32; 3]; 3]>,
    /// The index of their material; `None`: a plain one.
    pub material: Option<u32>,
    /// Which of them are shown.
    pub crops: Vec<Cropping>,
    /// In which colours.
    pub color: ColorBy,
    /// How opaque all are, 0 to 1; `None`: 1. With `opacity_by`: what its opacities are multiplied by.
    pub opacity: Option<f32>,
    /// The attribute that decides about opacities.
    pub opacity_by: Option<OpacityBy>,
}

/// An attribute that decides how opaque particles are.
#[derive(Clone, Debug, PartialEq)]
pub struct OpacityBy {
    /// Its name.
    pub name: String,
    /// The opacities of its values; `None`: from 0 for the least of all steps to 1 for the greatest.
    pub curve: Option<OpacityCurve>,
}

/// What decides about colours.
#[derive(Clone, Debug)]
pub enum ColorBy {
    /// The material.
    Material,
    /// An attribute.
    Attribute {
        /// Its name; `None`: elements, or the first one that is no part of a vector or a colour; without any, the material decides.
        name: Option<String>,
        /// Its colours; `None`: as goes with it.
        map: Option<Map>,
        /// Which values have the first and the last colour; `None`: the least and the greatest of all steps.
        range: Option<[f32; 2]>,
    },
}

impl Default for ColorBy {
    fn default() -> Self {
        Self::Attribute { name: None, map: None, range: None }
    }
}

/// A colour map.
#[derive(Clone, Debug)]
pub enum Map {
    /// One that has a name.
    Preset(Preset),
    /// A colour for each whole number.
    Labels,
    /// Those of atoms, by their numbers.
    Elements,
    /// This one.
    Function(Arc<TransferFunction>),
}

impl ParticleLook {
    /// Adds `shift` to the index of the material.
    pub(super) fn shift_materials(&mut self, shift: u32) {
        self.material.iter_mut().for_each(|index| shift_material(index, shift));
    }
}
