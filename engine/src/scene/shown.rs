//! What a volume is shown as, as plain data.

use std::sync::Arc;

use crate::geometry::shift_material;
use crate::medium::DEFAULT_STEP;
use crate::volume::{Preset, TransferFunction};

/// What a volume is shown as. The default is an iso-surface that parts what is dark from what is bright.
#[derive(Clone, Debug)]
pub struct Shown {
    /// Values of iso-surfaces. None: one is chosen, unless the volume is shown as a medium.
    pub iso: Vec<f64>,
    /// Index of the material of each iso-surface; where there is none, a colour is chosen.
    pub materials: Vec<Option<u32>>,
    /// How much light gets through each iso-surface without a material, from 0 to 1; the last is for all further ones.
    pub transparent: Vec<f32>,
    /// As which medium; none if it is not shown as one.
    pub transfer: Option<Transfer>,
    /// Level and width of the values that the transfer function is for; `None`: as it says.
    pub window: Option<[f64; 2]>,
    /// Is the medium lit? `None`: as goes with the transfer function.
    pub lit: Option<bool>,
    /// The longest step of rays through the medium, in units of cells.
    pub step_length: f32,
    /// Where the first sample is; `None`: where it is.
    pub origin: Option<[f32; 3]>,
    /// Planes (a, b, c, d): where a x + b y + c z > d, nothing is seen.
    pub cuts: Vec<[f64; 4]>,
}

impl Default for Shown {
    fn default() -> Self {
        Self {
            iso: Vec::new(),
            materials: Vec::new(),
            transparent: Vec::new(),
            transfer: None,
            window: None,
            lit: None,
            step_length: DEFAULT_STEP,
            origin: None,
            cuts: Vec::new(),
        }
    }
}

impl Shown {
    /// Adds `shift` to all indices of materials.
    pub(super) fn shift_materials(&mut self, shift: u32) {
        self.materials.iter_mut().flatten().for_each(|index| shift_material(index, shift));
    }
}

/// A transfer function, as far as it is known before the volume is.
#[derive(Clone, Debug)]
pub enum Transfer {
    /// One that has a name.
    Preset(Preset),
    /// A colour for each whole number.
    Labels,
    /// This one.
    Function(Arc<TransferFunction>),
}
