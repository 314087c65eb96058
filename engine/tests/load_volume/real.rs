//! Files that other programs wrote, where they are there.

use std::path::{Path, PathBuf};

use mobula::load::load;
use mobula::volume::Statistics;

use super::only_volume;

/// The folder with volumes that are not part of the repository; `None`, with the reason printed, if it is not there.
fn volumes() -> Option<PathBuf> {
    let folder = std::env::var_os("MOBULA_VOLUMES").map(PathBuf::from);
    let folder = folder.or_else(|| {
        let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/volumes");
        beside.is_dir().then_some(beside)
    });
    if folder.is_none() {
        eprintln!("skipped: MOBULA_VOLUMES names no folder with volumes");
    }
    folder
}

#[test]
fn volumes_of_others_load() {
    let Some(folder) = volumes() else { return };
    for (name, kind, dims, steps, spacing, range) in [
        ("head_ct", "i16", [256, 256, 108], 1, [0.957031, 0.957031, 1.5], [-1024.0, 2986.0]),
        ("stent_cta", "u8", [128, 128, 256], 1, [1.0; 3], [0.0, 32.0]),
        ("funnel_density", "u8", [85, 125, 60], 8, [2.0; 3], [0.0, 119.0]),
        ("weather_t0", "f32", [83, 83, 10], 1, [1.0; 3], [277.6, 289.9]),
    ] {
        let file = folder.join(format!("{name}.nrrd"));
        if !file.exists() {
            eprintln!("skipped: {} is not there", file.display());
            continue;
        }
        let loaded = load(&file).unwrap();
        assert_eq!(loaded.report.warnings, [""; 0]);
        let volume = only_volume(&loaded);
        assert_eq!((volume.name.as_str(), volume.steps.len()), (name, steps));
        for grid in &volume.steps {
            assert_eq!((grid.dims(), grid.voxels().type_name(), grid.place().spacing()), (dims, kind, spacing));
        }
        // What was found when the files were made, where it was.
        let found = Statistics::of(volume).range.unwrap();
        assert!((0..2).all(|i| (found[i] - range[i]).abs() < 2.0), "{name}: {found:?}");
    }
}
