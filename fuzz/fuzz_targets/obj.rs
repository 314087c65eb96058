//! Any bytes as an OBJ file, beside materials that it may use.
#![no_main]

mod files;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    files::write("m.mtl", b"newmtl a\nKd 1 0 0\nnewmtl b\nKd 0 1 0\nd 0.5\n");
    let _ = files::load(&files::write("fuzz.obj", bytes));
});
