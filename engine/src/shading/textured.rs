//! What the textures of a material say at hits.

use glam::Vec3;

use crate::math::normalize;
use crate::packet::{Columns3, SubPacket, set_vec3, vec3};
use crate::scratch::lend;
use crate::stack::Material;

/// Tilts the shading normals of hits as the material's normal map says, if it has one.
pub(super) fn tilt_normals(material: &dyn Material, hits: &mut SubPacket<'_>) {
    let Some(bumps) = &material.maps().normal else { return };
    let tilted: &mut Columns3 = &mut lend(hits.width());
    hits.sample(&bumps.map, |i, texel| set_vec3(tilted, i, bumps.normal(texel)));
    hits.change_normals(|i, normal, [along_u, along_v]| tilt(normal, along_u, along_v, vec3(tilted, i)));
}

/// A normal whose parts are along the texture's width and height, at right angles to `normal`, and along that.
fn tilt(normal: Vec3, along_u: Vec3, along_v: Vec3, parts: Vec3) -> Vec3 {
    let flat = |v: Vec3| v - normal * normal.dot(v);
    let tilted = unit(flat(along_u)) * parts.x + unit(flat(along_v)) * parts.y + normal * parts.z;
    let square = tilted.dot(tilted);
    if square > 0.0 && square.is_finite() { normalize(tilted) } else { normal }
}

/// A vector at length 1; nothing of one that has no direction.
fn unit(v: Vec3) -> Vec3 {
    let square = v.dot(v);
    if square > 0.0 && square.is_finite() { v * (1.0 / square.sqrt()) } else { Vec3::ZERO }
}

/// How opaque hits are, by their geometry and the material's textures: one row a hit. `false` if all are opaque; then what is in `out`
/// means nothing.
pub(super) fn opacities(material: &dyn Material, hits: &mut SubPacket<'_>, out: &mut [f32]) -> bool {
    let own = hits.own_opacities(out);
    let Some(holes) = &material.maps().opacity else { return own };
    if !own {
        out.fill(1.0);
    }
    hits.sample(&holes.map, |i, texel| out[i] *= holes.opacity(texel));
    out.iter().any(|opacity| *opacity < 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_are_tilted_along_the_texture() {
        let (u, v) = (Vec3::new(2.0, 0.0, 0.5), Vec3::new(0.0, 3.0, 0.0));
        assert_eq!(tilt(Vec3::Z, u, v, Vec3::Z), Vec3::Z);
        assert!((tilt(Vec3::Z, u, v, Vec3::new(0.6, 0.0, 0.8)) - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
        assert!(
            (tilt(Vec3::Z, -u, v, Vec3::new(0.6, 0.0, 0.8)) - Vec3::new(-0.6, 0.0, 0.8)).length() < 1e-6,
            "mirrored"
        );
        for odd in [Vec3::ZERO, Vec3::Z, Vec3::NAN, Vec3::INFINITY] {
            assert_eq!(tilt(Vec3::Z, odd, odd, Vec3::new(0.6, 0.0, 0.8)), Vec3::Z);
        }
    }
}
