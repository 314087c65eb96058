//! How open the sky is above points: ambient occlusion (Zhukov, Iones and Kronin, "An Ambient Light Illumination Model", 1998).

use mobula_core::Properties;
use mobula_core::simd::{F32Lanes, MaskLanes, Task, Token};

use crate::lanes::{dot, load3, scale, select3, store3, sub};
use crate::lighting::Points;
use crate::packet::{AnyHitPacket, Columns3, columns3, transmittance};
use crate::scratch::{ForWidth, lend};
use crate::sequence::{Set, point_in_cell};
use crate::stack::{Context, Occlusion};
use crate::warp::{above, cosine_weighted};

/// Sets the first rows of `out` to the fraction of the light from above each of the points, weighted by the cosine, that nothing keeps away:
/// as far as `occlusion` says, and with so many rays, which depend on the samples alone that the points belong to. `depth` is how many
/// reflections or refractions they are behind.
///
/// The first rays of all points go together, then the second ones: so packets are full, and their rays start close to each other and go
/// into the same part of the sky.
pub(crate) fn openness(context: &Context<'_>, occlusion: Occlusion, points: &Points, depth: u32, out: &mut [f32]) {
    let count = points.len();
    let out = &mut out[..count];
    out.fill(0.0);
    let aim: &mut Aim = &mut lend(context.width);
    let packet: &mut AnyHitPacket = &mut lend(context.width);
    for ray in 0..occlusion.rays {
        context.token.run(Upward { points, set: Set::occlusion(depth), ray, rays: occlusion.rays, aim });
        packet.reset(count);
        let rays = packet.rays_mut();
        rays.origins_mut().into_iter().zip(&aim.origins).for_each(|(to, from)| to.copy_from_slice(&from[..count]));
        rays.directions_mut()
            .into_iter()
            .zip(&aim.directions)
            .for_each(|(to, from)| to.copy_from_slice(&from[..count]));
        rays.t_max_mut().fill(occlusion.distance);
        if aim.unit {
            rays.promise(Properties::NORMALIZED_DIRECTIONS);
        }
        let statistics = context.statistics;
        statistics.shadow.set(statistics.shadow.get() + count as u64);
        context.scene.occlude(context, packet);
        for ((out, &t_max), &depth) in out.iter_mut().zip(packet.rays().t_max()).zip(packet.depths()) {
            if t_max != f32::NEG_INFINITY {
                *out += if depth > 0 { transmittance(depth) } else { 1.0 };
            }
        }
    }
    let share = 1.0 / occlusion.rays.max(1) as f32;
    out.iter_mut().for_each(|open| *open *= share);
}

/// Rays that leave points upwards.
struct Aim {
    origins: Columns3,
    directions: Columns3,
    /// Have all directions unit length?
    unit: bool,
}

impl ForWidth for Aim {
    fn for_width(width: usize) -> Self {
        Self { origins: columns3(width), directions: columns3(width), unit: false }
    }
}

struct Upward<'a> {
    points: &'a Points,
    set: Set,
    ray: u32,
    rays: u32,
    aim: &'a mut Aim,
}

impl Task for Upward<'_> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { points, set, ray, rays, aim } = self;
        let zero = token.splat(0.0);
        let [seeds, numbers] = points.samples();
        aim.unit = true;
        for at in (0..points.len()).step_by(T::LANES) {
            let (seed, number) = (token.load_u32(seeds, at), token.load_u32(numbers, at));
            let square = point_in_cell(token, seed, number, (ray, rays), set);
            let (normal, geometric) =
                (load3(token, &points.normals(), at), load3(token, &points.geometric_normals(), at));
            let direction = above(token, normal, cosine_weighted(token, square));
            // What goes into the surface, because that is not as round as its normals say, is mirrored out of it.
            let inward = dot(direction, geometric);
            let mirrored = sub(direction, scale(geometric, inward + inward));
            let direction = select3(inward.lt(zero), mirrored, direction);
            store3(points.offsets(token, at, 1.0, zero), &mut aim.origins, at);
            store3(direction, &mut aim.directions, at);
            let unit = (dot(direction, direction) - token.splat(1.0)).abs().lt(token.splat(1e-5));
            aim.unit &= !token.first(points.len() - at).and_not(unit).any();
        }
    }
}

#[cfg(test)]
mod tests {
    use mobula_core::simd::{AnyToken, Scalar};

    use super::*;
    use crate::sequence::point;

    struct Directions(Vec<[f32; 3]>);

    impl Task for Directions {
        type Output = Vec<f32>;

        #[inline(always)]
        fn run<T: Token>(self, token: T) -> Vec<f32> {
            let mut out = Vec::new();
            let numbers: Vec<u32> = (0..1024).collect();
            for normal in self.0 {
                for at in (0..numbers.len()).step_by(T::LANES) {
                    let square = point(token, token.splat_i32(7), token.load_u32(&numbers, at), Set::occlusion(0));
                    let direction = above(token, normal.map(|x| token.splat(x)), cosine_weighted(token, square));
                    for component in direction {
                        let mut lanes = vec![0.0; T::LANES];
                        component.store(&mut lanes, 0);
                        out.extend(lanes);
                    }
                }
            }
            out
        }
    }

    #[test]
    fn directions_are_about_the_normal_by_the_cosine() {
        for normal in [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.6, -0.8, 0.0], [-0.48, 0.6, -0.64]] {
            let found = Directions(vec![normal]).run(Scalar::new());
            let directions: Vec<[f32; 3]> = found.chunks(3).map(|d| [d[0], d[1], d[2]]).collect();
            let mut mean = [0.0; 3];
            for d in &directions {
                assert!((d.iter().map(|x| x * x).sum::<f32>() - 1.0).abs() < 2e-6, "{d:?}");
                assert!(d.iter().zip(normal).map(|(d, n)| d * n).sum::<f32>() > -1e-6, "{d:?}");
                (0..3).for_each(|axis| mean[axis] += d[axis] / directions.len() as f32);
            }
            // The mean of the cosine, weighted by the cosine, is 2/3.
            for (mean, n) in mean.iter().zip(normal) {
                assert!((mean - n * 2.0 / 3.0).abs() < 2e-3, "{mean} along {n}");
            }
        }
    }

    #[test]
    fn all_levels_agree() {
        let one_at_a_time = |token: AnyToken| {
            let lanes = token.lanes();
            let found = token.run(Directions(vec![[0.6, -0.8, 0.0]]));
            let mut directions = vec![[0.0; 3]; 1024];
            for (i, x) in found.into_iter().enumerate() {
                directions[i / (3 * lanes) * lanes + i % lanes][i / lanes % 3] = x;
            }
            directions
        };
        let expected = one_at_a_time(AnyToken::Scalar(Scalar::new()));
        for token in AnyToken::available() {
            assert_eq!(one_at_a_time(token), expected, "{}", token.level());
        }
    }
}
