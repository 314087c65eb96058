//! What a kernel tells the lab.

use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Debug;

use mobula_simd::{Dispatch, Token};

use super::{Dice, Draft, Outcome};
use crate::kernel::frusta::Frusta;
use crate::kernel::margin::Frame;
use crate::{Column, Hits, NO_HIT, Properties, Rays};

/// A kernel, or a special case of one, written once for every level and packet width.
///
/// Kernels that ask which primitive each ray hits are written as a [`RayTest`](super::RayTest) instead, which is less
/// work: [`Find`](super::Find) makes kernels of them.
pub trait Kernel: 'static {
    /// What rays are tested against; `()` for operations on packets alone.
    type Primitive: Clone + Debug + 'static;
    /// The path that this one is a special case of; itself if it is general.
    type General: Kernel<Primitive = Self::Primitive>;
    /// What it needs to know of the rays. Inputs are made so that it is true.
    const PROMISES: Properties = Properties::empty();
    /// Are all rays parallel? Inputs are made so that they are.
    const PARALLEL: bool = false;
    /// Primitives in the case that is timed.
    const PRIMITIVES: usize = 64;

    /// Draws a primitive.
    fn draw(dice: &mut Dice<'_>) -> Self::Primitive;

    /// Numbers the primitives of a case, where they hold their ids.
    fn number(_primitives: &mut [Self::Primitive]) {}

    /// Changes the case that is timed, where a packet of a pinhole camera and drawn primitives are not what it is to be timed on.
    fn timed(_draft: &mut Draft<Self::Primitive>) {}

    /// A point of interest to aim a ray at: corners, edges, outlines, the inside.
    fn aim(dice: &mut Dice<'_>, primitive: &Self::Primitive) -> [f32; 3];

    /// Floats of [`Work::extra`] that it writes.
    fn extra(_rays: usize, _primitives: usize) -> usize {
        0
    }

    /// How many tests [`run`](Self::run) does: what times are divided by.
    fn tests(rays: usize, primitives: usize) -> usize {
        rays * primitives
    }

    /// What is derived once per packet, before: not timed.
    fn derive<const N: usize>(_token: impl Dispatch, _work: &mut Work<Self::Primitive, N>) {}

    /// Undoes [`run`](Self::run) enough to run it again; timed.
    #[inline(always)]
    fn reset<const N: usize>(work: &mut Work<Self::Primitive, N>) {
        work.rays.t_max = work.t_max;
    }

    /// The kernel. Mark it `#[inline(always)]`, and put no closures around lanes.
    fn run<T: Token, const N: usize>(token: T, work: &mut Work<Self::Primitive, N>);

    /// Holds what came out against the truth.
    ///
    /// # Errors
    /// What is wrong.
    fn verify(draft: &Draft<Self::Primitive>, outcome: &Outcome) -> Result<(), String>;

    /// Holds what came out against what came out of the [`General`](Self::General) path: the same bits, as from work that
    /// is only hoisted. A special case that rounds otherwise states here by how much, and works the bound out.
    ///
    /// # Errors
    /// What differs.
    fn agrees(_draft: &Draft<Self::Primitive>, outcome: &Outcome, general: &Outcome) -> Result<(), String> {
        outcome.answers_equal(general)
    }
}

/// A packet with primitives, and where answers go. Rows of inactive rays must stay as they are.
#[derive(Clone, Debug)]
pub struct Work<P, const N: usize> {
    /// The rays; `t_max` is also an answer.
    pub rays: Rays<N>,
    /// What they are tested against.
    pub primitives: Vec<P>,
    /// What was hit, an answer; other kernels than those that look for hits leave any integer a ray there.
    pub hits: Hits<N>,
    /// The frame of the boxes, where [`Kernel::derive`] works it out.
    pub frame: Frame,
    /// The rays that travel together, and the groups that do, where [`Kernel::derive`] finds them.
    pub frusta: Option<(Frusta, u32)>,
    /// Answers of any other shape: [`Kernel::extra`] floats.
    pub extra: Vec<f32>,
    t_max: Column<f32, N>,
}

impl<P: Clone, const N: usize> Work<P, N> {
    /// Pours a case into a packet.
    pub(super) fn new(draft: &Draft<P>, extra: usize) -> Box<Self> {
        let mut rays = Rays::default();
        rays.reset(draft.range.clone(), Properties::empty());
        for (i, ray) in draft.rays.iter().enumerate() {
            rays.set_ray(i, ray.origin.into(), ray.direction.into());
            rays.set_interval(i, ray.t_min, ray.t_max);
        }
        // Found out when it is derived; the kernel takes it for granted.
        rays.promise(draft.promises - Properties::CONSTANT_SIGNS);
        let t_max = rays.t_max;
        Box::new(Self {
            rays,
            primitives: draft.primitives.clone(),
            hits: Hits::default(),
            frame: Frame::default(),
            frusta: None,
            // Not zero, so that a store too many or too few shows.
            extra: alloc::vec![-12345.0; extra],
            t_max,
        })
    }

    /// Undoes what was found.
    #[inline(always)]
    pub fn restart(&mut self) {
        self.rays.t_max = self.t_max;
        self.hits.primitive.fill(NO_HIT);
    }

    /// All that came out, of the first `width` rays.
    pub(super) fn outcome(&self, width: usize) -> Outcome {
        let bits = |column: &Column<f32, N>| column[..width].iter().map(|&x| canonical(x)).collect::<Vec<u32>>();
        let [dx, dy, dz] = self.rays.directions();
        let [ix, iy, iz] = self.rays.inverse_columns();
        let [sx, sy, sz] = self.rays.shear_columns();
        let columns = [&self.rays.t_max, dx, dy, dz, ix, iy, iz, sx, sy, sz].map(bits);
        Outcome {
            columns,
            found: self.hits.primitive[..width].to_vec(),
            axis: self.rays.axes()[..width].to_vec(),
            extra: self.extra.iter().map(|&x| canonical(x)).collect(),
            properties: self.rays.properties(),
        }
    }
}

/// The bits of a number; all NaN are one.
fn canonical(x: f32) -> u32 {
    if x.is_nan() { f32::NAN.to_bits() } else { x.to_bits() }
}
