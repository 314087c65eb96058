//! Kernels that test a leaf, by the three ways in which walks call it: see [`crate::leaf`].

use alloc::string::String;
use core::fmt::Debug;
use core::marker::PhantomData;
use core::ops::Range;

use mobula_simd::{Dispatch, Scalar, Task, Token};

use super::find::{ANY, CLOSEST, verify};
use super::{Dice, Draft, Kernel, Outcome, Work};
use crate::kernel::frusta::Frusta;
use crate::kernel::group_bounds::{GroupBounds, MIXED};
use crate::kernel::groups::group_size;
use crate::kernel::margin::Frame;
use crate::kernel::single::{OneRay, SingleRay};
use crate::leaf::{BLOCK, Block, Leaf};
use crate::oracle::{self, Truth};
use crate::sink::{AnyHit, Found, SingleHit, Sink};
use crate::{NO_HIT, Properties, Rays};

/// A block of primitives as the lab knows it.
pub trait LabBlock: Block<Primitive: Clone + Debug + Sync> + Debug {
    /// Relative to the distances involved, how far from a boundary hit and miss may be confused, and distances be off.
    const GUARD: f64;

    /// Draws a primitive.
    fn draw(dice: &mut Dice<'_>) -> Self::Primitive;

    /// A point of interest to aim a ray at.
    fn aim(dice: &mut Dice<'_>, primitive: &Self::Primitive) -> [f32; 3];

    /// What ground is made of between four corners, for traversals that are timed: the first two are along x, the others beyond.
    fn tile(corners: [[f32; 3]; 4]) -> [Self::Primitive; 2];

    /// The primitive at a place, as it was given.
    fn primitive(&self, place: usize) -> Self::Primitive;

    /// What is true, and how far the distance moves when the surface moves by as much as it is away: the size of the
    /// scene over the cosine. `None` where the oracle cannot tell.
    fn truth(primitive: &Self::Primitive, ray: &oracle::ExactRay) -> Option<(Truth, f64)>;
}

/// Rays that travel together, in groups: [`Leaf::packet`].
pub const PACKET: u8 = 0;
/// The same from one origin.
pub const COMMON_ORIGIN: u8 = 1;
/// The same in one direction.
pub const PARALLEL: u8 = 2;
/// Rays that have nothing in common, 64 at a time: [`Leaf::stream`].
pub const STREAM: u8 = 3;
/// Ray by ray: [`Leaf::single`].
pub const SINGLE: u8 = 4;
/// As many rays as fill a vector, each against four primitives: [`Leaf::few`].
pub const FEW: u8 = 5;

/// The kernel that tests one leaf of all primitives, looking for the closest hit or any.
#[derive(Debug)]
pub struct Leaves<B, const PATH: u8, const HIT: bool = CLOSEST, const UNIT: bool = false>(PhantomData<B>);

impl<B: LabBlock, const PATH: u8, const HIT: bool, const UNIT: bool> Kernel for Leaves<B, PATH, HIT, UNIT> {
    type Primitive = B;
    type General = Leaves<B, STREAM, CLOSEST, UNIT>;
    const PROMISES: Properties = match (PATH, UNIT) {
        (COMMON_ORIGIN, true) => Properties::COMMON_ORIGIN.union(Properties::NORMALIZED_DIRECTIONS),
        (COMMON_ORIGIN, false) => Properties::COMMON_ORIGIN,
        (_, true) => Properties::NORMALIZED_DIRECTIONS,
        (_, false) => Properties::empty(),
    };
    const PARALLEL: bool = PATH == PARALLEL;
    const PRIMITIVES: usize = 64 / BLOCK;

    fn tests(rays: usize, primitives: usize) -> usize {
        rays * primitives * BLOCK
    }

    fn draw(dice: &mut Dice<'_>) -> B {
        draw(dice)
    }

    fn number(blocks: &mut [B]) {
        number(blocks);
    }

    fn aim(dice: &mut Dice<'_>, block: &B) -> [f32; 3] {
        aim(dice, block)
    }

    fn derive<const N: usize>(token: impl Dispatch, work: &mut Work<B, N>) {
        work.derive();
        work.frusta = match PATH {
            COMMON_ORIGIN => work.frusta::<true>(token),
            PACKET | PARALLEL => work.frusta::<false>(token),
            _ => None,
        };
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<B, N>) {
        let Work { rays, primitives, hits, frusta, .. } = work;
        if HIT == ANY {
            test::<T, N, _, _, PATH>(token, primitives, 0..primitives.len(), rays, &mut AnyHit::opaque(), frusta);
        } else {
            test::<T, N, _, _, PATH>(token, primitives, 0..primitives.len(), rays, hits, frusta);
        }
    }

    fn verify(draft: &Draft<B>, outcome: &Outcome) -> Result<(), String> {
        verify_blocks(draft, outcome, HIT == ANY)
    }

    fn agrees(draft: &Draft<B>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        if HIT == ANY { any_agrees(draft, outcome, general) } else { outcome.answers_equal(general) }
    }
}

// What does not depend on the special case, once for all of them.

fn draw<B: LabBlock>(dice: &mut Dice<'_>) -> B {
    let mut block = B::EMPTY;
    for place in 0..BLOCK {
        block.set(place, 0, &B::draw(dice));
    }
    block
}

fn number<B: LabBlock>(blocks: &mut [B]) {
    for (at, block) in blocks.iter_mut().enumerate() {
        for place in 0..BLOCK {
            block.set(place, (at * BLOCK + place) as u32, &block.primitive(place));
        }
    }
}

fn aim<B: LabBlock>(dice: &mut Dice<'_>, block: &B) -> [f32; 3] {
    let primitive = block.primitive(dice.below(BLOCK));
    B::aim(dice, &primitive)
}

impl<B: LabBlock, const N: usize> Work<B, N> {
    /// What all leaves read, the same bits at every level.
    fn derive(&mut self) {
        self.rays.shears(Scalar::new());
        self.rays.inverse_directions(Scalar::new());
        let farthest = self.primitives.iter().fold(0.0, |far, block| block.whole().scale().max(far));
        self.frame = Frame { size: farthest, farthest, ..Frame::default() };
    }
}

fn verify_blocks<B: LabBlock>(draft: &Draft<B>, outcome: &Outcome, any: bool) -> Result<(), String> {
    verify(draft, outcome, any, B::GUARD, |ray| {
        let of = |block: &B| [0, 1, 2, 3].map(|place| B::truth(&block.primitive(place), ray));
        draft.primitives.iter().flat_map(of).collect()
    })
}

/// Does the search for any hit find one where the general search finds the nearest?
pub(super) fn any_agrees<P>(draft: &Draft<P>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
    for i in draft.range.clone() {
        // Rays that reach nowhere look as if they had hit.
        let was_hit = outcome.t_max(i) == f32::NEG_INFINITY && draft.rays[i].t_max != f32::NEG_INFINITY;
        if was_hit != (general.found(i) != NO_HIT) {
            return Err(alloc::format!("ray {i}: any hit {was_hit}, nearest {:#x}", general.found(i)));
        }
    }
    Ok(())
}

/// Tests one leaf.
#[inline(always)]
pub(super) fn test<T: Token, const N: usize, L: Leaf, S: Sink<N>, const PATH: u8>(
    token: T,
    leaves: &L,
    leaf: Range<usize>,
    rays: &mut Rays<N>,
    sink: &mut S,
    frusta: &Option<(Frusta, u32)>,
) {
    let mut travelling = 0;
    if let Some((frusta, groups)) = frusta {
        travelling = *groups;
        if PATH == COMMON_ORIGIN {
            leaves.packet::<T, N, true, S>(token, leaf.clone(), frusta, rays, sink, *groups);
        } else {
            leaves.packet::<T, N, false, S>(token, leaf.clone(), frusta, rays, sink, *groups);
        }
    }
    // The others, which no frustum is around: in the case that is timed there are none.
    let range = rays.range();
    let mut from = range.start / 64 * 64;
    while from < range.end {
        let mut others = 0u64;
        for i in range.start.max(from)..range.end.min(from + 64) {
            others |= u64::from(travelling >> (i / group_size(N)) & 1 == 0) << (i - from);
        }
        if PATH == SINGLE {
            while others != 0 {
                let i = from + others.trailing_zeros() as usize;
                others &= others - 1;
                let (ray, hit) = (OneRay::of(rays, i, [[f32::NAN; 3]; 2]), sink.single(rays, i));
                let found = if S::ANY {
                    token.run(LeafSingle::<_, true> { leaves, leaf: leaf.clone(), ray, hit })
                } else {
                    token.run(LeafSingle::<_, false> { leaves, leaf: leaf.clone(), ray, hit })
                };
                sink.set(rays, i, found);
            }
        } else if PATH == FEW {
            let mut left = others;
            while left != 0 {
                let (mut numbers, mut count) = ([0; 16], 0);
                while left != 0 && count < numbers.len() {
                    numbers[count] = from + left.trailing_zeros() as usize;
                    left &= left - 1;
                    count += 1;
                }
                if !leaves.few::<T, N, S>(token, leaf.clone(), rays, sink, &numbers[..count], None) {
                    leaves.stream(token, leaf.clone(), rays, sink, from / 64, others);
                    break;
                }
            }
        } else if others != 0 {
            leaves.stream(token, leaf.clone(), rays, sink, from / 64, others);
        }
        from += 64;
    }
}

/// One ray: a task, as in traversal, so that all packet widths share one copy of it.
struct LeafSingle<'a, L, const ANY: bool> {
    leaves: &'a L,
    leaf: Range<usize>,
    ray: OneRay,
    hit: SingleHit<'a>,
}

impl<L: Leaf, const ANY: bool> Task for LeafSingle<'_, L, ANY> {
    type Output = Found;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Found {
        let Self { leaves, leaf, ray, mut hit } = self;
        let token = token.narrow();
        leaves.single::<_, ANY>(token, leaf, &mut SingleRay::new(token, &ray).ray, &mut hit);
        hit.found
    }
}

impl<P, const N: usize> Work<P, N> {
    /// The frusta around the first class of groups, if any have one, and which groups they are. Shears are derived.
    pub(super) fn frusta<const CO: bool>(&self, token: impl Dispatch) -> Option<(Frusta, u32)> {
        token.dispatch(AroundFirst::<N, CO>::of(self)).frusta
    }
}

/// Bounds the groups of a packet, and the first class of them: a task, so that all kernels share one copy of it.
pub(super) struct AroundFirst<'a, const N: usize, const CO: bool> {
    rays: &'a Rays<N>,
    frame: &'a Frame,
}

/// What [`AroundFirst`] finds.
#[derive(Default)]
pub(super) struct Around {
    pub(super) bounds: Option<GroupBounds>,
    pub(super) frusta: Option<(Frusta, u32)>,
}

impl<'a, const N: usize, const CO: bool> AroundFirst<'a, N, CO> {
    pub(super) fn of<P>(work: &'a Work<P, N>) -> Self {
        Self { rays: &work.rays, frame: &work.frame }
    }
}

impl<const N: usize, const CO: bool> Task for AroundFirst<'_, N, CO> {
    type Output = Around;

    #[inline(always)]
    fn run<T: Token>(self, token: T) -> Around {
        let Self { rays, frame } = self;
        let range = rays.range();
        if range.is_empty() {
            return Around::default();
        }
        let bounds = GroupBounds::new::<T, N, CO>(token, rays, frame);
        let size = group_size(N);
        let mut class = MIXED;
        for group in range.start / size..range.end.div_ceil(size) {
            class = if class == MIXED { bounds.class(group) } else { class };
        }
        let mut around = Around { bounds: Some(bounds), frusta: None };
        if class != MIXED {
            around.frusta = Some((Frusta::new::<T, N, CO>(token, &bounds, rays, class), bounds.of_class(class)));
        }
        around
    }
}
