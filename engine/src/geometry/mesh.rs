//! Triangles with shared corners.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::leaf::{Block, TriangleBlock};

use super::triangle::{Interpolated, Planes, barycentric, normal_f64, surely_has_area, to_edges};
use super::{Census, DEFAULT_MATERIAL, Geometry, InTree, Item, Structure, Tree, draw, shift_material};
use crate::accel::Build;
use crate::packet::{Hits, Surface, set_vec3};

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
    /// Colours of corners, linear RGB, by which materials' diffuse colours are multiplied. Empty, or as long as `positions`.
    pub colors: Vec<[f32; 3]>,
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
            colors: Vec::new(),
            triangles: Vec::new(),
            triangle_normals: Vec::new(),
            triangle_texture_coordinates: Vec::new(),
            materials: Vec::new(),
            material: DEFAULT_MATERIAL,
            groups: Vec::new(),
        }
    }
}

const DEGENERATE: Item = Item::left_out("degenerate_triangles", "triangle without area", "triangles without area");
const NOT_FINITE: Item =
    Item::left_out("non_finite_triangles", "triangle that is not finite", "triangles that are not finite");
const OUT_OF_RANGE: Item =
    Item::left_out("triangles_without_corners", "triangle without a corner", "triangles without a corner");

impl Mesh {
    /// What a census counts: corner positions.
    pub const VERTICES: Item = Item::detail("vertices", "vertex", "vertices");
    /// What a census counts: corner normals.
    pub const NORMALS: Item = Item::detail("normals", "normal", "normals");
    /// What a census counts: corner normals that [`smooth`](Self::smooth) made.
    pub const MADE_NORMALS: Item = Item::detail("made_normals", "normal made", "normals made");
    /// What a census counts: corner texture coordinates.
    pub const TEXTURE_COORDINATES: Item =
        Item::detail("texture_coordinates", "texture coordinate", "texture coordinates");
    /// What a census counts: polygons, before they are cut into triangles.
    pub const FACES: Item = Item::detail("faces", "face", "faces");
    /// What a census counts: triangles.
    pub const TRIANGLES: Item = Item::primitives("triangles", "triangle", "triangles");
    /// What a census counts: named runs of triangles.
    pub const GROUPS: Item = Item::detail("groups", "group", "groups");

    /// A tetrahedron with smooth normals.
    pub fn example(material: u32) -> Self {
        let corners = vec![[-0.6, -0.6, -0.6], [0.6, 0.6, -0.6], [0.6, -0.6, 0.6], [-0.6, 0.6, 0.6]];
        let triangles = vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
        Self {
            name: "tetrahedron".to_owned(),
            normals: corners.clone(),
            positions: corners,
            triangle_normals: triangles.clone(),
            triangles,
            material,
            ..Self::default()
        }
    }

    /// Positions of the three corners of triangle `i`; `None` if an index is out of range.
    #[inline(always)]
    pub fn corners(&self, i: usize) -> Option<[Vec3; 3]> {
        let [a, b, c] = *self.triangles.get(i)?;
        let at = |index: u32| self.positions.get(index as usize).map(|&p| Vec3::from(p));
        Some([at(a)?, at(b)?, at(c)?])
    }

    /// Index of the material of triangle `i`.
    #[inline]
    pub fn material_of(&self, i: usize) -> u32 {
        self.materials.get(i).copied().unwrap_or(self.material)
    }

    /// Adds `shift` to all indices of materials but [`DEFAULT_MATERIAL`].
    pub(super) fn shift_own_materials(&mut self, shift: u32) {
        shift_material(&mut self.material, shift);
        self.materials.iter_mut().for_each(|index| shift_material(index, shift));
    }

    /// The corners of triangle `i`, or why it is left out.
    #[inline(always)]
    fn triangle(&self, i: usize) -> Result<[Vec3; 3], Item> {
        let corners = self.corners(i).ok_or(OUT_OF_RANGE)?;
        if surely_has_area(corners) { Ok(corners) } else { doubtful(corners) }
    }

    /// A census with what looking at the triangles found.
    fn counted(&self, found: &Census) -> Census {
        let mut census = Census::default();
        census.add(Self::VERTICES, self.positions.len() as u64);
        census.add(Self::NORMALS, self.normals.len() as u64);
        census.add(Self::TEXTURE_COORDINATES, self.texture_coordinates.len() as u64);
        census.add(Self::FACES, self.triangles.len() as u64);
        census.add(Self::TRIANGLES, self.triangles.len() as u64);
        census.merge(found);
        census.add(Self::GROUPS, self.groups.len() as u64);
        census
    }

    /// The three corner normals of triangle `i`, if it has them all.
    #[inline(always)]
    fn corner_normals(&self, i: usize) -> Option<[Vec3; 3]> {
        let [a, b, c] = *self.triangle_normals.get(i)?;
        let at = |index: u32| self.normals.get(index as usize).map(|&n| Vec3::from(n));
        Some([at(a)?, at(b)?, at(c)?])
    }

    /// The three corners' texture coordinates of triangle `i`, if it has them all.
    #[inline(always)]
    fn corner_texture_coordinates(&self, i: usize) -> Option<[Vec3; 3]> {
        let [a, b, c] = *self.triangle_texture_coordinates.get(i)?;
        let at = |index: u32| self.texture_coordinates.get(index as usize).map(|&[u, v]| Vec3::new(u, v, 0.0));
        Some([at(a)?, at(b)?, at(c)?])
    }

    /// The derivatives of the position in triangle `i`.
    fn triangle_derivatives(&self, i: usize) -> [Vec3; 2] {
        let [a, b, c] = self.corners(i).unwrap_or_default();
        let (e1, e2) = (b - a, c - a);
        let Some([ta, tb, tc]) = self.corner_texture_coordinates(i) else {
            return [e1, e2];
        };
        let (d1, d2) = (tb - ta, tc - ta);
        let determinant = d1.x * d2.y - d1.y * d2.x;
        let scale = 1.0 / determinant;
        if !scale.is_finite() {
            return [e1, e2];
        }
        [(e1 * d2.y - e2 * d1.y) * scale, (e2 * d1.x - e1 * d2.x) * scale]
    }
}

/// The corners of a triangle that may have no area, or why it is left out.
#[cold]
fn doubtful(corners: [Vec3; 3]) -> Result<[Vec3; 3], Item> {
    if !corners.iter().all(|p| p.is_finite()) {
        return Err(NOT_FINITE);
    }
    if normal_f64(corners) == [0.0; 3] { Err(DEGENERATE) } else { Ok(corners) }
}

impl InTree for Mesh {
    type Leaf = TriangleBlock;

    #[inline(always)]
    fn primitive(&self, i: usize) -> Option<[[f32; 3]; 3]> {
        self.triangle(i).ok().map(|corners| corners.map(|p| p.to_array()))
    }

    #[inline(always)]
    fn sound(&self, i: usize) -> [[f32; 3]; 3] {
        self.corners(i).map_or(TriangleBlock::NOWHERE, |corners| corners.map(|p| p.to_array()))
    }
}

impl Geometry for Mesh {
    fn name(&self) -> &str {
        &self.name
    }

    fn primitives(&self) -> usize {
        self.triangles.len()
    }

    fn census(&self) -> Census {
        let mut found = Census::default();
        for i in 0..self.triangles.len() {
            match self.triangle(i) {
                Ok(corners) => corners.into_iter().for_each(|corner| found.include(corner, 0.0)),
                Err(reason) => found.add(reason, 1),
            }
        }
        self.counted(&found)
    }

    fn counts(&self) -> Option<Census> {
        Some(self.counted(&Census::default()))
    }

    fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        self.some_extremes(1, visit);
    }

    fn some_extremes(&self, step: usize, visit: &mut dyn FnMut(Vec3)) {
        draw(self.triangles.len(), step).filter_map(|i| self.triangle(i).ok()).flatten().for_each(visit);
    }

    fn materials(&self, primitives: &[u32], out: &mut [u32]) -> Option<u32> {
        if self.materials.is_empty() {
            return Some(self.material);
        }
        for (out, &primitive) in out.iter_mut().zip(primitives) {
            *out = self.material_of(primitive as usize);
        }
        None
    }

    fn shift_materials(mut self: Arc<Self>, shift: u32) -> Arc<dyn Geometry> {
        Arc::make_mut(&mut self).shift_own_materials(shift);
        self
    }

    fn structure(&self, members: &[Arc<dyn Geometry>], build: &Build) -> Box<dyn Structure> {
        Box::new(Tree::<Self>::build(members, build))
    }
}

impl Surface for Mesh {
    /// Towards the side from which the corners are counter-clockwise; the greatest coordinate of the longest edge.
    fn geometric_normals(&self, hits: &Hits<'_>, out: [&mut [f32]; 3], error_scales: &mut [f32]) {
        let corners = |k: u32| self.corners(k as usize);
        hits.token.run(Planes { primitives: hits.primitives, corners, normals: out, extents: error_scales });
    }

    /// Interpolated where all corners have normals.
    fn normals(&self, hits: &Hits<'_>, out: [&mut [f32]; 3]) -> bool {
        if self.triangle_normals.is_empty() {
            return false;
        }
        let (corners, corner_normals) = (|k: u32| self.corners(k as usize), |k: u32| self.corner_normals(k as usize));
        hits.token.run(Interpolated { hits, corners, corner_normals, out });
        true
    }

    /// Interpolated, zero where there are none.
    fn texture_coordinates(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3]) {
        for (i, &k) in hits.primitives.iter().enumerate() {
            let k = k as usize;
            let at = self.corner_texture_coordinates(k).map_or(Vec3::ZERO, |[a, b, c]| {
                let [u, v, w] = barycentric(self.corners(k).unwrap_or_default(), hits.ray(i));
                a * u + b * v + c * w
            });
            set_vec3(&mut out, i, at);
        }
    }

    /// Along the texture coordinates, or along two edges where there are none.
    fn derivatives(&self, hits: &Hits<'_>, [mut out_u, mut out_v]: [[&mut [f32]; 3]; 2]) {
        for (i, &k) in hits.primitives.iter().enumerate() {
            let [du, dv] = self.triangle_derivatives(k as usize);
            set_vec3(&mut out_u, i, du);
            set_vec3(&mut out_v, i, dv);
        }
    }

    fn edges(&self, hits: &Hits<'_>, [distances, radii]: [&mut [f32]; 2]) -> bool {
        for (i, &k) in hits.primitives.iter().enumerate() {
            let corners = self.corners(k as usize).unwrap_or_default();
            (distances[i], radii[i]) = to_edges(corners, hits.ray(i));
        }
        true
    }

    /// Interpolated, if corners have colours.
    fn colors(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3]) -> bool {
        if self.colors.is_empty() {
            return false;
        }
        for (i, &k) in hits.primitives.iter().enumerate() {
            let color = |index: u32| self.colors.get(index as usize).map_or(Vec3::ONE, |&color| Vec3::from(color));
            let at = self.triangles.get(k as usize).zip(self.corners(k as usize)).map_or(Vec3::ONE, |(of, corners)| {
                let ([a, b, c], [u, v, w]) = (of.map(color), barycentric(corners, hits.ray(i)));
                a * u + b * v + c * w
            });
            set_vec3(&mut out, i, at);
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use mobula_core::simd::AnyToken;

    use super::*;
    use crate::packet::{columns3, part_mut, vec3};

    fn mesh() -> Mesh {
        Mesh {
            positions: vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 2.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            texture_coordinates: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
            colors: vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            triangles: vec![[0, 1, 2]],
            triangle_normals: vec![[0, 1, 2]],
            triangle_texture_coordinates: vec![[0, 1, 2]],
            ..Mesh::default()
        }
    }

    #[test]
    fn triangles_interpolate_what_their_corners_have() {
        let hits = Hits {
            token: AnyToken::detect(),
            origins: [&[1.0], &[1.0], &[5.0]],
            directions: [&[0.0], &[0.0], &[-1.0]],
            t: &[5.0],
            primitives: &[0],
        };
        let (mesh, mut out, mut second) = (mesh(), columns3(1), columns3(1));
        let mut scale = [0.0];
        mesh.geometric_normals(&hits, part_mut(&mut out, 0..1), &mut scale);
        assert_eq!((vec3(&out, 0), scale), (Vec3::Z, [4.0]));
        // Weights 1/4, 1/4, 1/2.
        mesh.texture_coordinates(&hits, part_mut(&mut out, 0..1));
        assert!((vec3(&out, 0) - Vec3::new(0.25, 0.5, 0.0)).length() < 1e-6);
        mesh.normals(&hits, part_mut(&mut out, 0..1));
        assert!((vec3(&out, 0) - Vec3::new(2.0, 2.0, 1.0) / 3.0).length() < 1e-6);
        mesh.derivatives(&hits, [part_mut(&mut out, 0..1), part_mut(&mut second, 0..1)]);
        assert_eq!((vec3(&out, 0), vec3(&second, 0)), (Vec3::X * 4.0, Vec3::Y * 2.0));
        assert!(mesh.colors(&hits, part_mut(&mut out, 0..1)));
        assert!((vec3(&out, 0) - Vec3::new(0.25, 0.25, 0.5)).length() < 1e-6);
    }

    #[test]
    fn bad_triangles_are_counted_and_left_out() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [f32::NAN, 9.0, 9.0]];
        let triangles = vec![[0, 1, 2], [0, 1, 3], [0, 0, 1], [0, 1, 4], [0, 1, 5], [0, 1, u32::MAX], [2, 1, 3]];
        let mesh = Mesh { positions, triangles, ..Mesh::default() };
        let census = mesh.census();
        let keys = ["triangles", "degenerate_triangles", "non_finite_triangles", "triangles_without_corners"];
        assert_eq!(keys.map(|key| census.count(key)), [7, 2, 1, 2]);
        assert_eq!(census.left_out(), 5);
        assert_eq!(census.bounds, (Vec3::ZERO, Vec3::new(2.0, 1.0, 0.0)));
        assert_eq!((0..7).filter(|&i| mesh.primitive(i).is_some()).collect::<Vec<_>>(), [0, 6]);
    }

    #[test]
    fn tiny_and_huge_triangles_have_area() {
        for scale in [1e-30_f32, 1.0, 1e30] {
            let positions = vec![[0.0; 3], [scale, 0.0, 0.0], [0.0, scale, scale]];
            let mesh = Mesh { positions, triangles: vec![[0, 1, 2]], ..Mesh::default() };
            assert_eq!(mesh.census().left_out(), 0);
        }
    }
}
