//! Files in gzip, whole and damaged.

use std::io::Write as _;

use mobula::load::load;

use super::{Folder, TWO_PARTS, gzip};

#[test]
fn gzip_is_known_by_content() {
    let folder = Folder::new("gzip");
    let packed = gzip(TWO_PARTS.as_bytes());
    for name in ["a.obj.gz", "a.obj", "a.gz", "a"] {
        let loaded = load(&folder.write(name, &packed)).unwrap();
        assert_eq!(loaded.report.census.count("triangles"), 5);
        assert_eq!(loaded.report.format, "OBJ, gzip");
    }
}

#[test]
fn truncated_and_damaged_gzip() {
    let folder = Folder::new("truncated");
    let mut text = String::new();
    for i in 0..2000 {
        text.push_str(&format!("v {} {} {}\n", i, i * 7 % 13, i * 31 % 101));
    }
    let packed = gzip(text.as_bytes());
    for length in [11, packed.len() / 2, packed.len() - 4] {
        let complaint = folder.refusal(&packed[..length]);
        assert!(complaint.contains(": the gzip data ends too early; "), "{complaint}");
    }
    let mut damaged = packed.clone();
    let middle = damaged.len() / 2;
    damaged[middle..].fill(0xff);
    let complaint = folder.refusal(&damaged);
    assert!(complaint.contains("gzip") || complaint.contains("vertex"), "{complaint}");
}

#[test]
fn a_gzip_bomb_is_refused() {
    let folder = Folder::new("bomb");
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    let block = b"v 0 0 0\n".repeat(1 << 15);
    for _ in 0..200 {
        packer.write_all(&block).unwrap();
    }
    let bomb = packer.finish().unwrap();
    assert!(bomb.len() < 1 << 20);
    let complaint = folder.refusal(&bomb);
    assert!(complaint.contains("out of proportion to its size"), "{complaint}");
}

#[test]
fn what_follows_gzip_data_is_left_out() {
    let folder = Folder::new("trailing");
    let packed = gzip(TWO_PARTS.as_bytes());
    for behind in [&[0; 512][..], b"trailing", &[0x1f]] {
        if behind != [0x1f] {
            let loaded = folder.obj([&packed, behind].concat()).unwrap();
            assert_eq!(loaded.report.census.count("triangles"), 5);
            assert!(loaded.report.warnings.iter().any(|text| text.contains("what follows the gzip data is left out")));
        }
    }
    // Several members are one file.
    let (first, second) = TWO_PARTS.split_at(TWO_PARTS.len() / 2);
    let loaded = folder.obj([gzip(first.as_bytes()), gzip(second.as_bytes())].concat()).unwrap();
    assert_eq!(loaded.report.census.count("triangles"), 5);
}
