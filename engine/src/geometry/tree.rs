//! Geometries of one kind in one bounding volume hierarchy of `mobula-core`.

use std::fmt::Debug;
use std::marker::PhantomData;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::Vec3;
use mobula_core::bvh::{Bvh, Quality};
use mobula_core::leaf::Block;
use mobula_core::simd::AnyToken;
use mobula_core::sink::Opacity;
use mobula_core::traverse::Paths;
use mobula_core::{AnyHitPacket, RayPacket};

use super::{Geometry, Structure};
use crate::accel::{AccelerationKind, Build, Pool};
use crate::packet::Intersect;
use crate::progress::Progress;

/// A kind of geometry whose primitives go into a hierarchy: they are what its leaves hold.
pub trait InTree: Geometry {
    /// What a leaf holds.
    type Leaf: Block + Debug;

    /// What the hierarchy knows of primitive `i`; `None` if it is left out.
    fn primitive(&self, i: usize) -> Option<<Self::Leaf as Block>::Primitive>;

    /// Primitive `i`, which is known not to be left out.
    fn sound(&self, i: usize) -> <Self::Leaf as Block>::Primitive {
        self.primitive(i).unwrap_or(<Self::Leaf as Block>::NOWHERE)
    }
}

/// Geometries of one kind in one hierarchy.
#[derive(Debug)]
pub struct Tree<G: InTree> {
    bvh: Bvh<G::Leaf>,
    /// How many ids each geometry has.
    counts: Vec<usize>,
    /// The ids of primitives that were left out when the hierarchy was built.
    left_out: Vec<u32>,
    /// Is none left out now?
    whole: bool,
    /// Is every primitive tried, without the hierarchy?
    all: bool,
    kind: PhantomData<fn() -> G>,
}

/// The primitives of some geometries, one after the other.
struct Members<'a, G> {
    members: Vec<&'a G>,
    /// The id of the first primitive of each, and the number of ids.
    firsts: Vec<usize>,
}

impl<'a, G: InTree> Members<'a, G> {
    /// `None` if one of them is of another type.
    fn new(members: &'a [Arc<dyn Geometry>]) -> Option<Self> {
        let typed = |member: &'a Arc<dyn Geometry>| member.downcast_ref::<G>();
        let members = members.iter().map(typed).collect::<Option<Vec<_>>>()?;
        let mut firsts = vec![0];
        let mut end = 0;
        for member in &members {
            end += member.primitives();
            firsts.push(end);
        }
        Some(Self { members, firsts })
    }

    fn len(&self) -> usize {
        self.firsts[self.members.len()]
    }

    /// The geometry of an id, and its number there.
    #[inline(always)]
    fn of(&self, id: usize) -> (&'a G, usize) {
        if let [only] = self.members[..] {
            return (only, id);
        }
        let at = self.firsts.partition_point(|&first| first <= id) - 1;
        (self.members[at], id - self.firsts[at])
    }

    #[inline(always)]
    fn primitive(&self, id: usize) -> Option<<G::Leaf as Block>::Primitive> {
        let (member, i) = self.of(id);
        member.primitive(i)
    }

    #[inline(always)]
    fn sound(&self, id: usize) -> <G::Leaf as Block>::Primitive {
        let (member, i) = self.of(id);
        member.sound(i)
    }
}

impl<G: InTree> Tree<G> {
    /// Builds a hierarchy over all primitives of some geometries of type `G`.
    ///
    /// # Panics
    /// If one of them is of another type.
    pub fn build(members: &[Arc<dyn Geometry>], build: &Build) -> Self {
        let members = Members::<G>::new(members).expect("geometries of one type");
        let (primitive, sound) = (|id: usize| members.primitive(id), |id: usize| members.sound(id));
        let quality = if build.kind == AccelerationKind::Bvh { Quality::Good } else { Quality::Fast };
        let count = members.len();
        let join = Pool(&build.progress);
        let bvh: Bvh<G::Leaf> = Pool::enter(|| Bvh::build_sound(count, 0, quality, &join, primitive, sound));
        let whole = bvh.primitives() == count;
        let left_out = if whole {
            Vec::new()
        } else {
            (0..count).filter(|&id| members.primitive(id).is_none()).map(|id| id as u32).collect()
        };
        let counts = members.members.iter().map(|member| member.primitives()).collect();
        Self { bvh, counts, left_out, whole, all: build.kind == AccelerationKind::Brute, kind: PhantomData }
    }
}

impl<G: InTree, const N: usize> Intersect<N> for Tree<G> {
    fn intersect(&self, token: AnyToken, packet: &mut RayPacket<N>) -> Paths {
        if self.all { self.bvh.intersect_all(token, packet) } else { self.bvh.intersect(token, packet) }
    }

    fn occlude(&self, token: AnyToken, packet: &mut AnyHitPacket<N>, opacity: Option<&dyn Opacity>) -> Paths {
        match (opacity, self.all) {
            (None, false) => self.bvh.occlude(token, packet),
            (None, true) => self.bvh.occlude_all(token, packet),
            (Some(opacity), false) => self.bvh.occlude_through(token, packet, opacity),
            (Some(opacity), true) => self.bvh.occlude_through_all(token, packet, opacity),
        }
    }
}

impl<G: InTree> Structure for Tree<G> {
    fn primitives(&self) -> usize {
        self.bvh.primitives()
    }

    fn bytes(&self) -> usize {
        self.bvh.bytes()
    }

    fn whole_bounds(&self) -> Option<(Vec3, Vec3)> {
        let corner = |[x, y, z, _]: [f32; 4]| Vec3::new(x, y, z);
        self.whole.then(|| (corner(self.bvh.bounds().low), corner(self.bvh.bounds().high)))
    }

    fn can_refit(&self, members: &[Arc<dyn Geometry>]) -> bool {
        Members::<G>::new(members).is_some_and(|members| {
            members.members.iter().map(|member| member.primitives()).eq(self.counts.iter().copied())
                && self.left_out.iter().all(|&id| members.primitive(id as usize).is_none())
        })
    }

    fn refit(&mut self, members: &[Arc<dyn Geometry>]) {
        let members = Members::<G>::new(members).expect("geometries of one type");
        // Relaxed: read when all threads are done.
        let some_left_out = AtomicBool::new(!self.left_out.is_empty());
        let sound = |id: usize| {
            let primitive = members.primitive(id);
            if primitive.is_none() {
                some_left_out.store(true, Ordering::Relaxed);
            }
            primitive
        };
        Pool::enter(|| self.bvh.refit_sound(&Pool(&Progress::default()), sound));
        self.whole = !some_left_out.into_inner();
    }
}
