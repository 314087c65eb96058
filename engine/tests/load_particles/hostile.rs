//! Counts that lie, data that is cut, bytes that are any others: refused, with little memory.

use std::fs;

use mobula::load::load;
use proptest::prelude::*;

use super::ply::file;
use super::{Folder, gzip, only_particles};

/// The most memory that this process had, in bytes; 0 where the system does not tell.
fn peak_memory() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|line| line.split_whitespace().next()?.parse::<u64>().ok()).unwrap_or(0) << 10
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";

#[test]
fn a_small_file_that_speaks_of_many_particles_costs_little() {
    let folder = Folder::new("lying");
    let before = peak_memory();
    for count in ["1000000000000", "18446744073709551615"] {
        for encoding in ["ascii", "binary_little_endian"] {
            let mut bytes = file(encoding, &format!("element vertex {count}\n{XYZ}"), &[]);
            bytes.extend(b"1 2 3\n".repeat(20));
            let plain = folder.complaint("a.ply", &bytes);
            assert!(plain.starts_with("a.ply:3: ") && plain.contains("but there are only 120"), "{plain}");
            let packed = folder.complaint("a.ply.gz", gzip(&bytes));
            assert!(packed.contains(&format!("of {count} rows of 'vertex'")), "{packed}");
        }
        let nothing = format!("element vertex {count}\nelement point 1\n{XYZ}");
        assert!(
            folder
                .complaint("a.ply", [file("ascii", &nothing, &[]), b"1 2 3".to_vec()].concat())
                .contains("no columns x, y and z")
        );
        let list = format!("element vertex 1\n{XYZ}element face {count}\nproperty list uint double vertex_indices\n");
        assert!(
            folder
                .complaint("a.ply.gz", gzip(&file("binary_big_endian", &list, &[])))
                .contains("ends after 0 of 1 row")
        );
    }
    let mut long = file(
        "binary_little_endian",
        "element face 1\nproperty list uint double vertex_indices\nelement vertex 1\n",
        &[],
    );
    long.splice(long.len() - 11..long.len() - 11, XYZ.bytes());
    long.extend([255; 1000]);
    assert!(folder.complaint("a.ply", &long).contains("the file ends after 0 of 1 row of 'face'"));
    let after = peak_memory();
    // Other tests of this process take some too.
    assert!(after - before < 200 << 20, "{} MiB", (after - before) >> 20);
}

/// One sound file of each kind.
fn samples() -> [(&'static str, Vec<u8>); 6] {
    let f = "float";
    let row = [(1.0, f), (2.0, f), (3.0, f), (4.0, "uchar")];
    let header = format!("element vertex 2\n{XYZ}property uchar kind\n");
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS pp pp pp\n0 1\n0 1\n0 1\nITEM: ATOMS id xs ys zs\n\
                1 0 0 0.5\n";
    let faces = "element face 1\nproperty list uchar uchar vertex_index\n";
    [
        ("a.ply", file("ascii", &header, &[&row, &row])),
        ("b.ply", file("binary_little_endian", &header, &[&row, &row])),
        ("c.ply", [file("ascii", &(header.clone() + faces), &[&row, &row]), b"3 0 1 0\n".to_vec()].concat()),
        ("a.csv", b"x,y,z,kind\n1,2,3,4\n".to_vec()),
        ("a.xyz", b"1\nLattice=\"1 0 0 0 1 0 0 0 1\" Properties=species:S:1:pos:R:3\nO 1 2 3\n".to_vec()),
        ("a.dump", dump.into()),
    ]
}

/// Loads anything: particles or a mesh that hold together, or one line.
fn check(folder: &Folder, name: &str, bytes: impl AsRef<[u8]>) {
    match load(&folder.write(name, bytes)) {
        Ok(loaded) if loaded.scene.geometry.is_empty() => {
            only_particles(&loaded);
        }
        Ok(loaded) => assert_eq!(loaded.scene.geometry.len(), 1),
        Err(error) => assert!(!error.to_string().contains('\n')),
    }
}

#[test]
fn cut_anywhere_a_file_is_refused_or_shorter() {
    let folder = Folder::new("cut");
    for (name, file) in samples() {
        folder.load(name, &file).unwrap();
        for length in 0..file.len() {
            check(&folder, name, &file[..length]);
        }
        let packed = gzip(&file);
        for length in 0..packed.len() {
            folder.complaint(&format!("{name}.gz"), &packed[..length]);
        }
    }
}

#[test]
fn any_byte_may_be_any_other() {
    let folder = Folder::new("bytes");
    for (name, file) in samples() {
        for at in 0..file.len() {
            for byte in [0, 9, 10, b' ', b'-', b'0', b'9', b'"', b',', b'=', b':', 0x7f, 0xff] {
                let mut file = file.clone();
                file[at] = byte;
                check(&folder, name, file);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(512) })]

    #[test]
    fn any_bytes_are_particles_or_refused(which in 0..6_usize, at in 0..400_usize, bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let folder = Folder::new("any");
        let (name, file) = &samples()[which];
        check(&folder, name, [&file[..at.min(file.len())], &bytes].concat());
        check(&folder, "unnamed", [&file[..at.min(file.len())], &bytes].concat());
    }

    #[test]
    fn any_words_are_particles_or_refused(which in 0..6_usize, at in 0..400_usize, text in "[-0-9eE.,;#\" \t\nnaxyzO:=]{0,120}") {
        let folder = Folder::new("words");
        let (name, file) = &samples()[which];
        check(&folder, name, [&file[..at.min(file.len())], text.as_bytes()].concat());
    }
}
