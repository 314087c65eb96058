//! The registry: kernels by name, whatever their type.

use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::any::TypeId;
use core::fmt;
use core::marker::PhantomData;

use mobula_simd::{AnyToken, Level, Task, Token, clock};

use super::{Dice, Draft, Kernel, Outcome, Work, cases};

/// Compiles kernels for these packet widths.
macro_rules! widths {
    ($($width:literal),+) => {
        /// The packet widths that kernels are compiled for: 64, with the feature `lab-wide` 16 and 256 too,
        /// and with `lab-widths` every width that they are tested at.
        pub const WIDTHS: &[usize] = &[$($width),+];

        /// A packet of the width at `place`.
        fn packet<K: Kernel>(place: usize, draft: &Draft<K::Primitive>) -> alloc::boxed::Box<dyn Bench> {
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
widths!(1, 7, 24, 64, 100, 256);
#[cfg(all(not(feature = "lab-widths"), feature = "lab-wide"))]
widths!(16, 64, 256);
#[cfg(not(any(feature = "lab-widths", feature = "lab-wide")))]
widths!(64);

/// A registered kernel. Made by [`kernels!`](crate::kernels).
#[derive(Clone, Copy)]
pub struct Entry {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Name of the special case; `general` is what the others are compared with.
    pub case: &'static str,
    lab: &'static dyn Lab,
}

impl fmt::Debug for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.kernel, self.case)
    }
}

/// An input for which a kernel is wrong.
#[derive(Clone, Debug)]
pub struct Counterexample {
    /// Kernel and special case.
    pub kernel: Entry,
    /// Token that it ran with.
    pub token: AnyToken,
    /// Packet width.
    pub width: usize,
    /// What is wrong, and with which input.
    pub what: String,
}

impl fmt::Display for Counterexample {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?} at {:?}, width {}: {}", self.kernel, self.token, self.width, self.what)
    }
}

impl core::error::Error for Counterexample {}

/// How to measure.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Clock ticks that a sample takes, about.
    pub ticks: u64,
    /// Samples, of which the fastest counts.
    pub samples: usize,
}

impl Default for Plan {
    fn default() -> Self {
        Self { ticks: 150_000, samples: 40 }
    }
}

/// A row of the matrix.
#[derive(Clone, Debug)]
pub struct Row {
    /// Name of the kernel.
    pub kernel: &'static str,
    /// Name of the special case.
    pub case: &'static str,
    /// Level.
    pub level: Level,
    /// Packet width.
    pub width: usize,
    /// Ticks of [`clock::ticks`] per test.
    pub ticks: f64,
    /// Cycles of the core's own clock per test, from a chain of additions timed beside.
    pub cycles: f64,
    /// Was it right, on the very input that was timed?
    pub correct: bool,
}

impl Entry {
    /// The entry of a kernel.
    pub const fn of<K: Kernel>(kernel: &'static str, case: &'static str) -> Self {
        Self { kernel, case, lab: &Of::<K>(PhantomData) }
    }

    /// Is it the path that `other` is a special case of? A general path is its own.
    pub fn is_general_of(&self, other: &Self) -> bool {
        self.kernel == other.kernel && self.lab.id() == other.lab.general_id()
    }

    /// Draws a case and holds the kernel against its one-lane twin (bit for bit), the general path, and the oracle;
    /// rays that are not active must be left alone.
    ///
    /// # Errors
    /// The case, if something is wrong.
    ///
    /// # Panics
    /// If `width` is not one of [`WIDTHS`].
    pub fn check(&self, token: AnyToken, width: usize, dice: &mut Dice<'_>) -> Result<(), Counterexample> {
        self.lab.check(token, place(width), dice).map_err(|what| Counterexample { kernel: *self, token, width, what })
    }

    /// As [`check`](Self::check), for every range of active rays of one case.
    ///
    /// # Errors
    /// The first that is wrong.
    ///
    /// # Panics
    /// If `width` is not one of [`WIDTHS`].
    pub fn check_ranges(&self, token: AnyToken, width: usize, seed: u64) -> Result<(), Counterexample> {
        self.lab.check_ranges(token, place(width), seed).map_err(|what| Counterexample {
            kernel: *self,
            token,
            width,
            what,
        })
    }

    /// Times the kernel on the packet of a pinhole camera, and checks it on the same input.
    ///
    /// # Panics
    /// If `width` is not one of [`WIDTHS`].
    pub fn measure(&self, token: AnyToken, width: usize, plan: Plan) -> Row {
        let (ticks, cycles, correct) = self.lab.measure(token, place(width), plan);
        Row { kernel: self.kernel, case: self.case, level: token.level(), width, ticks, cycles, correct }
    }

    /// Runs the timed case `times` times, for a bench that has a clock of its own. Returns the number of tests.
    ///
    /// # Panics
    /// If `width` is not one of [`WIDTHS`].
    pub fn prepare(&self, token: AnyToken, width: usize) -> alloc::boxed::Box<dyn FnMut(usize) -> usize> {
        self.lab.prepare(token, place(width))
    }
}

fn place(width: usize) -> usize {
    let place = WIDTHS.iter().position(|&w| w == width);
    place.unwrap_or_else(|| panic!("kernels are compiled for widths {WIDTHS:?}, not {width}"))
}

trait Lab: Sync {
    fn id(&self) -> TypeId;
    fn general_id(&self) -> TypeId;
    fn check(&self, token: AnyToken, place: usize, dice: &mut Dice<'_>) -> Result<(), String>;
    fn check_ranges(&self, token: AnyToken, place: usize, seed: u64) -> Result<(), String>;
    fn measure(&self, token: AnyToken, place: usize, plan: Plan) -> (f64, f64, bool);
    fn prepare(&self, token: AnyToken, place: usize) -> alloc::boxed::Box<dyn FnMut(usize) -> usize>;
}

struct Of<K>(PhantomData<fn() -> K>);

/// A packet of some width, ready to run.
trait Bench {
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

struct Packet<K: Kernel, const N: usize>(alloc::boxed::Box<Work<K::Primitive, N>>);

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

fn packet_of<K: Kernel, const N: usize>(draft: &Draft<K::Primitive>) -> alloc::boxed::Box<dyn Bench> {
    alloc::boxed::Box::new(Packet::<K, N>(Work::new(draft, K::extra(N, draft.primitives.len()))))
}

/// What the one-lane twin makes of it. It does ray after ray, whatever the width of the packet they are poured into, so it
/// is compiled for the widest only.
fn run_twin<K: Kernel>(token: AnyToken, place: usize, draft: &Draft<K::Primitive>) -> Outcome {
    let mut work = Work::<_, WIDEST>::new(draft, K::extra(WIDTHS[place], draft.primitives.len()));
    K::derive(token.twin(), &mut work);
    token.twin().run(Passes::<K, WIDEST> { work: &mut work, repeat: 1 });
    work.outcome(WIDTHS[place])
}

fn run<K: Kernel>(token: AnyToken, place: usize, draft: &Draft<K::Primitive>) -> Outcome {
    let mut packet = packet::<K>(place, draft);
    packet.run(token, true, 1);
    packet.outcome()
}

fn judge<K: Kernel>(token: AnyToken, place: usize, draft: &Draft<K::Primitive>) -> Result<(), String> {
    let before = packet::<K>(place, draft).outcome();
    let got = run::<K>(token, place, draft);
    let with = |which: &'static str| move |what: String| alloc::format!("{which}: {what}");
    got.untouched(&before, &draft.range).map_err(with("an inactive ray was touched"))?;
    if token.lanes() > 1 {
        got.equals(&run_twin::<K>(token, place, draft)).map_err(with("differs from its twin"))?;
    }
    if TypeId::of::<K>() != TypeId::of::<K::General>() {
        let general = run::<K::General>(token, place, draft);
        K::agrees(draft, &got, &general).map_err(with("differs from the general path"))?;
    }
    K::verify(draft, &got).map_err(with("differs from the oracle"))
}

impl<K: Kernel> Lab for Of<K> {
    fn id(&self) -> TypeId {
        TypeId::of::<K>()
    }

    fn general_id(&self) -> TypeId {
        TypeId::of::<K::General>()
    }

    fn check(&self, token: AnyToken, place: usize, dice: &mut Dice<'_>) -> Result<(), String> {
        let draft = cases::draw::<K>(dice, WIDTHS[place]);
        judge::<K>(token, place, &draft).map_err(|what| describe(&what, &draft.range))
    }

    fn check_ranges(&self, token: AnyToken, place: usize, seed: u64) -> Result<(), String> {
        let mut draft = cases::draw::<K>(&mut Dice::from_seed(seed), WIDTHS[place]);
        for begin in 0..=WIDTHS[place] {
            for end in begin..=WIDTHS[place] {
                draft.range = begin..end;
                judge::<K>(token, place, &draft).map_err(|what| describe(&what, &draft.range))?;
            }
        }
        Ok(())
    }

    fn measure(&self, token: AnyToken, place: usize, plan: Plan) -> (f64, f64, bool) {
        let draft = cases::timed::<K>(WIDTHS[place]);
        let correct = judge::<K>(token, place, &draft).is_ok();
        let mut packet = packet::<K>(place, &draft);
        packet.run(token, true, 1);
        let tests = K::tests(WIDTHS[place], draft.primitives.len()) as f64;
        let sample = |packet: &mut dyn Bench, repeat: usize| {
            let start = clock::ticks();
            packet.run(token, false, repeat);
            clock::ticks().saturating_sub(start)
        };
        let mut repeat = 1;
        while sample(&mut *packet, repeat) < plan.ticks / 2 && repeat < 1 << 30 {
            repeat *= 2;
        }
        let (mut ticks, mut chain) = (u64::MAX, u64::MAX);
        for _ in 0..plan.samples {
            ticks = ticks.min(sample(&mut *packet, repeat));
            let start = clock::ticks();
            clock::add_chain(CHAIN);
            chain = chain.min(clock::ticks().saturating_sub(start));
        }
        let ticks = ticks as f64 / (repeat as f64 * tests);
        (ticks, ticks * CHAIN as f64 / chain.max(1) as f64, correct)
    }

    fn prepare(&self, token: AnyToken, place: usize) -> alloc::boxed::Box<dyn FnMut(usize) -> usize> {
        let draft = cases::timed::<K>(WIDTHS[place]);
        let tests = K::tests(WIDTHS[place], draft.primitives.len());
        let mut packet = packet::<K>(place, &draft);
        packet.run(token, true, 1);
        alloc::boxed::Box::new(move |times| {
            packet.run(token, false, times);
            tests * times
        })
    }
}

/// Additions of the chain that the core's clock is measured with.
const CHAIN: u64 = 20_000;

fn describe(what: &str, range: &core::ops::Range<usize>) -> String {
    alloc::format!("{what} (active rays {range:?})").to_string()
}

/// Of some entries those whose `kernel case` contains `filter`.
pub fn filtered<'a>(entries: &'a [Entry], filter: &str) -> Vec<&'a Entry> {
    entries.iter().filter(|e| alloc::format!("{} {}", e.kernel, e.case).contains(filter)).collect()
}
