//! Kernels as values, at the packet widths that are compiled.

use alloc::boxed::Box;
use alloc::string::String;
use core::any::TypeId;

use mobula_simd::{AnyToken, Task, Token};

use super::{Dice, Draft, Kernel, Outcome, Work};
use crate::Properties;

/// Compiles kernels for these packet widths.
macro_rules! widths {
    ($($width:literal),+) => {
        /// The packet widths that kernels are compiled for: 64, with the feature `lab-wide` 16 and 256 too,
        /// and with `lab-widths` every width that they are tested at.
        pub const WIDTHS: &[usize] = &[$($width),+];

        /// A packet of the width at `place`.
        fn packet<K: Kernel>(place: usize, draft: &Draft<K::Primitive>) -> Box<dyn Bench> {
            let make = [$(packet_of::<K, $width>),+];
            make[place](draft)
        }

        /// Wide enough for all of them.
        const WIDEST: usize = {
            let (mut widest, mut at) = (0, 0);
            while at < WIDTHS.len() {
                widest = if WIDTHS[at] > widest { WIDTHS[at] } else { widest };
                at += 1;
            }
            widest
        };
    };
}

#[cfg(feature = "lab-widths")]
widths!(1, 7, 16, 24, 64, 100, 256);
#[cfg(all(not(feature = "lab-widths"), feature = "lab-wide"))]
widths!(16, 64, 256);
#[cfg(not(any(feature = "lab-widths", feature = "lab-wide")))]
widths!(64);

/// A [`Kernel`] as a value: what the lab does with kernels is compiled once for each type of primitive, not for each special
/// case, which are many.
pub(super) struct Table<P: 'static> {
    pub(super) id: fn() -> TypeId,
    pub(super) general: fn() -> &'static Self,
    pub(super) promises: Properties,
    pub(super) parallel: bool,
    /// Primitives in the case that is timed.
    pub(super) count: usize,
    pub(super) draw: fn(&mut Dice<'_>) -> P,
    pub(super) number: fn(&mut [P]),
    pub(super) timed: fn(&mut Draft<P>),
    pub(super) aim: fn(&mut Dice<'_>, &P) -> [f32; 3],
    pub(super) tests: fn(usize, usize) -> usize,
    pub(super) packet: fn(usize, &Draft<P>) -> Box<dyn Bench>,
    pub(super) twin: fn(AnyToken, usize, &Draft<P>) -> Outcome,
    pub(super) verify: fn(&Draft<P>, &Outcome) -> Result<(), String>,
    pub(super) agrees: fn(&Draft<P>, &Outcome, &Outcome) -> Result<(), String>,
}

impl<P> Table<P> {
    pub(super) const fn of<K: Kernel<Primitive = P>>() -> Self {
        Self {
            id: TypeId::of::<K>,
            general: || const { &Self::of::<K::General>() },
            promises: K::PROMISES,
            parallel: K::PARALLEL,
            count: K::PRIMITIVES,
            draw: K::draw,
            number: K::number,
            timed: K::timed,
            aim: K::aim,
            tests: K::tests,
            packet: packet::<K>,
            twin: run_twin::<K>,
            verify: K::verify,
            agrees: K::agrees,
        }
    }
}

/// A packet of some width, ready to run.
pub(super) trait Bench {
    fn run(&mut self, token: AnyToken, derive: bool, repeat: usize);
    fn outcome(&self) -> Outcome;
}

/// The kernel, again and again, in the level's region: a function of its own, whose symbol names level, kernel and width.
struct Passes<'a, K: Kernel, const N: usize> {
    work: &'a mut Work<K::Primitive, N>,
    repeat: usize,
}

impl<K: Kernel, const N: usize> Task for Passes<'_, K, N> {
    type Output = ();

    #[inline(always)]
    fn run<T: Token>(self, token: T) {
        for _ in 0..self.repeat {
            K::reset(self.work);
            K::run(token, self.work);
        }
    }
}

struct Packet<K: Kernel, const N: usize>(Box<Work<K::Primitive, N>>);

impl<K: Kernel, const N: usize> Bench for Packet<K, N> {
    fn run(&mut self, token: AnyToken, derive: bool, repeat: usize) {
        if derive {
            K::derive(token, &mut self.0);
        }
        token.run(Passes::<K, N> { work: &mut self.0, repeat });
    }

    fn outcome(&self) -> Outcome {
        self.0.outcome(N)
    }
}

fn packet_of<K: Kernel, const N: usize>(draft: &Draft<K::Primitive>) -> Box<dyn Bench> {
    Box::new(Packet::<K, N>(Work::new(draft, K::extra(N, draft.primitives.len()))))
}

/// What the one-lane twin makes of it. It does ray after ray, whatever the width of the packet they are poured into, so it
/// is compiled for the widest only.
fn run_twin<K: Kernel>(token: AnyToken, rays: usize, draft: &Draft<K::Primitive>) -> Outcome {
    let mut work = Work::<_, WIDEST>::new(draft, K::extra(rays, draft.primitives.len()));
    K::derive(token.twin(), &mut work);
    token.twin().run(Passes::<K, WIDEST> { work: &mut work, repeat: 1 });
    work.outcome(rays)
}
