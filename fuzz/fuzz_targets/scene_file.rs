//! Any bytes as a scene file, beside a mesh, a volume and a transfer function that it may name: an error of one line, or a scene that
//! holds together and whose volumes can be shown.
#![no_main]

mod files;

use libfuzzer_sys::fuzz_target;
use mobula::geometry::IsoSurfaces;
use mobula::scene::{Shown, Steps, show};

fuzz_target!(|bytes: &[u8]| {
    // Generated scenes are large, other folders are no business of this, and escapes could hide both.
    if bytes.windows(4).any(|part| part == b"gen:") || bytes.iter().any(|byte| b"/\\".contains(byte)) {
        return;
    }
    files::write("m.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n");
    files::write("v.nrrd", b"NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\n\n01234567");
    files::write("t.txt", b"mobula transfer 1\n0 0 0 0 0\n90 1 1 1 5\n");
    let Ok(loaded) = files::load(&files::write("fuzz.toml", bytes)) else { return };
    let mut scene = loaded.scene;
    assert!(scene.shown.len() <= scene.volumes.len());
    if show(&mut scene, |_| Shown::default(), Steps::default()).is_ok() {
        let surfaces = scene.geometry.iter().filter_map(|geometry| geometry.downcast_ref::<IsoSurfaces>());
        let materials = surfaces.flat_map(|surfaces| &surfaces.materials);
        assert!(materials.into_iter().all(|&material| (material as usize) < scene.materials.len()));
    }
});
