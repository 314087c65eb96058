//! The kernel lab without the engine: checks kernels and times them, a few seconds after a change.
//! `cargo run --release -p mobula-core --features lab --example kernels -- [FILTER] [LEVEL...]`

use mobula_core::lab::{Dice, KERNELS, Plan, WIDTHS, filtered};
use mobula_core::simd::{AnyToken, Level};

#[cfg(feature = "lab-traversal")]
use mobula_core::lab::TRAVERSALS;
#[cfg(not(feature = "lab-traversal"))]
static TRAVERSALS: &[mobula_core::lab::Entry] = &[];

/// Cases that each kernel is checked on before it is timed.
const CASES: u64 = 200;

fn main() {
    let (levels, words): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|word| word.parse::<Level>().is_ok());
    let filter = words.first().map_or("", String::as_str);
    println!("{:<42}{:>8}{:>7}{:>14}", "kernel", "level", "width", "cycles/test");
    for entry in filtered(KERNELS, filter).into_iter().chain(filtered(TRAVERSALS, filter)) {
        for token in AnyToken::available() {
            if !levels.is_empty() && !levels.iter().any(|level| level.parse() == Ok(token.level())) {
                continue;
            }
            for &width in WIDTHS {
                for seed in 0..CASES {
                    if let Err(wrong) = entry.check(token, width, &mut Dice::from_seed(seed)) {
                        eprintln!("{wrong}");
                        std::process::exit(1);
                    }
                }
                let row = entry.measure(token, width, Plan::default());
                let name = format!("{} {}", entry.kernel, entry.case);
                println!("{name:<42}{:>8}{width:>7}{:>14.3}", token.level(), row.cycles);
            }
        }
    }
}
