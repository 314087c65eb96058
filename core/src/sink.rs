//! What becomes of hits: the nearest is kept, or any is enough, or each takes a part of the light.

use mobula_simd::{F32Lanes, I32Lanes, MaskLanes, Token};

use crate::{Hits, NO_HIT, Rays};

/// The optical depth at which nothing gets through any more, 2^-16 of the light.
pub const OPAQUE: u32 = 16 << 24;

/// How opaque primitives are, for any-hit rays that may get through some of them.
///
/// A depth is `-log2(transmittance) * 2^24`: a logarithm, so that depths add up, and an integer, so that the sum does not
/// depend on the order in which a walk meets hits.
pub trait Opacity: Sync {
    /// What `primitive` adds to the optical depth of ray `ray` of the packet, which meets it at distance `t`. [`OPAQUE`] stops
    /// the ray.
    fn depth(&self, ray: usize, primitive: u32, t: f32) -> u32;
}

/// Takes the hits of the rays of a packet.
pub trait Sink<const N: usize> {
    /// Is any hit enough?
    const ANY: bool;

    /// Takes the lanes `hit` of the rays from `at`; says whether the interval of any of them changed.
    fn record<T: Token>(&mut self, token: T, rays: &mut Rays<N>, at: usize, hit: T::Mask, t: T::F32, id: u32) -> bool;

    /// Of any hits: does it matter how many there are, and where?
    fn wants_all(&self) -> bool {
        true
    }

    /// For ray `i` when it is traced as a single ray.
    fn single(&self, rays: &Rays<N>, i: usize) -> SingleHit<'_>;

    /// Takes what ray `i` has found as a single ray.
    fn set(&mut self, rays: &mut Rays<N>, i: usize, found: Found);
}

impl<const N: usize> Sink<N> for Hits<N> {
    const ANY: bool = false;

    #[inline(always)]
    fn record<T: Token>(&mut self, token: T, rays: &mut Rays<N>, at: usize, hit: T::Mask, t: T::F32, id: u32) -> bool {
        let id = token.splat_i32(id as i32);
        let nearest = token.load(&rays.t_max[..], at);
        let lower = id.lt_unsigned(token.load_u32(&self.primitive[..], at));
        let better = hit & rays.active(token, at) & (t.lt(nearest) | (t.eq(nearest) & lower));
        t.store_masked(&mut rays.t_max[..], at, better);
        id.store_masked(&mut self.primitive[..], at, better);
        better.any()
    }

    #[inline(always)]
    fn single(&self, rays: &Rays<N>, i: usize) -> SingleHit<'_> {
        let found = Found { hit: false, t_max: rays.t_max[i], id: self.primitive[i], depth: 0 };
        SingleHit { found, ray: i, opacity: None }
    }

    #[inline(always)]
    fn set(&mut self, rays: &mut Rays<N>, i: usize, found: Found) {
        if found.hit {
            rays.t_max[i] = found.t_max;
            self.primitive[i] = found.id;
        }
    }
}

/// The sink of any-hit packets: a hit sets the far end of a ray to `-inf`, where primitives have an [`Opacity`] once the ray
/// has met enough of them.
pub struct AnyHit<'a> {
    opacity: Option<&'a dyn Opacity>,
    /// The optical depth of each ray; empty without an opacity.
    depth: &'a mut [u32],
}

impl<'a> AnyHit<'a> {
    /// Any hit stops a ray.
    pub fn opaque() -> Self {
        Self { opacity: None, depth: &mut [] }
    }

    /// Hits add to `depth`, a row a ray, until it is [`OPAQUE`].
    pub fn transparent(opacity: &'a dyn Opacity, depth: &'a mut [u32]) -> Self {
        Self { opacity: Some(opacity), depth }
    }

    /// Adds the depth of each hit; says which rays have met enough.
    #[cold]
    #[inline(never)]
    fn stopped(&mut self, opacity: &dyn Opacity, at: usize, hit: u32, t: &[f32; 16], id: u32) -> u32 {
        let (mut left, mut stopped) = (hit, 0);
        while left != 0 {
            let lane = left.trailing_zeros() as usize % 16;
            left &= left - 1;
            if let Some(depth) = self.depth.get_mut(at + lane) {
                *depth = add(*depth, opacity.depth(at + lane, id, t[lane]));
                stopped |= u32::from(*depth == OPAQUE) << lane;
            }
        }
        stopped
    }
}

/// Two depths, one behind the other.
#[inline(always)]
fn add(a: u32, b: u32) -> u32 {
    a.saturating_add(b).min(OPAQUE)
}

impl<const N: usize> Sink<N> for AnyHit<'_> {
    const ANY: bool = true;

    #[inline(always)]
    fn record<T: Token>(&mut self, token: T, rays: &mut Rays<N>, at: usize, hit: T::Mask, t: T::F32, id: u32) -> bool {
        let mut hit = hit & rays.active(token, at);
        if let Some(opacity) = self.opacity {
            let mut distances = [0.0; 16];
            t.store(&mut distances, 0);
            hit = token.mask(self.stopped(opacity, at, hit.bits(), &distances, id));
        }
        token.splat(f32::NEG_INFINITY).store_masked(&mut rays.t_max[..], at, hit);
        hit.any()
    }

    #[inline(always)]
    fn wants_all(&self) -> bool {
        self.opacity.is_some()
    }

    #[inline(always)]
    fn single(&self, rays: &Rays<N>, i: usize) -> SingleHit<'_> {
        let depth = self.depth.get(i).copied().unwrap_or(0);
        let found = Found { hit: false, t_max: rays.t_max[i], id: NO_HIT, depth };
        SingleHit { found, ray: i, opacity: self.opacity }
    }

    #[inline(always)]
    fn set(&mut self, rays: &mut Rays<N>, i: usize, found: Found) {
        if found.hit {
            rays.t_max[i] = f32::NEG_INFINITY;
        }
        if let Some(depth) = self.depth.get_mut(i) {
            *depth = found.depth;
        }
    }
}

/// What a ray has found as a single ray.
#[derive(Clone, Copy, Debug)]
pub struct Found {
    /// Was anything found? Of any-hit rays: enough to stop them?
    pub hit: bool,
    /// Far end of the interval.
    pub t_max: f32,
    /// What was hit.
    pub id: u32,
    /// The optical depth.
    depth: u32,
}

/// The sink of a ray that is traced as a single ray.
pub struct SingleHit<'a> {
    /// What it has found.
    pub found: Found,
    ray: usize,
    opacity: Option<&'a dyn Opacity>,
}

impl SingleHit<'_> {
    /// Of a ray that ends at `t_max` and has hit nothing yet.
    #[inline(always)]
    pub fn of(t_max: f32) -> Self {
        Self { found: Found { hit: false, t_max, id: NO_HIT, depth: 0 }, ray: 0, opacity: None }
    }

    /// Takes a hit of the closest-hit ray; says whether it is nearer than the one before.
    #[inline(always)]
    pub fn closest(&mut self, t: f32, id: u32) -> bool {
        let better = t < self.found.t_max || (t == self.found.t_max && id < self.found.id);
        if better {
            self.found = Found { hit: true, t_max: t, id, depth: 0 };
        }
        better
    }

    /// Takes a hit of the any-hit ray; says whether it is done.
    #[inline(always)]
    pub fn any(&mut self, t: f32, id: u32) -> bool {
        self.found.hit = match self.opacity {
            None => true,
            Some(opacity) => {
                self.found.depth = add(self.found.depth, opacity.depth(self.ray, id, t));
                self.found.depth == OPAQUE
            }
        };
        self.found.hit
    }
}
