//! Every registered kernel: the first bytes choose kernel, width and level, the rest the case.
#![no_main]

use libfuzzer_sys::fuzz_target;
use mobula_core::lab::{Dice, KERNELS, WIDTHS};
use mobula_core::simd::AnyToken;

fuzz_target!(|bytes: &[u8]| {
    let [kernel, width, level, case @ ..] = bytes else { return };
    let kernel = &KERNELS[usize::from(*kernel) % KERNELS.len()];
    let width = WIDTHS[usize::from(*width) % WIDTHS.len()];
    let levels = AnyToken::available().count();
    let Some(token) = AnyToken::available().nth(usize::from(*level) % levels) else { return };
    if let Err(wrong) = kernel.check(token, width, &mut Dice::from_bytes(case)) {
        panic!("{wrong}");
    }
});
