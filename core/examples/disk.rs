//! A primitive that the workspace does not know, with a special case, registered from outside: its differential check and
//! its rows of the matrix. `cargo run --release -p mobula-core --features lab --example disk`

use mobula_core::lab::{Dice, Find, Plan, RayTest, WIDTHS};
use mobula_core::oracle::{self, Truth};
use mobula_core::simd::{AnyToken, F32Lanes, Token};
use mobula_core::vector::{dot, load3, splat3, sub};
use mobula_core::{Properties, Rays};

/// A disk that faces along z.
#[derive(Clone, Copy, Debug)]
pub struct Facing {
    center: [f32; 3],
    radius: f32,
}

/// The test; with a common origin, the disk is moved once instead of every ray.
pub struct Disk<const COMMON_ORIGIN: bool>;

impl<const COMMON_ORIGIN: bool> RayTest for Disk<COMMON_ORIGIN> {
    type Primitive = Facing;
    type General = Disk<false>;
    type Common = [f32; 3];
    type Prepared<T: Token> = ([T::F32; 3], T::F32);
    const PROMISES: Properties = if COMMON_ORIGIN { Properties::COMMON_ORIGIN } else { Properties::empty() };

    fn draw(dice: &mut Dice<'_>) -> Facing {
        Facing { center: dice.point(), radius: 0.25 * dice.value().abs() }
    }

    fn aim(dice: &mut Dice<'_>, disk: &Facing) -> [f32; 3] {
        // The middle, the rim, or anywhere near.
        let [x, y, z] = disk.center;
        let at = [0.0, 1.0, dice.signed()][dice.below(3)];
        [x + at * disk.radius, y, z]
    }

    #[inline(always)]
    fn common<T: Token, const N: usize>(_token: T, rays: &Rays<N>) -> [f32; 3] {
        rays.ray(rays.range().start % N).0.to_array()
    }

    #[inline(always)]
    fn prepare<T: Token>(token: T, disk: &Facing, origin: [f32; 3]) -> ([T::F32; 3], T::F32) {
        let mut center = disk.center;
        if COMMON_ORIGIN {
            center = [center[0] - origin[0], center[1] - origin[1], center[2] - origin[2]];
        }
        (splat3(token, center), token.splat(disk.radius * disk.radius))
    }

    #[inline(always)]
    fn test<T: Token, const N: usize>(
        token: T,
        &(center, radius2): &([T::F32; 3], T::F32),
        _i: usize,
        _origin: [f32; 3],
        rays: &Rays<N>,
        at: usize,
    ) -> (T::Mask, T::F32) {
        let center = if COMMON_ORIGIN { center } else { sub(center, load3(token, rays.origins(), at)) };
        let direction = load3(token, rays.directions(), at);
        let t = center[2] / direction[2];
        let off = [direction[0].mul_sub(t, center[0]), direction[1].mul_sub(t, center[1]), token.splat(0.0)];
        let (t_min, t_max) = (token.load(&rays.t_min()[..], at), token.load(&rays.t_max[..], at));
        (dot(off, off).lt(radius2) & t.gt(t_min) & t.le(t_max), t)
    }

    fn truth(disk: &Facing, _i: usize, ray: &oracle::ExactRay) -> Option<(Truth, f64)> {
        let [x, y, z] = [0, 1, 2].map(|k| f64::from(disk.center[k]) - ray.origin[k]);
        let [dx, dy, dz] = ray.direction;
        let t = z / dz;
        let size = [x, y, z].iter().chain(&ray.origin).fold(f64::from(disk.radius), |s, v| s.max(v.abs()));
        // The oracle speaks for usual sizes, and not for rays that graze the plane.
        let usual = (1e-5..1e5).contains(&size) && [dx, dy, dz].iter().all(|d| d.abs() > 1e-3 && d.abs() < 1e3);
        let off = ((dx * t - x).powi(2) + (dy * t - y).powi(2)).sqrt() - f64::from(disk.radius);
        let ends = [ray.t_min, ray.t_max].map(|end| (end - t).abs() * dz.abs());
        let steep = 1.0 + dx.abs().max(dy.abs()) / dz.abs();
        let margin = ends.into_iter().filter(|end| !end.is_nan()).fold(off.abs() / steep, f64::min) / size;
        let hit = off < 0.0 && t > ray.t_min && t <= ray.t_max;
        usual.then_some((Truth { t: hit.then_some(t), margin }, 2.0 * size / dz.abs()))
    }
}

mobula_core::kernels! {
    /// What this crate tunes.
    pub static MINE;
    disk { general: Find<Disk<false>>, common_origin: Find<Disk<true>> }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for kernel in MINE {
        for token in AnyToken::available() {
            for &width in WIDTHS {
                for seed in 0..50 {
                    kernel.check(token, width, &mut Dice::from_seed(seed))?;
                }
            }
            let row = kernel.measure(token, 64, Plan::default());
            let tick = if row.correct { "ok" } else { "WRONG" };
            println!("{kernel:?} {} x{}: {:.2} cycles a test, {tick}", row.level, row.width, row.cycles);
        }
    }
    Ok(())
}
