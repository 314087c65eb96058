//! Triangles as plain data, shared by all packet widths.

use super::DEFAULT_MATERIAL;

/// "None", as an index of a normal or of texture coordinates.
pub const NO_INDEX: u32 = u32::MAX;

/// Triangles with shared corners. Every corner has an index into the positions, and may have others into the normals and
/// the texture coordinates, as OBJ files have them.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// What people call it.
    pub name: String,
    /// Corner positions.
    pub positions: Vec<[f32; 3]>,
    /// Corner normals, of any length; may be empty.
    pub normals: Vec<[f32; 3]>,
    /// Corner texture coordinates; may be empty.
    pub texture_coordinates: Vec<[f32; 2]>,
    /// Indices of three positions a triangle. Counter-clockwise seen from outside, though nothing relies on it.
    pub triangles: Vec<[u32; 3]>,
    /// Indices of three normals a triangle, [`NO_INDEX`] where there is none. Empty, or as long as `triangles`.
    pub triangle_normals: Vec<[u32; 3]>,
    /// Indices of three texture coordinates a triangle, [`NO_INDEX`] where there is none. Empty, or as long as
    /// `triangles`.
    pub triangle_texture_coordinates: Vec<[u32; 3]>,
    /// Index of each triangle's material. Empty (all have [`material`](Self::material)), or as long as `triangles`.
    pub materials: Vec<u32>,
    /// Index of the material of all triangles, where `materials` is empty.
    pub material: u32,
    /// Named runs of triangles, in order, as the file had them; may be empty.
    pub groups: Vec<MeshGroup>,
}

/// A named run of a mesh's triangles.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshGroup {
    /// What its file calls it.
    pub name: String,
    /// Its first triangle.
    pub first: u32,
    /// How many triangles it has.
    pub count: u32,
}

impl Default for Mesh {
    fn default() -> Self {
        Self {
            name: String::new(),
            positions: Vec::new(),
            normals: Vec::new(),
            texture_coordinates: Vec::new(),
            triangles: Vec::new(),
            triangle_normals: Vec::new(),
            triangle_texture_coordinates: Vec::new(),
            materials: Vec::new(),
            material: DEFAULT_MATERIAL,
            groups: Vec::new(),
        }
    }
}

impl Mesh {
    /// Positions of the three corners of triangle `i`; `None` if an index is out of range.
    #[inline]
    pub fn corners(&self, i: usize) -> Option<[glam::Vec3; 3]> {
        let [a, b, c] = *self.triangles.get(i)?;
        let at = |index: u32| self.positions.get(index as usize).map(|&p| glam::Vec3::from(p));
        Some([at(a)?, at(b)?, at(c)?])
    }

    /// Index of the material of triangle `i`.
    #[inline]
    pub fn material_of(&self, i: usize) -> u32 {
        self.materials.get(i).copied().unwrap_or(self.material)
    }
}
