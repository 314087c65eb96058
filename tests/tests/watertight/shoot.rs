//! Rays in packets of each width, of which all should hit.

use mobula_core::bvh::Tree;
use mobula_core::glam::Vec3;
use mobula_core::simd::AnyToken;
use mobula_core::traverse::{self, Paths};
use mobula_core::{AnyHitPacket, RayPacket};

pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }

    pub(crate) fn below(&mut self, n: usize) -> usize {
        (self.unit() * n as f32) as usize % n
    }

    pub(crate) fn signed(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit()) * 2.0 - 1.0
    }
}

/// What was shot, and missed.
#[derive(Debug, Default)]
pub(crate) struct Count {
    pub(crate) rays: u64,
    missed: u64,
    paths: Paths,
    first: Option<String>,
}

impl Count {
    /// How many rays are to be shot.
    pub(crate) fn wanted() -> u64 {
        std::env::var("MOBULA_WATERTIGHT_RAYS").ok().and_then(|n| n.parse().ok()).unwrap_or(60_000)
    }

    /// Shoots a packet, each ray of which should hit at `until` or before; if all start at one point, as one that has a common origin.
    pub(crate) fn shoot<B: Tree, const N: usize>(
        &mut self,
        token: AnyToken,
        tree: &B,
        rays: &[(Vec3, Vec3)],
        until: f32,
        what: impl Fn() -> String,
    ) {
        let mut packet = RayPacket::<N>::default();
        packet.reset(0..N);
        for (i, &(origin, direction)) in rays.iter().enumerate() {
            packet.set_ray(i, origin, direction);
        }
        // Of single rays every other.
        let common = if N == 1 { self.rays.is_multiple_of(2) } else { rays.iter().all(|ray| ray.0 == rays[0].0) };
        if common {
            packet.set_common_origin(rays[0].0);
        }
        self.paths += traverse::intersect(tree, token, &mut packet);
        let mut shadow = (N == 64).then(AnyHitPacket::<N>::default);
        if let Some(shadow) = &mut shadow {
            shadow.reset(0..N);
            for (i, &(origin, direction)) in rays.iter().enumerate() {
                shadow.set_ray(i, origin, direction);
            }
            traverse::occlude(tree, token, shadow, None);
        }
        for (i, ray) in rays.iter().enumerate() {
            self.rays += 1;
            let found = packet.was_hit(i) && packet.t_max[i] <= until;
            if !found || shadow.as_ref().is_some_and(|shadow| !shadow.occluded(i)) {
                self.missed += 1;
                self.first.get_or_insert_with(|| format!("{}, width {N}, closest hit {found}: {ray:?}", what()));
            }
        }
    }

    /// Says what was shot; fails if anything was missed, or if a path was not taken.
    pub(crate) fn check(&self, token: AnyToken) {
        println!("{token:?}: {} rays, {} missed; {:?}", self.rays, self.missed, self.paths);
        assert_eq!(self.missed, 0, "{token:?}: of {} rays; {:?}", self.rays, self.first);
        let Paths { common_origin, general, single } = self.paths;
        assert!(common_origin > 0 && general > 0 && single > 0, "{:?}", self.paths);
    }
}
