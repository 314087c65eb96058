//! Files that other programs wrote, where they are there.

use std::path::{Path, PathBuf};

use mobula::load::load;

use super::{kinds, only_particles, steps};

/// The folder with particles that are not part of the repository; `None`, with the reason printed, if it is not there.
fn folder() -> Option<PathBuf> {
    let folder = std::env::var_os("MOBULA_PARTICLES").map(PathBuf::from);
    let folder = folder.or_else(|| {
        let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/particles");
        beside.is_dir().then_some(beside)
    });
    if folder.is_none() {
        eprintln!("skipped: MOBULA_PARTICLES names no folder with particles");
    }
    folder
}

#[test]
fn particles_of_others_load() {
    let Some(folder) = folder() else { return };
    for (name, count, expected) in [
        ("waterbox", 132_303, &[("radius", "f32"), ("element", "u8")][..]),
        ("adk_03", 36_597, &[("radius", "f32"), ("speed", "f32"), ("element", "u8"), ("kind", "u8")]),
        ("funnel_flow_00", 57_453, &[("speed", "f32")]),
    ] {
        let file = folder.join(format!("{name}.ply.gz"));
        if !file.exists() {
            eprintln!("skipped: {} is not there", file.display());
            continue;
        }
        let loaded = load(&file).unwrap();
        assert_eq!(loaded.report.warnings, [""; 0]);
        let particles = only_particles(&loaded);
        assert_eq!((particles.name.as_str(), particles.count()), (name, count));
        assert_eq!(kinds(&steps::<1>(particles)[0]), expected);
    }
}
