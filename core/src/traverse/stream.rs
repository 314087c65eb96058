//! A stream of rays through the tree: as long as several rays meet the same boxes they go together, then each as a single ray.
//!
//! Benthin et al., "Combining Single and Packet-Ray Tracing for Arbitrary Ray Distributions on the Intel MIC
//! Architecture", TVCG 2012.

use mobula_simd::{F32Lanes, MaskLanes, Task, Token};

use super::roots::Roots;
use super::single::TraceOfStream;
use super::stack::{Entry, Met};
use crate::bvh::{Node, STACK, Tree};
use crate::kernel::stream::Stream;
use crate::leaf::Leaf;
use crate::sink::Sink;
use crate::{Column, Rays};

/// So few rays go on as single rays: three that look for any hit where a vector has 16 lanes, more where it takes more vectors to test as
/// many together; those that look for the nearest hit a little earlier, as they want an order of their own.
const fn few(lanes: usize, any: bool) -> u32 {
    (if any { 48 } else { 96 }) / lanes as u32
}

/// So few rays that come to a leaf are tested there together: see [`Leaf::few`]. With fewer lanes than eight one ray is a vector, and
/// single rays are as fast.
const fn at_leaf(lanes: usize) -> usize {
    if lanes < 8 { 0 } else { 16 }
}

/// Those of a mask in the vector from `at`.
#[inline(always)]
fn part<T: Token>(rays: u64, at: usize) -> u32 {
    (rays >> at) as u32 & (u32::MAX >> (32 - T::LANES))
}

/// Traces `W` rays, 64 at most, that were copied out of a packet: a task, so that all packet widths share one copy of it.
pub(super) struct TraceStream<'a, const W: usize, B, S> {
    pub(super) tree: &'a B,
    pub(super) rays: &'a mut Rays<W>,
    pub(super) sink: &'a mut S,
    pub(super) active: u64,
    pub(super) roots: Roots,
    pub(super) stack: &'a mut [Entry; STACK],
}

impl<const W: usize, B: Tree, S: Sink<W>> Task for TraceStream<'_, W, B, S> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { tree, rays, sink, active, roots, stack } = self;
        let stream = Stream::new(token, rays, tree.frame());
        StreamWalk { tree, rays, sink, stream }.down(token, active, roots, stack);
    }
}

struct StreamWalk<'a, const W: usize, B, S> {
    tree: &'a B,
    rays: &'a mut Rays<W>,
    sink: &'a mut S,
    stream: Stream<W>,
}

impl<const W: usize, B: Tree, S: Sink<W>> StreamWalk<'_, W, B, S> {
    /// Walks the rays of a mask down from the roots.
    #[inline(always)]
    fn down<T: Token>(&mut self, token: T, rays: u64, roots: Roots, stack: &mut [Entry; STACK]) {
        let mut nears = [Column::splat(0.0); 8];
        let mut room = Node::EMPTY;
        for root in roots.of(self.tree) {
            stack[0] = Entry { child: root, near: f32::NEG_INFINITY, rays };
            let mut top = 1;
            while top > 0 {
                top -= 1;
                let mut entry = stack[top];
                entry.rays &= self.reaching(token, entry.near);
                while !entry.child.is_leaf() && entry.rays.count_ones() > few(T::LANES, S::ANY) {
                    let Some(node) = self.tree.node(entry.child.index(), &mut room) else { return };
                    entry = self.nearest(token, node, entry.rays, &mut nears, stack, &mut top);
                }
                if self.tested_few(token, entry) {
                    continue;
                }
                if entry.rays.count_ones() > few(T::LANES, S::ANY) {
                    self.tree.leaves().stream(token, entry.child.leaf_range(), self.rays, self.sink, entry.rays);
                } else {
                    self.trace_single_rays(token, entry, stack, top);
                }
            }
        }
    }

    /// Tests the rays of an entry together with a leaf, if they are few and it is one, and says so.
    #[inline(always)]
    fn tested_few<T: Token>(&mut self, token: T, entry: Entry) -> bool {
        let mut numbers = [0; 16];
        let count = entry.rays.count_ones() as usize;
        if !entry.child.is_leaf() || count > at_leaf(T::LANES) {
            return false;
        }
        let mut left = entry.rays;
        for number in &mut numbers[..count] {
            *number = left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
        }
        let (leaf, numbers) = (entry.child.leaf_range(), &numbers[..count]);
        self.tree.leaves().few::<T, W, false, S>(token, leaf, self.rays, self.sink, numbers, None)
    }

    /// Which rays may still hit something from `near` on.
    #[inline(always)]
    fn reaching<T: Token>(&self, token: T, near: f32) -> u64 {
        let mut reaching = 0;
        let mut at = 0;
        while at < W {
            let t_max = token.load(&self.rays.t_max[..], at);
            reaching |= u64::from(token.splat(near).le(t_max).bits()) << at;
            at += T::LANES;
        }
        reaching
    }

    /// The nearest child that any of the rays meets ([`Child::EMPTY`](crate::bvh::Child::EMPTY) and no rays if none); pushes the
    /// others, the nearer ones last.
    #[inline(always)]
    fn nearest<T: Token>(
        &self,
        token: T,
        node: &Node,
        rays: u64,
        nears: &mut [Column<f32, W>; 8],
        stack: &mut [Entry; STACK],
        top: &mut usize,
    ) -> Entry {
        // All tests first, then what follows from them: one branch that is hard to predict in place of one a child.
        let mut close = self.stream.boxes(token, &node.planes);
        let mut meeting = [0u64; 8];
        let mut met = 0u32;
        while close != 0 {
            let slot = close.trailing_zeros() as usize % 8;
            close &= close - 1;
            let (mut these, mut at) = (0, 0);
            while at < W {
                if part::<T>(rays, at) != 0 {
                    let (hit, near) = self.stream.rays(token, self.rays, &node.planes, slot, at);
                    these |= u64::from(hit.bits()) << at;
                    if !S::ANY {
                        near.store(&mut nears[slot][..], at);
                    }
                }
                at += T::LANES;
            }
            meeting[slot] = these & rays;
            met |= u32::from(meeting[slot] != 0) << slot;
        }
        let mut children = Met::new(stack, *top);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let child = node.child[slot];
            self.tree.prefetch(child);
            // The order of any hits is the node's.
            let near = if S::ANY { f32::NEG_INFINITY } else { Self::first(token, &nears[slot], meeting[slot]) };
            children.add(Entry { child, near, rays: meeting[slot] }, !S::ANY);
        }
        *top = children.top;
        children.nearest
    }

    /// Where the first of the rays gets to a child.
    #[inline(always)]
    fn first<T: Token>(token: T, nears: &Column<f32, W>, rays: u64) -> f32 {
        let inf = token.splat(f32::INFINITY);
        let mut first = inf;
        let mut at = 0;
        while at < W {
            first = token.load(&nears[..], at).select(token.mask(part::<T>(rays, at)), inf).min(first);
            at += T::LANES;
        }
        first.reduce_min()
    }

    /// Traces the few rays of an entry one by one.
    #[inline(always)]
    fn trace_single_rays<T: Token>(&mut self, token: T, entry: Entry, stack: &mut [Entry; STACK], top: usize) {
        let mut left = entry.rays;
        while left != 0 {
            let i = left.trailing_zeros() as usize % W;
            left &= left - 1;
            let (tree, rays, stream) = (self.tree, &*self.rays, &self.stream);
            let (child, hit, base) = (entry.child, self.sink.single(rays, i), top);
            let found = if S::ANY {
                token.run(TraceOfStream::<_, _, true> { tree, rays, stream, i, hit, child, stack, base })
            } else {
                token.run(TraceOfStream::<_, _, false> { tree, rays, stream, i, hit, child, stack, base })
            };
            self.sink.set(self.rays, i, found);
        }
    }
}
