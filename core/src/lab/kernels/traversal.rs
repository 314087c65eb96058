//! A whole traversal of a small tree, by the kind of rays: what a gain in a kernel is worth where it counts. A test is a ray.

use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;

use mobula_simd::Token;

use crate::bvh::{Bvh, Serial};
use crate::lab::find::{ANY, CLOSEST, verify};
use crate::lab::leaves::{LabBlock, any_agrees};
use crate::lab::{Dice, Draft, Kernel, Outcome, Style, Work};
use crate::leaf::TriangleBlock;
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
pub struct Traversal<const RAYS: u8, const HIT: bool, const ALL: bool>;

/// Registers whole traversals, compiled in the crate that says so: where it traces packets of these widths itself, what is
/// measured is the code that it runs.
#[macro_export]
macro_rules! traversals {
    ($(#[$meta:meta])* $vis:vis static $name:ident;) => {
        $crate::kernels! {
            $(#[$meta])*
            $vis static $name;
            traversal {
                all: $crate::lab::kernels::traversal::Traversal<{ $crate::lab::kernels::traversal::INCOHERENT }, { $crate::lab::CLOSEST }, true>,
                diffuse: $crate::lab::kernels::traversal::Traversal<{ $crate::lab::kernels::traversal::INCOHERENT }, { $crate::lab::CLOSEST }, false>,
                ambient_occlusion: $crate::lab::kernels::traversal::Traversal<{ $crate::lab::kernels::traversal::INCOHERENT }, { $crate::lab::ANY }, false>,
                primary: $crate::lab::kernels::traversal::Traversal<{ $crate::lab::kernels::traversal::COMMON_ORIGIN }, { $crate::lab::CLOSEST }, false>,
                shadow: $crate::lab::kernels::traversal::Traversal<{ $crate::lab::kernels::traversal::COMMON_ORIGIN }, { $crate::lab::ANY }, false>,
                sun: $crate::lab::kernels::traversal::Traversal<{ $crate::lab::kernels::traversal::PARALLEL }, { $crate::lab::ANY }, false>,
            }
        }
    };
}

/// A tree, and what it was built over.
#[derive(Clone, Debug)]
pub struct Tree {
    bvh: Arc<Bvh<TriangleBlock>>,
    triangles: Vec<[[f32; 3]; 3]>,
}

/// Vertices along a side of the terrain that is timed.
const SIDE: usize = 48;

impl Tree {
    fn new(triangles: Vec<[[f32; 3]; 3]>) -> Self {
        let bvh = Arc::new(Bvh::triangles(triangles.len(), 0, &Serial, |i| triangles[i]));
        Self { bvh, triangles }
    }

    /// Hills, of triangles that a packet sees several of.
    fn terrain() -> Self {
        let corner = |x: usize, z: usize| {
            let [x, z] = [x, z].map(|at| at as f32 / (SIDE - 1) as f32 * 4.0 - 2.0);
            let bump = |a: f32| a * (1.0 - a.abs() / 2.0);
            [x, 0.6 * bump(2.0 * x - (2.0 * x).round()) * bump(2.0 * z - (2.0 * z).round()) - 0.8, z - 1.0]
        };
        let mut triangles = Vec::new();
        for x in 0..SIDE - 1 {
            for z in 0..SIDE - 1 {
                let [a, b, c, d] = [corner(x, z), corner(x + 1, z), corner(x, z + 1), corner(x + 1, z + 1)];
                triangles.extend([[a, c, b], [b, c, d]]);
            }
        }
        Self::new(triangles)
    }
}

impl<const RAYS: u8, const HIT: bool, const ALL: bool> Kernel for Traversal<RAYS, HIT, ALL> {
    type Primitive = Tree;
    type General = Traversal<INCOHERENT, CLOSEST, true>;
    const PROMISES: Properties = if RAYS == COMMON_ORIGIN { Properties::COMMON_ORIGIN } else { Properties::empty() };
    const PARALLEL: bool = RAYS == PARALLEL;
    const PRIMITIVES: usize = 1;

    fn tests(rays: usize, _trees: usize) -> usize {
        rays
    }

    fn draw(dice: &mut Dice<'_>) -> Tree {
        let count = 1 + dice.below(40);
        Tree::new((0..count).map(|_| TriangleBlock::draw(dice)).collect())
    }

    fn timed(draft: &mut Draft<Tree>) {
        draft.primitives = [Tree::terrain()].into();
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
    fn number(trees: &mut [Tree]) {
        if let [first, others @ ..] = trees {
            others.iter_mut().for_each(|other| *other = first.clone());
        }
    }

    fn aim(dice: &mut Dice<'_>, tree: &Tree) -> [f32; 3] {
        let triangle = &tree.triangles[dice.below(tree.triangles.len())];
        TriangleBlock::aim(dice, triangle)
    }

    #[inline(always)]
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Tree, N>) {
        let Work { rays, primitives, hits, .. } = work;
        let Some(tree) = primitives.first() else { return };
        if HIT == ANY {
            traverse::run(token, &tree.bvh, rays, &mut AnyHit::opaque(), ALL);
        } else {
            traverse::run(token, &tree.bvh, rays, hits, ALL);
        }
    }

    #[inline(always)]
    fn reset<const N: usize>(work: &mut Work<Tree, N>) {
        work.restart();
        work.rays.forget(Properties::OF_DIRECTION - Properties::NORMALIZED_DIRECTIONS);
    }

    fn verify(draft: &Draft<Tree>, outcome: &Outcome) -> Result<(), String> {
        let Some(tree) = draft.primitives.first() else { return Ok(()) };
        let narrow = Draft {
            rays: draft.rays.clone(),
            range: draft.range.clone(),
            primitives: tree.triangles.clone(),
            promises: draft.promises,
        };
        let guard = TriangleBlock::GUARD;
        verify(&narrow, outcome, HIT == ANY, guard, |ray| {
            tree.triangles.iter().map(|triangle| TriangleBlock::truth(triangle, ray)).collect()
        })
    }

    fn agrees(draft: &Draft<Tree>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        if HIT == ANY { any_agrees(draft, outcome, general) } else { outcome.answers_equal(general) }
    }
}
