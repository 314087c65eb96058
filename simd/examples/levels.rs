//! What this machine has: `cargo run -p mobula-simd --example levels`, and again with `MOBULA_ISA=sse2`.

use std::process::ExitCode;

use mobula_simd::{AnyToken, Level};

fn main() -> ExitCode {
    for level in Level::ALL {
        match AnyToken::for_level(level) {
            Ok(token) => {
                let family = if token.fused() { "fused" } else { "unfused" };
                println!("{level:8} {:2} lanes, {family}; its twin is {:?}", token.lanes(), token.twin());
            }
            Err(_) => println!("{level:8} not available"),
        }
    }
    match AnyToken::from_env() {
        Ok(token) => println!("chosen: {}", token.level()),
        Err(error) => {
            eprintln!("{error}");
            return ExitCode::from(2);
        }
    }
    ExitCode::SUCCESS
}
