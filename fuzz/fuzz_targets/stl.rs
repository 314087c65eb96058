//! Any bytes as an STL file, as text or binary, by their content; and what is packed must load as what is plain.
#![no_main]

mod files;

use std::io::Write;

use flate2::{Compression, write::GzEncoder};
use libfuzzer_sys::fuzz_target;
use mobula::geometry::Mesh;
use mobula::load::Loaded;

fuzz_target!(|bytes: &[u8]| {
    let plain = files::load(&files::write("fuzz.stl", bytes));
    if let Ok(loaded) = &plain {
        let mesh = mesh(loaded);
        assert!(mesh.normals.iter().flatten().all(|x| x.abs() <= 1.001), "made normals have length 1");
        let groups: u32 = mesh.groups.iter().map(|group| group.count).sum();
        assert!(groups == 0 || groups as usize == mesh.triangles.len());
    }
    // Anything gzipped twice stays gzip. What is text and binary at once is told apart by its length, which is known of plain files only.
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        let packed = files::load(&files::write("fuzz.stl.gz", &encoder.finish().unwrap()));
        if let (Ok(plain), Ok(packed)) = (&plain, &packed) {
            let bits = |mesh: &Mesh| mesh.positions.iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>();
            let (plain, packed) = (mesh(plain), mesh(packed));
            assert!(bits(plain) == bits(packed) && plain.triangles == packed.triangles);
        }
    }
});

fn mesh(loaded: &Loaded) -> &Mesh {
    loaded.scene.geometry[0].downcast_ref().unwrap()
}
