//! One test a level.

use std::io::Write;

use mobula_simd::{AnyToken, Level};

/// Runs `body` at a level, or says that it did not.
pub(crate) fn at(level: Level, body: fn(AnyToken)) {
    match AnyToken::for_level(level) {
        Ok(token) => body(token),
        Err(_) => skip(level.name()),
    }
}

/// To standard error itself: the test harness hides what `eprintln!` says in a test that passes.
fn skip(name: &str) {
    let line = format!("skipped: {name} is not available on this machine\n");
    std::io::stderr().write_all(line.as_bytes()).unwrap();
}

/// One test a level for each body, a function of an `AnyToken`: `body_scalar`, `body_sse2`, ...
macro_rules! at_every_level {
    ($($body:ident),+ $(,)?) => {
        pastey::paste! {$(
            #[test]
            fn [<$body _scalar>]() {
                $crate::levels::at(mobula_simd::Level::Scalar, $body);
            }
            #[test]
            fn [<$body _sse2>]() {
                $crate::levels::at(mobula_simd::Level::Sse2, $body);
            }
            #[test]
            fn [<$body _avx2>]() {
                $crate::levels::at(mobula_simd::Level::Avx2, $body);
            }
            #[test]
            fn [<$body _avx512>]() {
                $crate::levels::at(mobula_simd::Level::Avx512, $body);
            }
        )+}
    };
}
pub(crate) use at_every_level;
