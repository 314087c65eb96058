//! Hits as geometry sees them, and what it tells of the surface there (paper 5.1.4).

use glam::Vec3;
use mobula_core::simd::AnyToken;

use super::column::vec3;

/// Neighbouring rays of a packet that all hit one geometry: one row a ray in every slice.
#[derive(Clone, Copy, Debug)]
pub struct Hits<'a> {
    /// The level to work at; the results are the same at all.
    pub token: AnyToken,
    /// Where the rays start.
    pub origins: [&'a [f32]; 3],
    /// Where they go.
    pub directions: [&'a [f32]; 3],
    /// How far to the hits, in lengths of the directions.
    pub t: &'a [f32],
    /// Which primitives of the geometry were hit.
    pub primitives: &'a [u32],
}

impl Hits<'_> {
    /// Number of hits.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.primitives.len()
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.primitives.is_empty()
    }

    /// Origin and direction of ray `i`.
    #[inline(always)]
    pub fn ray(&self, i: usize) -> (Vec3, Vec3) {
        (vec3(&self.origins, i), vec3(&self.directions, i))
    }

    /// Where ray `i` hit.
    #[inline(always)]
    pub fn position(&self, i: usize) -> Vec3 {
        let (origin, direction) = self.ray(i);
        origin + direction * self.t[i]
    }
}

/// Who can tell about the surface at hits. Implemented by geometry; asked through a [`SubPacket`](super::SubPacket), at most once a
/// value. Every method fills one row a hit. What it says of a hit must depend on that hit alone, so that packets of all widths
/// give one picture.
pub trait Surface {
    /// Unit normals of the true geometry. Which side they face is the geometry's.
    ///
    /// And how large the numbers are that the position of a hit follows from, beside the coordinates and the distance: rounding errors
    /// are measured by it. The longest edge (its greatest coordinate) of a triangle, the radius of a sphere.
    fn geometric_normals(&self, hits: &Hits<'_>, out: [&mut [f32]; 3], error_scales: &mut [f32]);

    /// Unit shading normals (interpolated where there are vertex normals). `false` if they are the geometric ones: then it need not
    /// write any.
    fn normals(&self, _hits: &Hits<'_>, _out: [&mut [f32]; 3]) -> bool {
        false
    }

    /// Texture coordinates (two, and a third that is zero where unused); zero where the geometry has none.
    fn texture_coordinates(&self, _hits: &Hits<'_>, out: [&mut [f32]; 3]) {
        out.into_iter().for_each(|column| column.fill(0.0));
    }

    /// Derivatives of the position along two surface directions; zero where the geometry has none.
    fn derivatives(&self, _hits: &Hits<'_>, out: [[&mut [f32]; 3]; 2]) {
        out.into_iter().flatten().for_each(|column| column.fill(0.0));
    }

    /// Colours of the geometry's own, linear RGB, by which its materials' diffuse colours are multiplied. `false` if it has none:
    /// then it need not write any.
    fn colors(&self, _hits: &Hits<'_>, _out: [&mut [f32]; 3]) -> bool {
        false
    }

    /// Of each hit, the distance to the nearest edge of its primitive, and the radius of the circle that fits into the primitive, in units of
    /// the scene. `false` if primitives have no edges: then it need not write any.
    fn edges(&self, _hits: &Hits<'_>, _out: [&mut [f32]; 2]) -> bool {
        false
    }

    /// Of each hit, the fraction of the light from behind that it stops, 0 to 1, whatever its material is; the material's colour counts
    /// by as much. `false` if all stop all of it: then it need not write any.
    fn opacities(&self, _hits: &Hits<'_>, _out: &mut [f32]) -> bool {
        false
    }
}
