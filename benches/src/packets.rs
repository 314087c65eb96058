//! Mobula's timed loop: fill a packet from the arrays, say what is true of it, trace, store what was found.

use mobula_core::bvh::{Bvh, Join};
use mobula_core::leaf::Block;
use mobula_core::simd::AnyToken;
use mobula_core::{AnyHitPacket, Columns3, Properties, RayPacket, Rays};
use rayon_core::{ThreadPool, ThreadPoolBuilder};

use crate::rays::{Found, Kind, RaySet};

/// Traces all rays in packets of `N`.
pub fn trace<const N: usize, B: Block>(bvh: &Bvh<B>, token: AnyToken, kind: Kind, rays: &RaySet, found: &mut Found) {
    let known = properties(rays);
    if kind.any_hit() {
        let mut packet = Box::new(AnyHitPacket::<N>::default());
        for at in (0..rays.len()).step_by(N) {
            let count = N.min(rays.len() - at);
            packet.reset(0..count);
            fill(&mut packet, rays, at, count, known);
            copy(&rays.t_max, at, &mut packet.t_max[..], 0, count);
            bvh.occlude(token, &mut packet);
            copy(&packet.t_max[..], 0, &mut found.t, at, count);
        }
    } else {
        let mut packet = Box::new(RayPacket::<N>::default());
        for at in (0..rays.len()).step_by(N) {
            let count = N.min(rays.len() - at);
            packet.reset(0..count);
            fill(&mut packet, rays, at, count, known);
            copy(&rays.t_max, at, &mut packet.t_max[..], 0, count);
            bvh.intersect(token, &mut packet);
            copy(&packet.t_max[..], 0, &mut found.t, at, count);
            copy(&packet.hits.primitive[..], 0, &mut found.primitive, at, count);
        }
    }
}

/// What is true of all rays.
fn properties(rays: &RaySet) -> Properties {
    let mut known = Properties::NORMALIZED_DIRECTIONS;
    known.set(Properties::COMMON_ORIGIN, rays.common_origin);
    known
}

#[inline(always)]
fn fill<const N: usize>(packet: &mut Rays<N>, rays: &RaySet, at: usize, count: usize, known: Properties) {
    let columns = |columns: &mut Columns3<N>, arrays: &[Vec<f32>; 3]| {
        for (column, array) in columns.iter_mut().zip(arrays) {
            copy(array, at, &mut column[..], 0, count);
        }
    };
    columns(packet.origins_mut(), &rays.origin);
    columns(packet.directions_mut(), &rays.direction);
    packet.promise(known);
}

/// `from[a..a + count]` to `to[b..b + count]`.
#[inline(always)]
fn copy<T: Copy>(from: &[T], a: usize, to: &mut [T], b: usize, count: usize) {
    to[b..b + count].copy_from_slice(&from[a..a + count]);
}

/// Halves of a build on a pool of so many threads.
#[derive(Debug)]
pub struct Threads(ThreadPool);

impl Threads {
    /// Starts `count` threads.
    ///
    /// # Panics
    /// If the system has none to give.
    pub fn new(count: usize) -> Self {
        Self(ThreadPoolBuilder::new().num_threads(count).build().expect("threads"))
    }

    /// Does something on one of them.
    pub fn enter<R: Send>(&self, work: impl FnOnce() -> R + Send) -> R {
        self.0.install(work)
    }
}

impl Join for Threads {
    fn join<A: Send, B: Send>(&self, a: impl FnOnce() -> A + Send, b: impl FnOnce() -> B + Send) -> (A, B) {
        self.0.join(a, b)
    }
}
