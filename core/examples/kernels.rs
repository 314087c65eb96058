//! The kernel lab without the engine: checks kernels and times them, a few seconds after a change.
//! `cargo run --release -p mobula-core --features lab --example kernels -- [FILTER] [LEVEL...]`

use std::process::ExitCode;

use mobula_core::lab::{Dice, KERNELS, Plan, WIDTHS, filtered};
use mobula_core::simd::{AnyToken, Level};

#[cfg(feature = "lab-traversal")]
use mobula_core::lab::TRAVERSALS;
#[cfg(not(feature = "lab-traversal"))]
static TRAVERSALS: &[mobula_core::lab::Entry] = &[];

/// Cases that each kernel is checked on before it is timed.
const CASES: u64 = 200;

fn main() -> ExitCode {
    let (levels, names): (Vec<_>, Vec<_>) = std::env::args().skip(1).partition(|word| word.parse::<Level>().is_ok());
    let levels: Vec<Level> = levels.iter().flat_map(|level| level.parse()).collect();
    if let Some(error) = levels.iter().find_map(|&level| AnyToken::for_level(level).err()) {
        eprintln!("{error}, or this was built without it");
        return ExitCode::from(2);
    }
    let filter = names.join(" ");
    let kernels = [filtered(KERNELS, &filter), filtered(TRAVERSALS, &filter)].concat();
    if kernels.is_empty() {
        let mut known: Vec<&str> = KERNELS.iter().chain(TRAVERSALS).map(|entry| entry.kernel).collect();
        known.dedup();
        eprintln!("no kernel or special case has {filter:?} in its name; the kernels are {}", known.join(", "));
        eprintln!("(traversal and traversal_spheres with the feature lab-traversal)");
        return ExitCode::from(2);
    }
    println!("{:<42}{:>8}{:>7}{:>14}", "kernel", "level", "width", "cycles/test");
    for entry in kernels {
        for token in AnyToken::available() {
            if !levels.is_empty() && !levels.contains(&token.level()) {
                continue;
            }
            for &width in WIDTHS {
                for seed in 0..CASES {
                    if let Err(wrong) = entry.check(token, width, &mut Dice::from_seed(seed)) {
                        eprintln!("{wrong}");
                        return ExitCode::FAILURE;
                    }
                }
                let row = entry.measure(token, width, Plan::default());
                let name = format!("{} {}", entry.kernel, entry.case);
                println!("{name:<42}{:>8}{width:>7}{:>14.3}", token.level(), row.cycles);
            }
        }
    }
    ExitCode::SUCCESS
}
