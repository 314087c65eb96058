//! Packets through the tree.
//!
//! ```text
//! groups with nothing in common go as streams, 64 rays at a time
//! for each class of the others: stack = [root, all groups of the class]
//!     pop; leave out groups that have found something nearer
//!     node: which of eight children may any ray meet?  all at once
//!           each such child: which groups may meet it?  all at once; ask for its memory
//!           which rays of diverged groups meet it?  of all groups, if it is small for how far rays are apart
//!           push it; nearer ones last; where a few rays only meet it, with these in place of groups
//!           on with the nearest that groups meet
//!     a few rays: a leaf together, a subtree one by one
//!     leaf: each primitive that any ray may hit: which groups?  all at once; then each such group's rays, W at a time
//! ```

use mobula_simd::{MaskLanes, Token};

use super::paths::Paths;
use super::roots::Roots;
use super::single::TraceSingle;
use super::stack::{Entry, FewNumbers, Met};
use super::stream::TraceStream;
use crate::bvh::{Node, STACK, Tree};
use crate::kernel::boxes::Planes;
use crate::kernel::diverged::{ANY_SIGNS, WORDS, rays_meeting};
use crate::kernel::frusta::{Frusta, NodeDistances};
use crate::kernel::group_bounds::{GroupBounds, MIXED};
use crate::kernel::groups::group_size;
use crate::kernel::single::{OneRay, padded_origin};
use crate::leaf::Leaf;
use crate::sink::Sink;
use crate::{Columns3, Properties, Rays};

/// Packets with fewer rays travel as a stream.
const FEW: usize = 4;
/// So few rays of a packet that meet a node go on as single rays there: a packet that has diverged (rays to a light from both
/// sides of a silhouette) would test them against all that lies between (after Benthin et al., "Combining Single and
/// Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC Architecture", TVCG 2012).
const SINGLE_RAYS: u32 = 3;
/// And so few that meet a leaf are tested there together: see [`Leaf::few`].
const AT_LEAF: u32 = FewNumbers::MOST as u32;
/// Rays of a stream.
const STREAM: usize = 64;

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
        rays.inverse_directions(token);
        // Few rays are not copied into, and tested in, lanes for many.
        paths.single = if N <= 16 || range.end <= 16 {
            streams::<T, N, 16, B, S>(token, tree, rays, sink, others, roots, &mut stack)
        } else {
            streams::<T, N, STREAM, B, S>(token, tree, rays, sink, others, roots, &mut stack)
        };
    }
    paths
}

/// Traces the rays of some groups as streams of `W`, which are copied out of the packet; says how many rays that are.
#[inline(always)]
fn streams<T: Token, const N: usize, const W: usize, B: Tree, S: Sink<N>>(
    token: T,
    tree: &B,
    rays: &mut Rays<N>,
    sink: &mut S,
    groups: u32,
    roots: Roots,
    stack: &mut [Entry; STACK],
) -> u64 {
    let range = rays.range();
    let mut copies = Rays::<W>::default();
    let mut traced = 0;
    let mut at = range.start / W * W;
    while at < range.end {
        let (mut active, mut lane) = (0, 0);
        while lane < W && at + lane < range.end {
            if groups >> ((at + lane) / group_size(N)) & 1 != 0 {
                active |= u64::from(rays.active(token, at + lane).bits()) << lane;
            }
            lane += T::LANES;
        }
        if active != 0 {
            traced += u64::from(active.count_ones());
            rays.section(at, &mut copies);
            let mut section = sink.section::<W>(at);
            token.run(TraceStream { tree, rays: &mut copies, sink: &mut section, active, roots, stack });
            let mut ids = [0; W];
            if !S::ANY {
                for (i, id) in ids.iter_mut().enumerate() {
                    *id = section.id(i);
                }
            }
            drop(section);
            let mut lane = 0;
            while lane < W {
                let mask = token.mask((active >> lane) as u32);
                let (t_max, ids) = (token.load(&copies.t_max[..], lane), token.load_u32(&ids, lane));
                sink.merge(token, rays, at + lane, mask, t_max, ids);
                lane += T::LANES;
            }
        }
        at += W;
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
        let mut walk = PacketWalk { tree, rays, apart: None, sink, frusta, diverged, lanes: [0; WORDS], stale: 0 };
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
    sink: &'a mut S,
    frusta: Frusta,
    /// Groups whose rays are tested one by one.
    diverged: u32,
    /// Groups with hits since their frustum was shortened.
    stale: u32,
    /// A bit a ray: see [`rays_meeting`].
    lanes: [u64; WORDS],
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
            if let Some(numbers) = FewNumbers::in_entry(entry.rays) {
                self.trace_few::<T, COMMON_ORIGIN>(token, entry, numbers, stack, top);
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
                let few = if B::Leaves::TESTS_FEW && child.is_leaf() { AT_LEAF } else { SINGLE_RAYS };
                if groups == meeting && count <= few {
                    self.tree.prefetch(child);
                    let rays = FewNumbers::of(&self.lanes[..N.div_ceil(64)]);
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

    /// Traces the few rays of an entry: through a leaf together, through a subtree one by one.
    #[inline(always)]
    fn trace_few<T: Token, const COMMON_ORIGIN: bool>(
        &mut self,
        token: T,
        entry: Entry,
        numbers: FewNumbers,
        stack: &mut [Entry; STACK],
        base: usize,
    ) {
        let Some(Apart { origins: [x, y, z], .. }) = &self.apart else { return };
        let (mut left, mut count) = ([0; FewNumbers::MOST], 0);
        for i in numbers {
            if i < N && count < FewNumbers::MOST && entry.near <= self.rays.t_max[i] {
                left[count] = i;
                count += 1;
                self.stale |= 1 << (i / group_size(N));
            }
        }
        let (left, child, axis) = (&left[..count], entry.child, Some(self.frusta.axis()));
        if left.is_empty() {
            return;
        }
        let (tree, rays, sink) = (self.tree, &mut *self.rays, &mut *self.sink);
        if child.is_leaf()
            && tree.leaves().few::<T, N, COMMON_ORIGIN, S>(token, child.leaf_range(), rays, sink, left, axis)
        {
            return;
        }
        for &i in left {
            let ray = OneRay::of(rays, i, padded_origin(rays, [x[i], y[i], z[i]], i));
            let (hit, stack) = (sink.single(rays, i), &mut *stack);
            let found = if S::ANY {
                token.run(TraceSingle::<_, true> { tree, ray, hit, child, stack, base })
            } else {
                token.run(TraceSingle::<_, false> { tree, ray, hit, child, stack, base })
            };
            sink.set(rays, i, found);
        }
    }
}
