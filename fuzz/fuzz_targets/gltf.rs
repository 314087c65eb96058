//! Any bytes as a glTF document or a GLB file, by their content. Files that it names are not there, but for itself.
#![no_main]

mod files;

use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let _ = files::load(&files::write("fuzz.gltf", bytes));
});
