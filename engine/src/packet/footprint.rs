//! How much of a surface a ray stands for (Amanatides, "Ray Tracing with Cones", 1984; Akenine-Moeller et al., "Texture Level of Detail
//! Strategies for Real-Time Ray Tracing", Ray Tracing Gems, 2019, section 20.3.4).

use glam::Vec3;

use super::column::vec3;

/// Surfaces count as seen at least as steeply: at grazing angles textures would be blurred along as far as they are across.
const LEAST_COSINE: f32 = 0.1;

/// The areas, in texture coordinates, that cones around rays cover of surfaces: one row a hit.
pub(super) struct Footprints<'a> {
    /// The cones' widths where the rays start, by how much they become wider, and how far the hits are.
    pub(super) cone_widths: &'a [f32],
    pub(super) spread: f32,
    pub(super) distances: &'a [f32],
    pub(super) directions: [&'a [f32]; 3],
    pub(super) geometric_normals: [&'a [f32]; 3],
    /// Derivatives of the position along the texture coordinates.
    pub(super) derivatives: [[&'a [f32]; 3]; 2],
}

impl Footprints<'_> {
    /// Of a surface without extent none.
    pub(super) fn areas(&self, out: &mut [f32]) {
        let [along_u, along_v] = &self.derivatives;
        for (i, out) in out.iter_mut().enumerate() {
            let width = self.cone_widths[i] + self.spread * self.distances[i];
            let cosine = vec3(&self.directions, i).dot(vec3(&self.geometric_normals, i)).abs().max(LEAST_COSINE);
            let unit: Vec3 = vec3(along_u, i).cross(vec3(along_v, i));
            let area = width * width / (cosine * unit.dot(unit).sqrt());
            *out = if area.is_finite() { area } else { 0.0 };
        }
    }
}
