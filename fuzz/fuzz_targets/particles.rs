//! Any bytes as particles: PLY, CSV, XYZ, extended XYZ or a dump of LAMMPS by the first byte, or whatever they look like, as a file or
//! gzipped; behind the first byte. What is packed must load as what is plain.
#![no_main]

mod files;

use std::io::Write;

use flate2::{Compression, write::GzEncoder};
use libfuzzer_sys::fuzz_target;
use mobula::load::{LoadError, Loaded};
use mobula::particles::{ParticleStep, Particles};

const NAMES: [&str; 6] = ["fuzz.ply", "fuzz.csv", "fuzz.xyz", "fuzz.extxyz", "fuzz.dump", "fuzz"];

fuzz_target!(|bytes: &[u8]| {
    let Some((&how, bytes)) = bytes.split_first() else { return };
    let name = NAMES[usize::from(how) % NAMES.len()];
    let plain = load(name, bytes);
    // Anything gzipped twice stays gzip, anything of 16 bits becomes text of 8.
    if how >= 128 && !bytes.starts_with(&[0x1f, 0x8b]) {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        match (plain, load(&format!("{name}.gz"), &encoder.finish().unwrap())) {
            (Ok(plain), Ok(packed)) => assert!(same(&plain, &packed)),
            (Err(_), Err(_)) => {}
            (Ok(_), Err(packed)) => assert!(packed.problem.contains("unpacks to more"), "{packed}"),
            // Too long for the bytes that there are, which nobody knows of what is packed: behind the last row that is read.
            (Err(plain), Ok(_)) => assert!(plain.problem.contains("need at least"), "only packed it loads: {plain}"),
        }
    }
});

/// Loads a file and checks what must be true of all particles.
fn load(name: &str, bytes: &[u8]) -> Result<Loaded, LoadError> {
    let loaded = files::load(&files::write(name, bytes))?;
    let mut count = 0;
    for step in loaded.scene.particles.iter().flat_map(Particles::read) {
        let all = step.centers.len();
        assert!(step.centers.iter().flatten().all(|x| x.is_finite()));
        assert!(step.radii.is_empty() || step.radii.len() == all);
        assert!(step.attributes.iter().all(|attribute| attribute.values.len() == all));
        count += all as u64;
    }
    if !loaded.scene.particles.is_empty() {
        assert!(count > 0 && count == loaded.report.census.count("particles") - loaded.report.census.left_out());
    }
    Ok(loaded)
}

/// Are all particles the same, bit by bit?
fn same(a: &Loaded, b: &Loaded) -> bool {
    let bits = |step: &ParticleStep| {
        let numbers = step.centers.iter().flatten().chain(&step.radii).map(|x| x.to_bits());
        let values = step.attributes.iter().flat_map(|attribute| attribute.values.to_f32().into_owned());
        numbers.chain(values.map(f32::to_bits)).collect::<Vec<_>>()
    };
    let all = |loaded: &Loaded| {
        let steps = loaded.scene.particles.iter().flat_map(Particles::read);
        steps
            .map(|step| (bits(step), step.cell.map(|cell| cell.map(|edge| edge.map(f32::to_bits)))))
            .collect::<Vec<_>>()
    };
    all(a) == all(b)
}
