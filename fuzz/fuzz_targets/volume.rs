//! Any bytes as a volume: NRRD, NIfTI or MetaImage by the first byte, as a file or gzipped, beside a small file that headers may name;
//! behind the first byte. What is packed must load as what is plain.
#![no_main]

mod files;

use std::io::Write;

use flate2::{Compression, write::GzEncoder};
use libfuzzer_sys::fuzz_target;
use mobula::load::{LoadError, Loaded};
use mobula::volume::Voxels;

const NAMES: [&str; 5] = ["fuzz.nrrd", "fuzz.nhdr", "fuzz.nii", "fuzz.mha", "fuzz.mhd"];

fuzz_target!(|bytes: &[u8]| {
    let Some((&how, bytes)) = bytes.split_first() else { return };
    files::write("d.raw", &[1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    let name = NAMES[usize::from(how) % NAMES.len()];
    let plain = load(name, bytes);
    // Anything gzipped twice stays gzip, anything of 16 bits becomes text of 8.
    if how >= 128 && !bytes.starts_with(&[0x1f, 0x8b]) {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(bytes).unwrap();
        match (plain, load(&format!("{name}.gz"), &encoder.finish().unwrap())) {
            (Ok(plain), Ok(packed)) => assert!(same(&plain, &packed)),
            (Err(_), Err(_)) => {}
            // From the end of what is packed nothing can be counted, and what is to be skipped may be out of proportion.
            (Ok(_), Err(packed)) => {
                assert!(packed.problem.contains("not packed") || packed.problem.contains("unpacks to more"), "{packed}");
            }
            (Err(plain), Ok(_)) => panic!("only packed it loads: {plain}"),
        }
    }
});

/// Loads a file and checks what must be true of every volume.
fn load(name: &str, bytes: &[u8]) -> Result<Loaded, LoadError> {
    let loaded = files::load(&files::write(name, bytes))?;
    let [volume] = &loaded.scene.volumes[..] else { panic!("{} volumes", loaded.scene.volumes.len()) };
    let mut count = 0;
    for step in &volume.steps {
        assert_eq!(step.dims(), volume.steps[0].dims());
        assert_eq!(step.dims().iter().product::<usize>(), step.voxels().len());
        assert!(step.place().axes.iter().all(|axis| axis.is_finite()) && step.place().origin.is_finite());
        count += step.voxels().len() as u64;
    }
    assert!(count > 0 && count == loaded.report.census.count("voxels"));
    assert!(loaded.report.bounds().is_some());
    Ok(loaded)
}

/// Are all voxels the same, bit by bit?
fn same(a: &Loaded, b: &Loaded) -> bool {
    let steps = |loaded: &Loaded| loaded.scene.volumes[0].steps.clone();
    let bits = |voxels: &Voxels| (0..voxels.len()).map(|i| voxels.get(i).to_bits()).collect::<Vec<_>>();
    let (a, b) = (steps(a), steps(b));
    a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| a.place() == b.place() && bits(a.voxels()) == bits(b.voxels()))
}
