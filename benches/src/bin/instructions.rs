//! Counts the instructions of a fixed set of kernels under callgrind, which no load of the machine disturbs:
//! `cargo run --release -p mobula-benches --bin instructions`.
//! Prints `kernel,case,level,width,instructions` (per test). With `--check FILE` it fails where a count is more than 2 %
//! above that of the file. Valgrind knows no AVX-512; those rows are skipped, as everything is where there is no valgrind.

use std::process::{Command, ExitCode};

use mobula_core::lab::Entry;
use mobula_core::simd::{AnyToken, Level};

/// Kernel and case; each at width 64.
const SET: [(&str, &str); 13] = [
    ("triangle", "stream"),
    ("triangle", "single"),
    ("triangle", "packet_common_origin"),
    ("sphere", "stream"),
    ("sphere", "packet_common_origin_unit"),
    ("node_packet", "common_origin"),
    ("node_diverged", "general"),
    ("node_stream", "closest"),
    ("node_single", "general"),
    ("frusta", "common_origin"),
    ("traversal", "primary"),
    ("traversal", "diffuse"),
    ("iso_cell", "general"),
];
const WIDTH: usize = 64;
const PASSES: usize = 20;
const TOLERANCE: f64 = 1.02;

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    match args.iter().map(String::as_str).collect::<Vec<_>>()[..] {
        ["run", kernel, case, level, passes] => run(kernel, case, level, passes),
        [] => report(None),
        ["--check", file] => report(Some(file)),
        _ => {
            eprintln!("usage: instructions [--check FILE]");
            ExitCode::from(2)
        }
    }
}

fn find(kernel: &str, case: &str) -> Option<Entry> {
    mobula_benches::kernels().into_iter().find(|entry| entry.kernel == kernel && entry.case == case)
}

/// What callgrind watches: a number of passes over the packet.
fn run(kernel: &str, case: &str, level: &str, passes: &str) -> ExitCode {
    let token = level.parse().ok().and_then(|level: Level| AnyToken::for_level(level).ok());
    let (Some(entry), Some(token), Ok(passes)) = (find(kernel, case), token, passes.parse()) else {
        return ExitCode::from(2);
    };
    println!("{}", entry.prepare(token, WIDTH)(passes));
    ExitCode::SUCCESS
}

/// Instructions per test, if valgrind can count them: the difference between many passes and one.
fn count(kernel: &str, case: &str, level: &str) -> Option<f64> {
    let of = |passes: usize| -> Option<(f64, f64)> {
        let this = std::env::current_exe().ok()?;
        let output = Command::new("valgrind")
            .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
            .arg(this)
            .args(["run", kernel, case, level, &passes.to_string()])
            .output()
            .ok()?;
        let text = String::from_utf8_lossy(&output.stderr);
        let collected = text.lines().find_map(|line| line.split("Collected : ").nth(1))?.trim().parse().ok()?;
        let tests = String::from_utf8_lossy(&output.stdout).trim().parse().ok()?;
        Some((collected, tests))
    };
    let (one, many) = (of(1)?, of(1 + PASSES)?);
    Some((many.0 - one.0) / (many.1 - one.1))
}

fn report(baseline: Option<&str>) -> ExitCode {
    let baseline = match baseline.map(std::fs::read_to_string).transpose() {
        Ok(baseline) => baseline,
        Err(error) => {
            eprintln!("cannot read the baseline: {error}");
            return ExitCode::from(2);
        }
    };
    let mut worse = 0;
    for (kernel, case) in SET {
        for level in ["scalar", "sse2", "avx2"] {
            let name = format!("{kernel},{case},{level},{WIDTH}");
            let Some(instructions) = count(kernel, case, level) else {
                eprintln!("skipped: {name}: valgrind is not there, or does not know the level");
                continue;
            };
            println!("{name},{instructions:.3}");
            let lines = baseline.iter().flat_map(|text| text.lines());
            let before =
                lines.filter_map(|line| line.strip_prefix(&name)?.strip_prefix(',')?.parse::<f64>().ok()).next();
            if before.is_some_and(|before| instructions > before * TOLERANCE) {
                eprintln!("{name}: {instructions:.3} instructions a test, were {:.3}", before.unwrap_or(0.0));
                worse += 1;
            }
        }
    }
    if worse > 0 { ExitCode::FAILURE } else { ExitCode::SUCCESS }
}
