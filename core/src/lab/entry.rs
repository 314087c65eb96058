//! The registry: kernels by name, whatever their type.

use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::any::TypeId;
use core::fmt;

use mobula_simd::{AnyToken, Level, clock};

use super::table::{Bench, Table, WIDTHS};
use super::{Dice, Draft, Kernel, Outcome, cases};

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
        Self { kernel, case, lab: const { &Table::of::<K>() } }
    }

    /// Is it the path that `other` is a special case of? A general path is its own.
    pub fn is_general_of(&self, other: &Self) -> bool {
        self.kernel == other.kernel && self.lab.id() == other.lab.general()
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
    pub fn prepare(&self, token: AnyToken, width: usize) -> Box<dyn FnMut(usize) -> usize> {
        self.lab.prepare(token, place(width))
    }
}

fn place(width: usize) -> usize {
    let place = WIDTHS.iter().position(|&w| w == width);
    place.unwrap_or_else(|| panic!("kernels are compiled for widths {WIDTHS:?}, not {width}"))
}

trait Lab: Sync {
    fn id(&self) -> TypeId;
    fn general(&self) -> TypeId;
    fn check(&self, token: AnyToken, place: usize, dice: &mut Dice<'_>) -> Result<(), String>;
    fn check_ranges(&self, token: AnyToken, place: usize, seed: u64) -> Result<(), String>;
    fn measure(&self, token: AnyToken, place: usize, plan: Plan) -> (f64, f64, bool);
    fn prepare(&self, token: AnyToken, place: usize) -> Box<dyn FnMut(usize) -> usize>;
}

impl<P> Table<P> {
    fn run(&self, token: AnyToken, place: usize, draft: &Draft<P>) -> Outcome {
        let mut packet = (self.packet)(place, draft);
        packet.run(token, true, 1);
        packet.outcome()
    }

    fn judge(&self, token: AnyToken, place: usize, draft: &Draft<P>) -> Result<(), String> {
        let before = (self.packet)(place, draft).outcome();
        let got = self.run(token, place, draft);
        let with =
            |which: &'static str| move |what: String| alloc::format!("{which}: {what} (active rays {:?})", draft.range);
        got.untouched(&before, &draft.range).map_err(with("an inactive ray was touched"))?;
        if token.lanes() > 1 {
            got.equals(&(self.twin)(token, WIDTHS[place], draft)).map_err(with("differs from its twin"))?;
        }
        let general = (self.general)();
        if (self.id)() != (general.id)() {
            let general = general.run(token, place, draft);
            (self.agrees)(draft, &got, &general).map_err(with("differs from the general path"))?;
        }
        (self.verify)(draft, &got).map_err(with("differs from the oracle"))
    }
}

impl<P> Lab for Table<P> {
    fn id(&self) -> TypeId {
        (self.id)()
    }

    fn general(&self) -> TypeId {
        ((self.general)().id)()
    }

    fn check(&self, token: AnyToken, place: usize, dice: &mut Dice<'_>) -> Result<(), String> {
        self.judge(token, place, &cases::draw(self, dice, WIDTHS[place]))
    }

    fn check_ranges(&self, token: AnyToken, place: usize, seed: u64) -> Result<(), String> {
        let mut draft = cases::draw(self, &mut Dice::from_seed(seed), WIDTHS[place]);
        for begin in 0..=WIDTHS[place] {
            for end in begin..=WIDTHS[place] {
                draft.range = begin..end;
                self.judge(token, place, &draft)?;
            }
        }
        Ok(())
    }

    fn measure(&self, token: AnyToken, place: usize, plan: Plan) -> (f64, f64, bool) {
        let draft = cases::timed(self, WIDTHS[place]);
        let correct = self.judge(token, place, &draft).is_ok();
        let tests = (self.tests)(WIDTHS[place], draft.primitives.len());
        let (ticks, cycles) = time(&mut *(self.packet)(place, &draft), token, tests, plan);
        (ticks, cycles, correct)
    }

    fn prepare(&self, token: AnyToken, place: usize) -> Box<dyn FnMut(usize) -> usize> {
        let draft = cases::timed(self, WIDTHS[place]);
        let tests = (self.tests)(WIDTHS[place], draft.primitives.len());
        let mut packet = (self.packet)(place, &draft);
        packet.run(token, true, 1);
        Box::new(move |times| {
            packet.run(token, false, times);
            tests * times
        })
    }
}

/// The least ticks and cycles of the core's clock that a test takes.
fn time(packet: &mut dyn Bench, token: AnyToken, tests: usize, plan: Plan) -> (f64, f64) {
    packet.run(token, true, 1);
    let sample = |packet: &mut dyn Bench, repeat: usize| {
        let start = clock::ticks();
        packet.run(token, false, repeat);
        clock::ticks().saturating_sub(start)
    };
    let mut repeat = 1;
    while sample(packet, repeat) < plan.ticks / 2 && repeat < 1 << 30 {
        repeat *= 2;
    }
    let (mut ticks, mut chain) = (u64::MAX, u64::MAX);
    for _ in 0..plan.samples {
        ticks = ticks.min(sample(packet, repeat));
        let start = clock::ticks();
        clock::add_chain(CHAIN);
        chain = chain.min(clock::ticks().saturating_sub(start));
    }
    let ticks = ticks as f64 / (repeat as f64 * tests as f64);
    (ticks, ticks * CHAIN as f64 / chain.max(1) as f64)
}

/// Additions of the chain that the core's clock is measured with.
const CHAIN: u64 = 20_000;

/// Of some entries those whose `kernel case` contains `filter`.
pub fn filtered<'a>(entries: &'a [Entry], filter: &str) -> Vec<&'a Entry> {
    entries.iter().filter(|e| alloc::format!("{} {}", e.kernel, e.case).contains(filter)).collect()
}
