//! One ray through the tree: against eight boxes at a time, then against what is in leaves.

use mobula_simd::{Task, Token};

use super::stack::{Entry, Met};
use crate::Rays;
use crate::bvh::{Child, Node, STACK, Tree};
use crate::kernel::single::{OneRay, SingleRay};
use crate::kernel::stream::Stream;
use crate::leaf::Leaf;
use crate::sink::{Found, SingleHit};

/// Traces a ray through a subtree: a task, so that walks of all packet widths share one copy of it. The stack is the caller's.
pub(super) struct TraceSingle<'a, B, const ANY: bool> {
    pub(super) tree: &'a B,
    pub(super) ray: OneRay,
    pub(super) hit: SingleHit<'a>,
    pub(super) child: Child,
    pub(super) stack: &'a mut [Entry; STACK],
    /// Where the stack is free.
    pub(super) base: usize,
}

impl<B: Tree, const ANY: bool> Task for TraceSingle<'_, B, ANY> {
    type Output = Found;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Found {
        let Self { tree, ray, hit, child, stack, base } = self;
        trace::<T, B, ANY>(token, tree, &ray, hit, child, stack, base)
    }
}

/// The same for ray `i` of a stream, which is read where it is. At AVX-512 a ray that was written number by number and is then
/// read as a vector waits for the stores: ambient occlusion and diffuse rays took a tenth longer by value, and by reference.
pub(super) struct TraceOfStream<'a, const W: usize, B, const ANY: bool> {
    pub(super) tree: &'a B,
    pub(super) rays: &'a Rays<W>,
    pub(super) stream: &'a Stream<W>,
    pub(super) i: usize,
    pub(super) hit: SingleHit<'a>,
    pub(super) child: Child,
    pub(super) stack: &'a mut [Entry; STACK],
    pub(super) base: usize,
}

impl<const W: usize, B: Tree, const ANY: bool> Task for TraceOfStream<'_, W, B, ANY> {
    type Output = Found;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Found {
        let Self { tree, rays, stream, i, hit, child, stack, base } = self;
        let ray = OneRay::of(rays, i, stream.padded_origin(i));
        trace::<T, B, ANY>(token, tree, &ray, hit, child, stack, base)
    }
}

#[inline(always)]
fn trace<T: Token, B: Tree, const ANY: bool>(
    token: T,
    tree: &B,
    ray: &OneRay,
    hit: SingleHit<'_>,
    child: Child,
    stack: &mut [Entry; STACK],
    base: usize,
) -> Found {
    let token = token.narrow();
    let mut walk = SingleWalk::<_, _, ANY> { token, tree, ray: SingleRay::new(token, ray), hit };
    walk.down(child, stack, base);
    walk.hit.found
}

struct SingleWalk<'a, T: Token, B, const ANY: bool> {
    token: T,
    tree: &'a B,
    ray: SingleRay<T>,
    hit: SingleHit<'a>,
}

impl<T: Token, B: Tree, const ANY: bool> SingleWalk<'_, T, B, ANY> {
    /// Walks down from a child; what waits is on the stack from `base`.
    #[inline(always)]
    fn down(&mut self, mut child: Child, stack: &mut [Entry; STACK], base: usize) {
        let mut top = base;
        let mut room = Node::EMPTY;
        loop {
            // Down to a leaf by the nearest child each time; the others wait.
            while !child.is_leaf() {
                let Some(node) = self.tree.node(child.index(), &mut room) else { return };
                child = self.nearest(node, stack, &mut top);
            }
            self.tree.leaves().single::<T, ANY>(self.token, child.leaf_range(), &mut self.ray.ray, &mut self.hit);
            if ANY && self.hit.found.hit {
                return;
            }
            child = loop {
                if top <= base {
                    return;
                }
                top -= 1;
                if stack[top].near <= self.hit.found.t_max {
                    break stack[top].child;
                }
            };
        }
    }

    /// The nearest child that the ray meets ([`Child::EMPTY`] if none); pushes the others, the nearer ones last.
    #[inline(always)]
    fn nearest(&self, node: &Node, stack: &mut [Entry; STACK], top: &mut usize) -> Child {
        let mut nears = [0.0; 8];
        let mut met = self.ray.boxes(self.token, &node.planes, &mut nears);
        let mut children = Met::new(stack, *top);
        while met != 0 {
            let slot = met.trailing_zeros() as usize % 8;
            met &= met - 1;
            let child = node.child[slot];
            self.tree.prefetch(child);
            children.add(Entry { child, near: nears[slot], rays: 1 }, !ANY);
        }
        *top = children.top;
        children.nearest.child
    }
}
