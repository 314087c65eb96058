//! Any bytes as the material file of a small OBJ file.
#![no_main]

mod files;

use libfuzzer_sys::fuzz_target;

const OBJ: &[u8] = b"mtllib fuzz.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b c\nf 3 2 1\n";

fuzz_target!(|bytes: &[u8]| {
    files::write("fuzz.mtl", bytes);
    let _ = files::load(&files::write("uses.obj", OBJ));
});
