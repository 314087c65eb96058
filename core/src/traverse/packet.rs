//! Packets through the tree.
//!
//! ```text
//! groups with nothing in common go as streams, a word of 64 rays at a time
//! for each class of the others: stack = [root, all groups of the class]
//!     pop; leave out groups that have found something nearer
//!     node: which of eight children may any ray meet?  all at once
//!           each such child: which groups may meet it?  all at once; ask for its memory
//!           which rays of diverged groups meet it?  of all groups, if it is small for how far rays are apart
//!           push it; nearer ones last; where a few rays only meet it, with these in place of groups
//!           on with the nearest that groups meet
//!     a few rays: a leaf together, a subtree as streams
//!     leaf: each primitive that any ray may hit: which groups?  all at once; then each such group's rays, W at a time
//! ```

use mobula_simd::{MaskLanes, Token};

use super::paths::Paths;
use super::roots::Roots;
use super::stack::{Entry, Met, RaySet, RaySets};
use super::stream::{AT_LEAF, TraceStream, reaching};
use crate::bvh::{Node, STACK, Tree};
use crate::kernel::boxes::Planes;
use crate::kernel::diverged::{ANY_SIGNS, rays_meeting};
use crate::kernel::frusta::{Frusta, NodeDistances};
use crate::kernel::group_bounds::{GroupBounds, MIXED};
use crate::kernel::groups::group_size;
use crate::kernel::stream::Stream;
use crate::kernel::words::{WORDS, word_size};
use crate::leaf::Leaf;
use crate::sink::Sink;
use crate::{Columns3, Properties, Rays};

/// Packets with fewer rays travel as a stream.
const FEW: usize = 4;
/// So few rays of groups whose rays are tested one by one (as those to a light from both sides of a silhouette) and that meet a child, a node
/// or a leaf, go on there without their groups; otherwise all rays of the groups would be tested against all that lies between them. After
/// Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012.
const fn few(any: bool, leaf: bool) -> u32 {
    match (any, leaf) {
        (true, false) => 24,
        (true, true) => 16,
        (false, false) => 6,
        (false, true) => 8,
    }
}
/// And so few at a leaf that has no test of a few rays together.
const FEW_AT_LEAF: u32 = 3;

#[inline(always)]
pub(super) fn traverse<T: Token, const N: usize, B: Tree, S: Sink<N>>(
    token: T,
    tree: &B,
    rays: &mut Rays<N>,
    sink: &mut S,
    roots: Roots,
) -> Paths {
    let range = rays.range();
    if range.is_empty() {
        return Paths::default();
    }
    rays.shears(token);
    let mut paths = Paths::default();
    let mut stack = [Entry::NONE; STACK];
    let others = if N < FEW || range.len() < FEW {
        u32::MAX
    } else if rays.properties().contains(Properties::COMMON_ORIGIN) {
        together::<T, N, B, S, true>(token, tree, rays, sink, roots, &mut stack, &mut paths.common_origin)
    } else {
        together::<T, N, B, S, false>(token, tree, rays, sink, roots, &mut stack, &mut paths.general)
    };
    if others != 0 {
        paths.single = streams(token, tree, rays, sink, others, roots, &mut stack);
    }
    paths
}

/// Traces the rays of some groups as streams; says how many rays that are.
#[inline(always)]
fn streams<T: Token, const N: usize, B: Tree, S: Sink<N>>(
    token: T,
    tree: &B,
    rays: &mut Rays<N>,
    sink: &mut S,
    groups: u32,
    roots: Roots,
    stack: &mut [Entry; STACK],
) -> u64 {
    rays.inverse_directions(token);
    let mut stream = Stream::default();
    let mut traced = 0;
    for word in 0..N.div_ceil(64) {
        let (mut active, mut lane) = (0, 0);
        while lane < word_size(N) {
            let at = 64 * word + lane;
            if groups >> (at / group_size(N)) & 1 != 0 {
                active |= u64::from(rays.active(token, at).bits()) << lane;
            }
            lane += T::LANES;
        }
        if active != 0 {
            traced += u64::from(active.count_ones());
            stream.derive(token, rays, tree.frame(), word);
            for child in roots.of(tree) {
                let (sink, stream) = (&mut *sink, &stream);
                token.run(TraceStream { tree, rays, stream, sink, axis: None, child, word, active, stack, base: 0 });
            }
        }
    }
    traced
}

/// Traces the groups that have something in common; returns the others.
#[inline(always)]
fn together<T: Token, const N: usize, B: Tree, S: Sink<N>, const COMMON_ORIGIN: bool>(
    token: T,
    tree: &B,
    rays: &mut Rays<N>,
    sink: &mut S,
    roots: Roots,
    stack: &mut [Entry; STACK],
    traced: &mut u64,
) -> u32 {
    let size = group_size(N);
    let range = rays.range();
    let bounds = GroupBounds::new::<T, N, COMMON_ORIGIN>(token, rays, tree.frame());
    let (mut left, mut others) = (0u32, 0u32);
    for group in range.start / size..range.end.div_ceil(size) {
        if bounds.class(group) == MIXED {
            others |= 1 << group;
        } else {
            left |= 1 << group;
            *traced += (range.end.min((group + 1) * size) - range.start.max(group * size)) as u64;
        }
    }
    while left != 0 {
        let class = bounds.class(left.trailing_zeros() as usize);
        let groups = bounds.of_class(class);
        left &= !groups;
        let frusta = Frusta::new::<T, N, COMMON_ORIGIN>(token, &bounds, rays, class);
        let diverged = frusta.diverged();
        let mut walk = PacketWalk {
            tree,
            rays,
            apart: None,
            stream: None,
            sink,
            frusta,
            diverged,
            lanes: [0; WORDS],
            sets: RaySets::NONE,
            stale: 0,
        };
        for child in roots.of(tree) {
            stack[0] = Entry { child, near: f32::NEG_INFINITY, rays: groups.into() };
            walk.down::<T, COMMON_ORIGIN>(token, stack);
        }
    }
    others
}

/// What tests of rays one by one need.
struct Apart<const N: usize> {
    /// Signs of all directions, as [`rays_meeting`] wants them.
    signs: u8,
    /// Where rays start in the tree's frame.
    origins: Columns3<N>,
}

struct PacketWalk<'a, const N: usize, B, S> {
    tree: &'a B,
    rays: &'a mut Rays<N>,
    /// Derived when rays are first tested one by one.
    apart: Option<Apart<N>>,
    /// Made when rays first go on as a stream.
    stream: Option<Stream<N>>,
    sink: &'a mut S,
    frusta: Frusta,
    /// Groups whose rays are tested one by one.
    diverged: u32,
    /// Groups with hits since their frustum was shortened.
    stale: u32,
    /// A bit a ray: see [`rays_meeting`].
    lanes: [u64; WORDS],
    /// Rays that wait without their groups.
    sets: RaySets,
}

impl<const N: usize, B: Tree, S: Sink<N>> PacketWalk<'_, N, B, S> {
    /// Walks down from `stack[0]`.
    #[inline(always)]
    fn down<T: Token, const COMMON_ORIGIN: bool>(&mut self, token: T, stack: &mut [Entry; STACK]) {
        let mut top = 1;
        let mut room = Node::EMPTY;
        while top > 0 {
            top -= 1;
            let mut entry = stack[top];
            if let Some(set) = self.sets.take(entry.rays) {
                self.trace_set(token, entry, set, stack, top);
                continue;
            }
            let stale = self.stale & entry.rays as u32;
            if stale != 0 {
                self.stale &= !stale;
                self.frusta.shorten(token, self.rays, stale);
            }
            entry.rays = self.frusta.reaching::<T, N>(token, entry.rays as u32, entry.near).into();
            if entry.rays == 0 {
                continue;
            }
            // Down to a leaf by the nearest child each time; the others wait.
            while !entry.child.is_leaf() {
                let Some(node) = self.tree.node(entry.child.index(), &mut room) else { return };
                entry = self.nearest::<T, COMMON_ORIGIN>(token, node, entry.rays as u32, stack, &mut top);
            }
            self.stale |= self.tree.leaves().packet::<T, N, COMMON_ORIGIN, S>(
                token,
                entry.child.leaf_range(),
                &self.frusta,
                self.rays,
                self.sink,
                entry.rays as u32,
            );
        }
    }

    /// The nearest child that more than a few rays of the groups meet ([`Child::EMPTY`](crate::bvh::Child::EMPTY) if none); pushes the
    /// others, the nearer ones last.
    #[inline(always)]
    fn nearest<T: Token, const COMMON_ORIGIN: bool>(
        &mut self,
        token: T,
        node: &Node,
        groups: u32,
        stack: &mut [Entry; STACK],
        top: &mut usize,
    ) -> Entry {
        let planes = &node.planes;
        let mut distances = NodeDistances::NONE;
        let mut met = self.frusta.boxes(token, planes, &mut distances);
        let small = self.frusta.small::<T, COMMON_ORIGIN>(token, planes, &distances);
        let mut children = Met::new(stack, *top);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let mut groups = groups & self.frusta.groups::<T, N, COMMON_ORIGIN>(token, planes, slot, &distances);
            if groups == 0 {
                continue;
            }
            let (child, near) = (node.child[slot], distances.near[slot]);
            let apart = if small >> slot & 1 != 0 { groups } else { groups & self.diverged };
            if apart != 0 {
                let (meeting, count) = self.rays_meeting::<T, COMMON_ORIGIN>(token, planes, slot, apart);
                groups = groups & !apart | meeting;
                if groups == 0 {
                    continue;
                }
                let leaf = child.is_leaf();
                let most = if leaf && !B::Leaves::TESTS_FEW { FEW_AT_LEAF } else { few(S::ANY, leaf) };
                if groups == meeting
                    && count <= most
                    && let Some(rays) = self.sets.add(&self.lanes[..N.div_ceil(64)])
                {
                    self.tree.prefetch(child);
                    children.wait(Entry { child, near, rays }, !S::ANY);
                    continue;
                }
            }
            self.tree.prefetch(child);
            // The order of any hits is the node's.
            children.add(Entry { child, near, rays: groups.into() }, !S::ANY);
        }
        *top = children.top;
        children.nearest
    }

    /// [`rays_meeting`]: `self.lanes` says which.
    #[inline(always)]
    fn rays_meeting<T: Token, const COMMON_ORIGIN: bool>(
        &mut self,
        token: T,
        planes: &Planes,
        slot: usize,
        groups: u32,
    ) -> (u32, u32) {
        if self.apart.is_none() {
            self.rays.inverse_directions(token);
            let (signs, origins) = (self.rays.octant(), self.tree.frame().columns(token, self.rays));
            self.apart = Some(Apart { signs: signs.unwrap_or(ANY_SIGNS), origins });
        }
        let Some(Apart { signs, origins }) = &self.apart else { return (groups, u32::MAX) };
        rays_meeting::<T, N, COMMON_ORIGIN>(
            token,
            self.rays,
            *signs,
            origins,
            self.frusta.margin(),
            planes,
            slot,
            groups,
            &mut self.lanes,
        )
    }

    /// Traces a set of rays: through a leaf together, if they are few, through a subtree as streams.
    #[inline(always)]
    fn trace_set<T: Token>(
        &mut self,
        token: T,
        entry: Entry,
        mut set: RaySet,
        stack: &mut [Entry; STACK],
        base: usize,
    ) {
        let (child, axis) = (entry.child, Some(self.frusta.axis()));
        let (mut numbers, mut count) = ([0; AT_LEAF], 0);
        for (word, active) in set.iter_mut().enumerate() {
            if *active == 0 {
                continue;
            }
            *active &= reaching(token, self.rays, word, entry.near);
            let mut left = *active;
            while left != 0 {
                let i = (64 * word + left.trailing_zeros() as usize) % N;
                left &= left - 1;
                self.stale |= 1 << (i / group_size(N));
                numbers[count % AT_LEAF] = i;
                count += 1;
            }
        }
        let (tree, rays, sink) = (self.tree, &mut *self.rays, &mut *self.sink);
        if child.is_leaf() && count <= AT_LEAF {
            let (leaf, numbers) = (child.leaf_range(), &numbers[..count]);
            if tree.leaves().few::<T, N, S>(token, leaf, rays, sink, numbers, axis) {
                return;
            }
        }
        for (word, &active) in set.iter().enumerate() {
            if active != 0 {
                let stream = self.stream.get_or_insert_default();
                stream.derive(token, rays, tree.frame(), word);
                let (rays, stream, sink, stack) = (&mut *rays, &*stream, &mut *sink, &mut *stack);
                token.run(TraceStream { tree, rays, stream, sink, axis, child, word, active, stack, base });
            }
        }
    }
}
