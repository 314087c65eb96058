//! A word of rays through the tree: as long as several of them meet the same boxes they go together, then each as a single ray.
//!
//! Barringer and Akenine-Moeller, "Dynamic Ray Stream Traversal", TOG 2014.

use mobula_simd::{F32Lanes, MaskLanes, Task, Token};

use super::single::TraceOfStream;
use super::stack::{Entry, Met};
use crate::Rays;
use crate::bvh::{Child, Node, STACK, Tree};
use crate::kernel::stream::Stream;
use crate::kernel::words::word_size;
use crate::leaf::Leaf;
use crate::sink::Sink;

/// So few rays go on as single rays. With 16 lanes what streams do with all of them takes long for two.
const fn few(lanes: usize) -> u32 {
    if lanes < 16 { 1 } else { 2 }
}

/// So few rays that come to a leaf are tested there together: see [`Leaf::few`].
pub(super) const AT_LEAF: usize = 16;

/// Traces rays of a word of a packet through a subtree: a task, so that all places that do share one copy of it.
pub(super) struct TraceStream<'a, const N: usize, B, S> {
    pub(super) tree: &'a B,
    pub(super) rays: &'a mut Rays<N>,
    pub(super) stream: &'a Stream<N>,
    pub(super) sink: &'a mut S,
    /// The dominant axis of all directions, if it is one.
    pub(super) axis: Option<usize>,
    pub(super) child: Child,
    pub(super) word: usize,
    pub(super) active: u64,
    pub(super) stack: &'a mut [Entry; STACK],
    /// Where the stack is free.
    pub(super) base: usize,
}

impl<const N: usize, B: Tree, S: Sink<N>> Task for TraceStream<'_, N, B, S> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        let Self { tree, rays, stream, sink, axis, child, word, active, stack, base } = self;
        let word = word % N.div_ceil(64);
        StreamWalk { tree, rays, stream, sink, axis, word }.down(token, child, active, stack, base);
    }
}

struct StreamWalk<'a, const N: usize, B, S> {
    tree: &'a B,
    rays: &'a mut Rays<N>,
    stream: &'a Stream<N>,
    sink: &'a mut S,
    axis: Option<usize>,
    word: usize,
}

impl<const N: usize, B: Tree, S: Sink<N>> StreamWalk<'_, N, B, S> {
    /// Walks rays down from a child; what waits is on the stack from `base`.
    #[inline(always)]
    fn down<T: Token>(&mut self, token: T, child: Child, rays: u64, stack: &mut [Entry; STACK], base: usize) {
        let mut room = Node::EMPTY;
        let mut top = base;
        let mut entry = Entry { child, near: f32::NEG_INFINITY, rays };
        loop {
            while !entry.child.is_leaf() && entry.rays.count_ones() > few(T::LANES) {
                let Some(node) = self.tree.node(entry.child.index(), &mut room) else { return };
                entry = self.nearest(token, node, entry.rays, stack, &mut top);
            }
            if !self.tested_few(token, entry) {
                if entry.rays.count_ones() > few(T::LANES) {
                    let leaf = entry.child.leaf_range();
                    self.tree.leaves().stream(token, leaf, self.rays, self.sink, self.word, entry.rays);
                } else {
                    self.trace_single_rays(token, entry, stack, top);
                }
            }
            if top <= base {
                return;
            }
            top -= 1;
            entry = stack[top];
            entry.rays &= reaching(token, self.rays, self.word, entry.near);
        }
    }

    /// Tests the rays of an entry together with a leaf, if they are few and it is one, and says so.
    #[inline(always)]
    fn tested_few<T: Token>(&mut self, token: T, entry: Entry) -> bool {
        let mut numbers = [0; AT_LEAF];
        let count = entry.rays.count_ones() as usize;
        if !entry.child.is_leaf() || count > AT_LEAF {
            return false;
        }
        let mut left = entry.rays;
        for number in &mut numbers[..count] {
            *number = 64 * self.word + left.trailing_zeros() as usize;
            left &= left.wrapping_sub(1);
        }
        let (leaf, numbers) = (entry.child.leaf_range(), &numbers[..count]);
        self.tree.leaves().few::<T, N, S>(token, leaf, self.rays, self.sink, numbers, self.axis)
    }

    /// The nearest child that any of the rays meets ([`Child::EMPTY`] and no rays if none); pushes the others, the nearer ones last.
    #[inline(always)]
    fn nearest<T: Token>(
        &self,
        token: T,
        node: &Node,
        rays: u64,
        stack: &mut [Entry; STACK],
        top: &mut usize,
    ) -> Entry {
        let (planes, word) = (&node.planes, self.word);
        let meetings = if S::ANY {
            self.stream.meetings::<T, true>(token, self.rays, planes, word, rays)
        } else {
            self.stream.meetings::<T, false>(token, self.rays, planes, word, rays)
        };
        let mut left = meetings.boxes;
        let mut children = Met::new(stack, *top);
        while left != 0 {
            let slot = left.trailing_zeros() as usize % 8;
            left &= left - 1;
            let (child, near, rays) = (node.child[slot], meetings.near[slot], meetings.rays[slot]);
            self.tree.prefetch(child);
            // The order of any hits is the node's.
            let near = if S::ANY { f32::NEG_INFINITY } else { near };
            children.add(Entry { child, near, rays }, !S::ANY);
        }
        *top = children.top;
        children.nearest
    }

    /// Traces the few rays of an entry one by one.
    #[inline(always)]
    fn trace_single_rays<T: Token>(&mut self, token: T, entry: Entry, stack: &mut [Entry; STACK], top: usize) {
        let mut left = entry.rays;
        while left != 0 {
            let i = (64 * self.word + left.trailing_zeros() as usize % 64) % N;
            left &= left - 1;
            let (tree, rays, stream) = (self.tree, &*self.rays, self.stream);
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

/// Which rays of a word may still hit something from `near` on.
#[inline(always)]
pub(super) fn reaching<T: Token, const N: usize>(token: T, rays: &Rays<N>, word: usize, near: f32) -> u64 {
    let (mut reaching, mut lane) = (0, 0);
    while lane < word_size(N) {
        let t_max = token.load(&rays.t_max[..], 64 * word + lane);
        reaching |= u64::from(token.splat(near).le(t_max).bits()) << lane;
        lane += T::LANES;
    }
    reaching
}
