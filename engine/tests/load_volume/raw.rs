//! Files of nothing but voxels.

use mobula::load::{Options, Raw, VoxelType, load, load_with};

use super::{Folder, gzip, only_volume, samples, values};

#[test]
fn every_type_and_order() {
    let folder = Folder::new("raw-types");
    for sample in samples() {
        let kind: VoxelType = sample.name.parse().unwrap();
        for (big_endian, bytes) in [(false, &sample.little), (true, &sample.big)] {
            let raw = Raw { dims: [2, 3, 2], steps: 2, kind, big_endian, spacing: [1.0, 2.0, 0.5] };
            let options = Options { raw: Some(raw), ..Options::default() };
            for (name, file) in [("a.raw", bytes.clone()), ("a.raw.gz", gzip(bytes)), ("a", bytes.clone())] {
                let loaded = load_with(&folder.write(name, file), &options).unwrap();
                let volume = only_volume(&loaded);
                let found: Vec<f64> = volume.steps.iter().flat_map(|step| values(step)).collect();
                assert_eq!(found, sample.values);
                assert_eq!(volume.steps[0].place().spacing(), [1.0, 2.0, 0.5]);
                assert_eq!((loaded.report.warnings.len(), volume.name.as_str()), (0, "a"));
            }
        }
    }
}

#[test]
fn what_looks_like_something_else_is_still_raw() {
    let folder = Folder::new("raw-looks");
    let raw = Raw { dims: [2, 2, 2], steps: 1, kind: VoxelType::U8, big_endian: false, spacing: [1.0; 3] };
    let options = Options { raw: Some(raw), ..Options::default() };
    for bytes in [b"NRRD0004", b"\x1f\x8b\x08\0\0\0\0\0", b"a\0b\0c\0d\0", b"v 1 2 3\n"] {
        let loaded = load_with(&folder.write("a.raw", bytes), &options).unwrap();
        assert_eq!(values(&only_volume(&loaded).steps[0]), bytes.map(f64::from));
    }
    // But what has the name of a format is of it.
    let error = load_with(&folder.write("a.nrrd", [0; 8]), &options).unwrap_err();
    assert!(error.to_string().contains("binary data"), "{error}");
}

#[test]
fn what_is_wrong_is_said() {
    let folder = Folder::new("raw-wrong");
    let file = folder.write("a.raw", [0; 24]);
    let said = |dims, spacing| {
        let raw = Raw { dims, steps: 1, kind: VoxelType::U16, big_endian: false, spacing };
        match load_with(&file, &Options { raw: Some(raw), ..Options::default() }) {
            Ok(loaded) => loaded.report.warnings.join("\n"),
            Err(error) => error.to_string(),
        }
    };
    for (dims, spacing, expected) in [
        ([2, 3, 2], [1.0; 3], ""),
        ([2, 3, 1], [1.0; 3], "a.raw: 12 bytes behind the voxels left out"),
        ([2, 3, 3], [1.0; 3], "a.raw: 12 bytes of voxels missing: 2 x 3 x 3 voxels of type u16 take 36 bytes"),
        ([2, 0, 3], [1.0; 3], "a.raw: a grid of 2 x 0 x 3 has no samples"),
        ([u64::MAX; 3], [1.0; 3], "has more than 65536 samples a side"),
        ([2, 3, 2], [1.0, 0.0, 1.0], "a.raw: the spacing of the grid is zero"),
        ([2, 3, 2], [1.0, f64::NAN, 1.0], "a.raw: the spacing or a direction of the grid is not finite"),
    ] {
        let said = said(dims, spacing);
        assert!(said.contains(expected) && said.is_empty() == expected.is_empty(), "{said}");
    }
    let unknown = load(&file).unwrap_err().to_string();
    assert!(unknown.contains("say of what: --raw-dims X,Y,Z --raw-type u16 for voxels"), "{unknown}");
}

#[test]
fn large_files_stay_where_they_are() {
    use std::io::{Seek, SeekFrom, Write};

    let folder = Folder::new("raw-large");
    // 256 MiB of which the disk has a few bytes.
    let (header, sides) =
        (b"NRRD0004\ntype: uint16\ndimension: 3\nsizes: 512 512 512\nendian: little\nencoding: raw\n\n\n", 512_u64);
    for (name, more) in [("a.nrrd", 0), ("b.nrrd", 5)] {
        let path = folder.write(name, header);
        // The voxels begin behind the empty line: the second one is part of the first voxel.
        let start = header.len() as u64 - 1;
        let mut file = std::fs::OpenOptions::new().write(true).open(&path).unwrap();
        file.seek(SeekFrom::Start(start + 2 * (sides * sides * 511 + 7))).unwrap();
        file.write_all(&[0x39, 0x05]).unwrap();
        file.set_len(start + 2 * sides.pow(3) + more).unwrap();
        let loaded = load(&path).unwrap();
        assert_eq!(loaded.report.warnings.len(), usize::from(more > 0), "{:?}", loaded.report.warnings);
        let voxels = only_volume(&loaded).steps[0].voxels();
        let mapped = start.is_multiple_of(2).then_some("U16(134217728 values in a file)");
        assert_eq!(format!("{voxels:?}"), mapped.unwrap_or("U16(134217728 values)"));
        assert_eq!([voxels.get(0), voxels.get(512 * 512 * 511 + 7), voxels.get(511)], [10.0, 1337.0, 0.0]);
    }
}
