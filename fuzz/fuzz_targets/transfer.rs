//! Any bytes as a transfer function: an error of one line, or a function that could have been made in a program.
#![no_main]

#[allow(dead_code, reason = "targets of scenes use the rest")]
mod files;

use libfuzzer_sys::fuzz_target;
use mobula::load::load_transfer;
use mobula::volume::TransferFunction;

fuzz_target!(|bytes: &[u8]| {
    match load_transfer(&files::write("fuzz.txt", bytes)) {
        Ok(TransferFunction { name, points, values, lengths }) => {
            let function = TransferFunction::new(name, points, values, lengths).unwrap();
            for range in [[-1000.0, 1500.0], [0.0, 0.0], [f64::MIN, f64::MAX]] {
                let points = function.resolve(range, 0.5);
                assert!(points.is_sorted_by(|a, b| a.value <= b.value));
                assert!(points.iter().all(|point| (0.0..=f64::MAX).contains(&point.extinction)));
            }
        }
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
});
