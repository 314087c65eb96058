//! What is odd in files, and found where it is odd: warned about, not fatal, and quick.

use std::fs;

use super::{Folder, mesh};

#[test]
fn what_is_odd_is_left_out_and_told() {
    let folder = Folder::new("odd");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let warned = |text: &str, expected: &str| {
        let loaded = folder.obj(text).unwrap();
        assert_eq!(mesh(&loaded).triangles.len(), 1, "{text}");
        assert!(
            loaded.report.warnings.iter().any(|line| line.contains(expected)),
            "{text}: {:?}",
            loaded.report.warnings
        );
    };
    for word in ["1.#R", "1.#QO", "-1.#IO", "1.#J", "1.$", "qnan", "snan", "inf.0"] {
        warned(&format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv {word} 0 0\nf 1 2 3\n"), "vertex that is not finite");
    }
    warned(&format!("{triangle}f\n"), "face without corners");
    warned("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/9\n", "indices are out of range");
    warned("v 0 0 0 1 2\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "5 or more than 7 numbers");
    warned("v 0 0 0 nan 1 1\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "colour that is not finite");
    folder.write("broken.mtl", "newmtl a\nKd 1 0 0\nnewmtl b\n\0x");
    warned(
        &format!("mtllib broken.mtl\nusemtl a\n{triangle}"),
        "binary data in a text file; check that it is what its name says; what",
    );
    for text in
        [format!("{triangle}\0\0\0"), triangle.replace("3\n", "3#corner\n"), triangle.replace(" 2 3", " 2 \\  \n3")]
    {
        let loaded = folder.obj(&text).unwrap();
        assert_eq!((mesh(&loaded).triangles.len(), loaded.report.warnings.len()), (1, 0), "{text:?}");
    }
}

#[test]
fn colours_are_bytes_only_if_all_are_whole() {
    let folder = Folder::new("bytes");
    let color = |numbers: &str| {
        mesh(&folder.obj(format!("v 0 0 0 {numbers}\nv 1 0 0 1 1 1\nv 0 1 0 1 1 1\nf 1 2 3\n")).unwrap()).colors[0]
    };
    assert_eq!(color("255 51 0"), [1.0, 0.2, 0.0]);
    assert_eq!(color("2 1 1"), [1.0; 3], "one value above 1 is one value above 1");
    assert_eq!(color("2.5 3 0.5"), [1.0, 1.0, 0.5]);
}

#[test]
fn many_joined_lines_take_no_longer_than_their_number() {
    let folder = Folder::new("joined");
    let start = std::time::Instant::now();
    let text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 {}3\n", "\\\n".repeat(2_000_000));
    assert_eq!(mesh(&folder.obj(text).unwrap()).triangles.len(), 1);
    assert!(start.elapsed().as_secs() < 10, "{:?}", start.elapsed());
}

#[test]
fn material_files_are_found_whatever_their_letters_and_quotes() {
    let folder = Folder::new("letters");
    fs::create_dir(folder.0.join("Sub")).unwrap();
    folder.write("Sub/Red.mtl", "newmtl r\nKd 1 0 \\\n 0\n");
    folder.write("two words.mtl", "newmtl r\nKd 1 0 0\n");
    for name in ["sub\\RED.MTL", "SUB/Red.mtl", "'two words.mtl'", "Sub/Red.mtl # from elsewhere", "\"Sub/Red.mtl\""] {
        let loaded = folder.obj(format!("mtllib {name}\nusemtl r\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")).unwrap();
        assert_eq!(loaded.scene.materials.len(), 1, "{name}: {:?}", loaded.report.warnings);
    }
    #[cfg(unix)]
    {
        let outside = std::env::temp_dir().join(format!("mobula-outside-{}.mtl", std::process::id()));
        fs::write(&outside, "newmtl r\nKd 1 0 0\n").unwrap();
        std::os::unix::fs::symlink(&outside, folder.0.join("link.mtl")).unwrap();
        let loaded = folder.obj("mtllib link.mtl\nusemtl r\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
        fs::remove_file(outside).unwrap();
        assert!(loaded.report.warnings[0].contains("is no file that may be read"), "{:?}", loaded.report.warnings);
    }
}

#[test]
fn too_many_materials_stop_what_reads_them() {
    let folder = Folder::new("many");
    let materials: String = (0..70_000).map(|i| format!("newmtl {i}\nKd 1 0 0\n")).collect();
    folder.write("many.mtl", materials);
    let loaded = folder.obj("mtllib many.mtl\nusemtl 7\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    assert!((60_000..=65_537).contains(&loaded.scene.materials.len()), "{}", loaded.scene.materials.len());
    assert!(loaded.report.warnings[0].contains("more than 65536 materials"), "{:?}", loaded.report.warnings);
}

#[test]
fn a_file_that_the_place_of_the_first_blurs_is_told() {
    let folder = Folder::new("blurred");
    let far = folder.obj("v 4000000 5000000 0\nv 4000001 5000000 0\nv 4000000 5000001 0\nf 1 2 3\n").unwrap();
    let near = folder.write("near.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let options = mobula::load::Options { place: Some(far.place), ..Default::default() };
    let warnings = mobula::load::load_with(&near, &options).unwrap().report.warnings;
    assert!(warnings.iter().any(|line| line.contains("its details are lost")), "{warnings:?}");
}

#[test]
fn the_smallest_numbers_are_scaled_to_be_seen() {
    let folder = Folder::new("smallest");
    let loaded = folder.obj("v 0 0 0\nv 1e-310 0 0\nv 0 1e-310 0\nf 1 2 3\n").unwrap();
    assert!(!loaded.report.warnings[0].contains("inf"), "{:?}", loaded.report.warnings);
    assert!(mesh(&loaded).positions.iter().flatten().all(|x| x.is_finite()));
}
