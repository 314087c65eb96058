//! A whole traversal of a small tree, by the kind of rays: what a gain in a kernel is worth where it counts. A test is a ray.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::marker::PhantomData;

use mobula_simd::Token;

use crate::bvh::{Bvh, Quality, Serial};
use crate::lab::find::{ANY, CLOSEST, verify};
use crate::lab::leaves::{LabBlock, any_agrees};
use crate::lab::{Dice, Draft, Kernel, Outcome, Style, Work};
use crate::leaf::Block;
use crate::sink::AnyHit;
use crate::{Properties, traverse};

/// Rays from one origin.
pub const COMMON_ORIGIN: u8 = 0;
/// Rays in one direction.
pub const PARALLEL: u8 = 1;
/// Rays that have nothing in common.
pub const INCOHERENT: u8 = 2;

/// The traversal, looking for the closest hit or any; `ALL` primitives are tested without the tree.
#[derive(Debug)]
pub struct Traversal<B, const RAYS: u8, const HIT: bool, const ALL: bool = false>(PhantomData<B>);

/// Every primitive is tested: what traversal is compared with.
pub type All<B> = Traversal<B, INCOHERENT, CLOSEST, true>;
/// Rays that bounce off something rough.
pub type Diffuse<B> = Traversal<B, INCOHERENT, CLOSEST>;
/// Rays that ask how much of the sky is seen.
pub type Ambient<B> = Traversal<B, INCOHERENT, ANY>;
/// Rays of a pinhole camera.
pub type Primary<B> = Traversal<B, COMMON_ORIGIN, CLOSEST>;
/// Rays from a point light.
pub type Shadow<B> = Traversal<B, COMMON_ORIGIN, ANY>;
/// Rays to the sun.
pub type Sun<B> = Traversal<B, PARALLEL, ANY>;

/// Registers whole traversals, compiled in the crate that says so: where it traces packets of these widths itself, what is
/// measured is the code that it runs.
#[macro_export]
macro_rules! traversals {
    ($(#[$meta:meta])* $vis:vis static $name:ident;) => {
        $crate::kernels! {
            $(#[$meta])*
            $vis static $name;
            traversal {
                all: $crate::lab::kernels::traversal::All<$crate::leaf::TriangleBlock>,
                diffuse: $crate::lab::kernels::traversal::Diffuse<$crate::leaf::TriangleBlock>,
                ambient_occlusion: $crate::lab::kernels::traversal::Ambient<$crate::leaf::TriangleBlock>,
                primary: $crate::lab::kernels::traversal::Primary<$crate::leaf::TriangleBlock>,
                shadow: $crate::lab::kernels::traversal::Shadow<$crate::leaf::TriangleBlock>,
                sun: $crate::lab::kernels::traversal::Sun<$crate::leaf::TriangleBlock>,
            }
            traversal_spheres {
                all: $crate::lab::kernels::traversal::All<$crate::leaf::SphereBlock>,
                diffuse: $crate::lab::kernels::traversal::Diffuse<$crate::leaf::SphereBlock>,
                ambient_occlusion: $crate::lab::kernels::traversal::Ambient<$crate::leaf::SphereBlock>,
                primary: $crate::lab::kernels::traversal::Primary<$crate::leaf::SphereBlock>,
                shadow: $crate::lab::kernels::traversal::Shadow<$crate::leaf::SphereBlock>,
                sun: $crate::lab::kernels::traversal::Sun<$crate::leaf::SphereBlock>,
            }
        }
    };
}

/// A tree, and what it was built over.
#[derive(Clone, Debug)]
pub struct Tree<B: Block> {
    bvh: Arc<Bvh<B>>,
    primitives: Vec<B::Primitive>,
}

/// Vertices along a side of the ground that is timed.
const SIDE: usize = 48;

impl<B: LabBlock> Tree<B> {
    fn new(primitives: Vec<B::Primitive>) -> Self {
        let bvh = Arc::new(Bvh::build(primitives.len(), 0, Quality::Good, &Serial, |i| primitives[i]));
        Self { bvh, primitives }
    }

    /// Hills, of primitives that a packet sees several of.
    fn hills() -> Self {
        let corner = |x: usize, z: usize| {
            let [x, z] = [x, z].map(|at| at as f32 / (SIDE - 1) as f32 * 4.0 - 2.0);
            let bump = |a: f32| a * (1.0 - a.abs() / 2.0);
            [x, 0.6 * bump(2.0 * x - (2.0 * x).round()) * bump(2.0 * z - (2.0 * z).round()) - 0.8, z - 1.0]
        };
        let tile = |x, z| B::tile([corner(x, z), corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1)]);
        Self::new((0..SIDE - 1).flat_map(|x| (0..SIDE - 1).flat_map(move |z| tile(x, z))).collect())
    }
}

impl<B: LabBlock, const RAYS: u8, const HIT: bool, const ALL: bool> Kernel for Traversal<B, RAYS, HIT, ALL> {
    type Primitive = Tree<B>;
    type General = All<B>;
    const PROMISES: Properties = if RAYS == COMMON_ORIGIN { Properties::COMMON_ORIGIN } else { Properties::empty() };
    const PARALLEL: bool = RAYS == PARALLEL;
    const PRIMITIVES: usize = 1;

    fn tests(rays: usize, _trees: usize) -> usize {
        rays
    }

    fn draw(dice: &mut Dice<'_>) -> Tree<B> {
        let count = 1 + dice.below(40);
        Tree::new((0..count).map(|_| B::draw(dice)).collect())
    }

    fn timed(draft: &mut Draft<Tree<B>>) {
        draft.primitives = [Tree::hills()].into();
        if RAYS == INCOHERENT {
            let mut dice = Dice::from_seed(7);
            dice.set_style(Style::Ordinary);
            for ray in &mut draft.rays {
                let [x, y, z] = dice.point();
                (ray.origin, ray.direction) = ([1.5 * x, -0.2 + 0.2 * y, z - 1.0], dice.point());
            }
        }
    }

    /// A case has one tree.
    fn number(trees: &mut [Tree<B>]) {
        if let [first, others @ ..] = trees {
            others.iter_mut().for_each(|other| *other = first.clone());
        }
    }

    fn aim(dice: &mut Dice<'_>, tree: &Tree<B>) -> [f32; 3] {
        let primitive = &tree.primitives[dice.below(tree.primitives.len())];
        B::aim(dice, primitive)
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Tree<B>, N>) {
        let Work { rays, primitives, hits, .. } = work;
        let Some(tree) = primitives.first() else { return };
        if HIT == ANY {
            traverse::run(token, &*tree.bvh, rays, &mut AnyHit::opaque(), ALL);
        } else {
            traverse::run(token, &*tree.bvh, rays, hits, ALL);
        }
    }

    #[inline(always)]
    fn reset<const N: usize>(work: &mut Work<Tree<B>, N>) {
        work.restart();
        work.rays.forget(Properties::OF_DIRECTION - Properties::NORMALIZED_DIRECTIONS);
    }

    fn verify(draft: &Draft<Tree<B>>, outcome: &Outcome) -> Result<(), String> {
        let Some(tree) = draft.primitives.first() else { return Ok(()) };
        let narrow = Draft {
            rays: draft.rays.clone(),
            range: draft.range.clone(),
            primitives: tree.primitives.clone(),
            promises: draft.promises,
        };
        verify(&narrow, outcome, HIT == ANY, B::GUARD, |ray| {
            tree.primitives.iter().map(|primitive| B::truth(primitive, ray)).collect()
        })
    }

    fn agrees(draft: &Draft<Tree<B>>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        if HIT == ANY { any_agrees(draft, outcome, general) } else { outcome.answers_equal(general) }
    }
}
