//! Spheres as plain data, shared by all packet widths.

use super::DEFAULT_MATERIAL;

/// Spheres: particles, atoms, balls.
#[derive(Clone, Debug)]
pub struct Spheres {
    /// What people call them.
    pub name: String,
    /// Centres.
    pub centers: Vec<[f32; 3]>,
    /// Radii: one of each sphere, or a single one for all.
    pub radii: Vec<f32>,
    /// Colour of each sphere, linear RGB: what its material's diffuse colour is multiplied by. May be empty (white).
    pub colors: Vec<[f32; 3]>,
    /// Index of each sphere's material. Empty (all have [`material`](Self::material)), or as long as `centers`.
    pub materials: Vec<u32>,
    /// Index of the material of all spheres, where `materials` is empty.
    pub material: u32,
}

impl Default for Spheres {
    fn default() -> Self {
        Self {
            name: String::new(),
            centers: Vec::new(),
            radii: Vec::new(),
            colors: Vec::new(),
            materials: Vec::new(),
            material: DEFAULT_MATERIAL,
        }
    }
}

impl Spheres {
    /// Centre and radius of sphere `i`; `None` if it has none.
    #[inline]
    pub fn sphere(&self, i: usize) -> Option<(glam::Vec3, f32)> {
        let center = *self.centers.get(i)?;
        let radius = if self.radii.len() == 1 { self.radii[0] } else { *self.radii.get(i)? };
        Some((center.into(), radius))
    }

    /// Index of the material of sphere `i`.
    #[inline]
    pub fn material_of(&self, i: usize) -> u32 {
        self.materials.get(i).copied().unwrap_or(self.material)
    }
}
