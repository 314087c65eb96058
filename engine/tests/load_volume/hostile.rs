//! Sizes that lie and data that is cut: refused, with little memory.

use std::fs;
use std::io::Write;

use mobula::load::load;

use super::{Folder, gzip, values};

/// The most memory that this process had, in bytes; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0) << 10
}

fn nrrd(kind: &str, sizes: &str, encoding: &str, bytes: &[u8]) -> Vec<u8> {
    let count = sizes.split(' ').count();
    let header =
        format!("NRRD0004\ntype: {kind}\ndimension: {count}\nsizes: {sizes}\nendian: big\nencoding: {encoding}\n\n");
    [header.as_bytes(), bytes].concat()
}

#[test]
fn a_small_file_with_a_large_header_costs_little() {
    let folder = Folder::new("large-header");
    let kilobyte = [7; 1024];
    let before = peak_memory();
    for (kind, sizes, bytes) in
        [("uint8", "2000 2000 2000", 8_000_000_000_u64), ("double", "4000 4000 4000 100", 51_200_000_000_000)]
    {
        let expected = format!(": {} bytes of voxels missing: ", bytes - 1024);
        let raw = folder.complaint("a.nrrd", nrrd(kind, sizes, "raw", &kilobyte));
        assert!(raw.contains(&expected), "{raw}");
        let packed = folder.complaint("a.nrrd", nrrd(kind, sizes, "gzip", &gzip(&kilobyte)));
        assert!(packed.contains(&expected), "{packed}");
        let whole = folder.complaint("a.nrrd.gz", gzip(&nrrd(kind, sizes, "raw", &kilobyte)));
        assert!(whole.contains(&expected), "{whole}");
        let text = folder.complaint("a.nrrd", nrrd(kind, sizes, "text", b"1 2 3"));
        assert!(text.contains(": voxels are missing: "), "{text}");
        let mha =
            format!("NDims = 3\nDimSize = 2000 2000 2000\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n{sizes}");
        assert!(folder.complaint("a.mha", mha).contains("bytes of voxels missing"));
    }
    let after = peak_memory();
    // Other tests of this process take some too.
    assert!(after - before < 400 << 20, "{} MiB", (after - before) >> 20);
}

#[test]
fn voxels_that_are_all_the_same_pack_well() {
    let folder = Folder::new("constant");
    let bytes = vec![5; 4 << 20];
    for (name, file) in [
        ("a.nrrd", nrrd("uint8", "256 128 128", "gzip", &gzip(&bytes))),
        ("a.nrrd.gz", gzip(&nrrd("uint8", "256 128 128", "raw", &bytes))),
    ] {
        assert!(file.len() < 1 << 14);
        let grid = folder.grid(name, file);
        assert_eq!(grid.range(), Some([5.0; 2]));
    }
    // More than the header says is not unpacked.
    let mut bomb = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    for _ in 0..256 {
        bomb.write_all(&bytes).unwrap();
    }
    let bomb = bomb.finish().unwrap();
    let loaded = folder.load("a.nrrd", nrrd("uint8", "2 2 2", "gzip", &bomb)).unwrap();
    assert!(loaded.report.warnings[0].ends_with("what is behind the voxels left out"));
    assert_eq!(values(&loaded.scene.volumes[0].steps[0]), [5.0; 8]);
}

#[test]
fn cut_anywhere_a_file_is_refused() {
    let folder = Folder::new("cut");
    let bytes: Vec<u8> = (0..240_u8).map(|i| i.wrapping_mul(37)).collect();
    let nifti = super::nifti::sample(&bytes);
    let mha = b"ObjectType = Image\nNDims = 3\nDimSize = 8 6 5\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    for (name, file) in [
        ("a.nrrd", nrrd("uint8", "8 6 5", "raw", &bytes)),
        ("b.nrrd", nrrd("uint8", "8 6 5", "gzip", &gzip(&bytes))),
        ("c.nrrd.gz", gzip(&nrrd("uint8", "8 6 5", "raw", &bytes))),
        ("a.nii", nifti.clone()),
        ("a.nii.gz", gzip(&nifti)),
        ("a.mha", [mha, &bytes[..]].concat()),
    ] {
        assert_eq!(folder.grid(name, &file).voxels().len(), 240);
        for length in 0..file.len() {
            folder.complaint(name, &file[..length]);
        }
    }
}

#[test]
fn any_byte_may_be_any_other() {
    let folder = Folder::new("bytes");
    let bytes: Vec<u8> = (0..12).collect();
    let text = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 3 2\nspacings: 1 2 3\nencoding: raw\n\n";
    let mha = "NDims = 3\nDimSize = 2 3 2\nOffset = 1 2 3\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n";
    for (name, file) in [
        ("a.nrrd", [text.as_bytes(), &bytes].concat()),
        ("a.mha", [mha.as_bytes(), &bytes].concat()),
        ("a.nii", super::nifti::small()),
    ] {
        for at in 0..file.len() {
            for byte in [0, 9, 10, b' ', b'-', b'0', b'9', b':', b'(', 0x7f, 0x80, 0xff] {
                let mut file = file.clone();
                file[at] = byte;
                match load(&folder.write(name, file)) {
                    Ok(loaded) => assert_eq!(loaded.scene.volumes.len(), 1),
                    Err(error) => assert!(!error.to_string().contains('\n')),
                }
            }
        }
    }
}
