//! Shadow rays: the one place that makes any-hit packets (paper 5.4: secondary rays are new packets).

use glam::Vec3;
use mobula_core::Properties;
use mobula_core::simd::{F32Lanes, MaskLanes, Task, Token};

use crate::lanes::{dot, load3, scale, select3, splat3, store3, sub};
use crate::lighting::{Illumination, Points, Receivers};
use crate::medium::attenuate;
use crate::packet::{AnyHitPacket, Column, Columns3, columns3, set_vec3, transmittance, vec3};
use crate::pipeline::fault::scope;
use crate::scratch::{ForWidth, lend};
use crate::stack::{Context, Light};

/// A light is near if it is within so many times the size of the scene: then shadow rays start at it.
const NEAR: f32 = 64.0;

/// What of `light` reaches `points`, which are its `receivers`, through the scene's medium and through surfaces that let light through. Rays whose surface faces away, or that something is in the way of, get no radiance;
/// so in the rows of others `out.radiance` may be used without a further test.
///
/// The rays of points that face the light are packed densely, in order, so that they stay as coherent as they were. From a
/// near point light they start at the light, which makes their origin common; else at the points. Directions are of unit
/// length in both cases. Shading points are offset from their surface (see [`Points::offset`]), so the whole interval up
/// to the point, or to the light, is tested.
///
/// Each primitive that lets light through and is in the way counts once: a sphere too, though light goes through its surface twice. A
/// ray that goes exactly through the common edge of two triangles meets both.
pub(super) fn illuminate(
    context: &Context<'_>,
    light: &dyn Light,
    points: &Points,
    receivers: Receivers<'_>,
    out: &mut Illumination,
) {
    scope("light", || light.illuminate(context, receivers, out));
    scope("medium", || attenuate(context, points.positions(), out));
    let from = light.position(context).filter(|&position| is_near(context, position));
    let aim: &mut Aim = &mut lend(context.width);
    context.token.run(Facing { points, from, out, aim });
    if !context.scene.shadows || aim.count == 0 {
        return;
    }

    let facing = &aim.facing[..aim.count];
    let packet: &mut AnyHitPacket = &mut lend(context.width);
    packet.reset(aim.count);
    let rays = packet.rays_mut();
    let directions = match from {
        Some(position) => {
            rays.set_common_origin(position);
            &aim.ends
        }
        None => {
            rays.origins_mut().into_iter().zip(&aim.ends).for_each(|(to, from)| pick(to, from, facing));
            &out.direction
        }
    };
    rays.directions_mut().into_iter().zip(directions).for_each(|(to, from)| pick(to, from, facing));
    pick(rays.t_max_mut(), &aim.distance, facing);
    // Coordinates near the end of what a float can hold give directions that are not.
    if aim.unit {
        rays.promise(Properties::NORMALIZED_DIRECTIONS);
    }

    let statistics = context.statistics;
    statistics.shadow.set(statistics.shadow.get() + aim.count as u64);
    context.scene.occlude(context, packet);
    for ((&i, &t_max), &depth) in facing.iter().zip(packet.rays().t_max()).zip(packet.depths()) {
        let i = usize::from(i);
        if t_max == f32::NEG_INFINITY {
            set_vec3(&mut out.radiance, i, Vec3::ZERO);
        } else if depth > 0 {
            let radiance = vec3(&out.radiance, i) * transmittance(depth);
            set_vec3(&mut out.radiance, i, radiance);
        }
    }
}

/// Takes the rows that are in a list of increasing numbers.
fn pick(to: &mut [f32], from: &[f32], rows: &[u16]) {
    if rows.last().is_some_and(|&last| usize::from(last) + 1 == rows.len()) {
        return to.copy_from_slice(&from[..rows.len()]);
    }
    to.iter_mut().zip(rows).for_each(|(to, &row)| *to = from[usize::from(row)]);
}

/// Which points face a light, and where rays between them and it go.
struct Aim {
    facing: Column<u16>,
    count: usize,
    /// From a near light, the directions to the points; else the starts of rays from them. One row a point, as the next.
    ends: Columns3,
    /// Lengths of the rays.
    distance: Column<f32>,
    /// Have the directions of all that face the light unit length?
    unit: bool,
}

impl ForWidth for Aim {
    fn for_width(width: usize) -> Self {
        let (facing, ends, distance) = (Column::new(width), columns3(width), Column::new(width));
        Self { facing, count: 0, ends, distance, unit: false }
    }
}

/// Finds the points that face a light, takes its radiance from the others, and aims.
struct Facing<'a> {
    points: &'a Points,
    /// Where the light is, if it is near.
    from: Option<Vec3>,
    out: &'a mut Illumination,
    aim: &'a mut Aim,
}

impl Task for Facing<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { points, from, out, aim } = self;
        let (zero, one) = (token.splat(0.0), token.splat(1.0));
        (aim.count, aim.unit) = (0, true);
        for at in (0..points.len()).step_by(T::LANES) {
            let to_light = load3(token, &out.direction, at);
            let (normal, geometric) =
                (load3(token, &points.normals(), at), load3(token, &points.geometric_normals(), at));
            let (cosine, geometric_cosine) = (dot(to_light, normal), dot(to_light, geometric));
            let facing = cosine.gt(zero) & geometric_cosine.gt(zero);
            let radiance =
                scale(load3(token, &out.radiance, at), soften(token, cosine, geometric_cosine, dot(normal, geometric)));
            store3(select3(facing, radiance, [zero; 3]), &mut out.radiance, at);
            let distance = token.load(&out.distance, at);
            let (ends, direction, length) = match from {
                Some(position) => {
                    let v = sub(points.offsets(token, at, 1.0, distance), splat3(token, position.to_array()));
                    let length = dot(v, v).sqrt();
                    let direction = scale(v, one / length);
                    (direction, direction, length)
                }
                None => (points.offsets(token, at, 1.0, zero), to_light, distance),
            };
            store3(ends, &mut aim.ends, at);
            length.store(&mut aim.distance, at);
            let unit = (dot(direction, direction) - one).abs().lt(token.splat(1e-5));
            aim.unit &= !facing.and_not(unit).any();
            let mut bits = facing.bits();
            while bits != 0 {
                aim.facing[aim.count] = (at + bits.trailing_zeros() as usize) as u16;
                aim.count += 1;
                bits &= bits - 1;
            }
        }
    }
}

/// How much of the light is left where a surface that seems round turns away from it, so that it does not end at the edge of a triangle:
/// the shading terminator of Chiang, Li and Burley, "Taming the Shadow Terminator", SIGGRAPH 2019 talks. 1 where the normals agree.
#[inline(always)]
fn soften<T: Token>(token: T, cosine: T::F32, geometric_cosine: T::F32, between: T::F32) -> T::F32 {
    let one = token.splat(1.0);
    let g = (geometric_cosine / (cosine * between)).min(one);
    g * (one + g * (one - g))
}

/// From a light that is much further away than most of the scene is large, rays could not be aimed well enough, and boxes would be
/// widened by more than they are large. Depends on light and scene only, so that all packets do the same.
fn is_near(context: &Context<'_>, position: Vec3) -> bool {
    let (low, high) = context.scene.bulk;
    let size = (high - low).max_element();
    (position - low).abs().max((position - high).abs()).max_element() <= NEAR * size
}
