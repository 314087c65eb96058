//! Every registered kernel, special case, level and width: equal to its twin bit for bit, to the general path where it
//! only hoists, to the oracle within its bound; inactive rays untouched. One test a level. `KERNEL=triangle` in the
//! environment leaves out all that have no such text in their names.

use mobula_core::lab::{Dice, Entry, KERNELS, WIDTHS, filtered};
use mobula_core::simd::{AnyToken, Level};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

#[cfg(feature = "lab-traversal")]
use mobula_core::lab::TRAVERSALS;
#[cfg(not(feature = "lab-traversal"))]
static TRAVERSALS: &[Entry] = &[];

fn kernels() -> Vec<&'static Entry> {
    let wanted = std::env::var("KERNEL").unwrap_or_default();
    let kernels = [filtered(KERNELS, &wanted), filtered(TRAVERSALS, &wanted)].concat();
    assert!(!kernels.is_empty(), "no kernel has {wanted:?} in its name");
    kernels
}

/// Runs `body` with the tokens of a level: its own, and where it is new the twin.
fn at(level: Level, body: fn(AnyToken)) {
    match AnyToken::for_level(level) {
        Ok(token) => body(token),
        Err(error) => eprintln!("skipped: {error}"),
    }
}

/// Drawn from bytes that proptest shrinks.
fn drawn(token: AnyToken) {
    let cases = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok()).unwrap_or(24);
    let bytes = prop::collection::vec(any::<u8>(), 0..600);
    for kernel in kernels() {
        for &width in WIDTHS {
            let config = Config { failure_persistence: None, cases, ..Config::default() };
            let outcome = TestRunner::new(config).run(&bytes, |bytes| {
                kernel
                    .check(token, width, &mut Dice::from_bytes(&bytes))
                    .map_err(|wrong| TestCaseError::fail(wrong.to_string()))
            });
            if let Err(failure) = outcome {
                panic!("{failure}");
            }
        }
    }
}

/// Many seeds: longer inputs than bytes make. All that fail are named.
fn seeded(token: AnyToken) {
    let mut wrong = Vec::new();
    for kernel in kernels() {
        let of_kernel = WIDTHS.iter().enumerate().find_map(|(place, &width)| {
            (0..2048 / width.max(16) as u64).find_map(|seed| {
                let seed = seed * 16 + place as u64;
                let outcome = kernel.check(token, width, &mut Dice::from_seed(seed));
                outcome.err().map(|wrong| format!("seed {seed}: {wrong}"))
            })
        });
        wrong.extend(of_kernel);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Every begin and end of the active rays, at widths that end within a vector, at its end, and after several.
fn ranges(token: AnyToken) {
    for kernel in kernels() {
        for &width in WIDTHS.iter().filter(|&&width| width <= 32) {
            if let Err(wrong) = kernel.check_ranges(token, width, width as u64) {
                panic!("{wrong}");
            }
        }
    }
}

macro_rules! at_every_level {
    ($($body:ident: $scalar:ident $sse2:ident $avx2:ident $avx512:ident),+) => {$(
        #[test]
        fn $scalar() {
            at(Level::Scalar, $body);
        }
        #[test]
        fn $sse2() {
            at(Level::Sse2, $body);
        }
        #[test]
        fn $avx2() {
            at(Level::Avx2, $body);
        }
        #[test]
        fn $avx512() {
            at(Level::Avx512, $body);
        }
    )+};
}
at_every_level!(
    drawn: drawn_scalar drawn_sse2 drawn_avx2 drawn_avx512,
    seeded: seeded_scalar seeded_sse2 seeded_avx2 seeded_avx512,
    ranges: ranges_scalar ranges_sse2 ranges_avx2 ranges_avx512
);

#[test]
fn names_are_unique_and_the_first_case_of_a_kernel_is_general() {
    let kernels: Vec<&Entry> = KERNELS.iter().chain(TRAVERSALS).collect();
    for (i, entry) in kernels.iter().enumerate() {
        let before = kernels[..i].iter().filter(|e| e.kernel == entry.kernel);
        assert!(before.clone().all(|e| e.case != entry.case), "{entry:?} twice");
        assert!(before.count() > 0 || entry.is_general_of(entry), "{entry:?}");
    }
}

#[test]
fn a_width_that_is_not_compiled_is_refused_by_name() {
    let refused = std::panic::catch_unwind(|| KERNELS[0].check(AnyToken::detect(), 5, &mut Dice::from_seed(1)).is_ok());
    assert!(refused.is_err());
}
