//! STL, as text and binary: what is loaded, and what is said about the rest.

use std::fs;

use mobula::geometry::Mesh;
use mobula::load::{Options, Place, load, load_with};
use proptest::prelude::*;

use super::{Folder, corners, gzip, mesh};

type Triangle = [[f32; 3]; 3];

const TWO: [Triangle; 2] =
    [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.5]], [[1.0, 0.0, 0.0], [1.0, 1.0, 0.25], [0.0, 1.0, 0.5]]];

fn text(triangles: &[Triangle]) -> String {
    let facet = |corners: &Triangle| {
        let vertices: String = corners.iter().map(|[x, y, z]| format!("      vertex {x} {y:e} {z}\n")).collect();
        format!("  facet normal 0 0 1\n    outer loop\n{vertices}    endloop\n  endfacet\n")
    };
    format!("solid part\n{}endsolid part\n", triangles.iter().map(facet).collect::<String>())
}

/// A file with a header, padded with blanks, and an attribute for each triangle.
fn binary(header: &str, triangles: &[(Triangle, u16)]) -> Vec<u8> {
    let mut bytes = format!("{header:<80}").into_bytes();
    bytes.extend((triangles.len() as u32).to_le_bytes());
    for (corners, attribute) in triangles {
        bytes.extend([0.0, 0.0, 1.0].iter().chain(corners.as_flattened()).flat_map(|x: &f32| x.to_le_bytes()));
        bytes.extend(attribute.to_le_bytes());
    }
    bytes
}

fn plain(header: &str, triangles: &[Triangle]) -> Vec<u8> {
    binary(header, &triangles.iter().map(|&corners| (corners, 0)).collect::<Vec<_>>())
}

#[test]
fn text_and_binary_are_one_mesh() {
    let folder = Folder::new("stl");
    let shouted = text(&TWO).replace("\n ", "\r\n\t").to_ascii_uppercase();
    let in_one_line = text(&TWO).replace('\n', " ").replace("solid part", "solid\n").replace("endsolid", "\nendsolid");
    let files = [
        text(&TWO).into_bytes(),
        shouted.into_bytes(),
        in_one_line.into_bytes(),
        plain("made by a test", &TWO),
        plain("solid made by a test", &TWO),
        plain("", &TWO),
    ];
    for file in files {
        // By its name and by its content, plain and packed.
        for (name, bytes, format) in [
            ("a.stl", file.clone(), "STL"),
            ("a.STL.gz", gzip(&file), "STL, gzip"),
            ("a", file.clone(), "STL"),
            ("b", gzip(&file), "STL, gzip"),
        ] {
            let loaded = folder.load(name, bytes).unwrap_or_else(|error| panic!("{error}: {file:?}"));
            assert_eq!((loaded.report.format, &loaded.report.warnings[..]), (format, &[][..] as &[String]));
            assert_eq!(corners(&loaded), TWO);
            assert_eq!(mesh(&loaded).triangles, [[0, 1, 2], [1, 3, 2]], "corners are shared");
            assert_eq!(["vertices", "faces", "triangles"].map(|key| loaded.report.census.count(key)), [4, 2, 2]);
            assert!(mesh(&loaded).colors.is_empty());
        }
    }
}

#[test]
fn solids_are_groups() {
    let folder = Folder::new("stl-solids");
    let [first, second] = TWO.map(|triangle| text(&[triangle]));
    let file = format!("{first}solid nothing\nendsolid\n\n{}", second.replace("solid part", "solid  the other "));
    let loaded = folder.load("a.stl", file).unwrap();
    let groups: Vec<_> = mesh(&loaded).groups.iter().map(|group| (&*group.name, group.first, group.count)).collect();
    assert_eq!(groups, [("part", 0, 1), ("the other", 1, 1)]);
    assert_eq!(loaded.report.warnings, [""; 0]);
}

#[test]
fn triangles_have_colours() {
    let folder = Folder::new("stl-colours");
    let colors = |header: &str, attributes: [u16; 2]| {
        let [a, b] = TWO;
        let loaded = folder.load("a.stl", binary(header, &[(a, attributes[0]), (b, attributes[1])])).unwrap();
        let Mesh { colors, triangles, positions, .. } = mesh(&loaded);
        assert!(colors.is_empty() || colors.len() == positions.len());
        let of = |corner: u32| colors.get(corner as usize).copied().unwrap_or([9.0; 3]);
        (triangles.iter().map(|corners| corners.map(of)).collect::<Vec<_>>(), positions.len())
    };
    let [red, blue, white] = [[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0; 3]].map(|color| [color; 3]);
    // VisCAM, SolidView: the highest bit says that there is a colour.
    assert_eq!(colors("", [0x8000 | 31 << 10, 0x8000 | 31]), (vec![red, blue], 6));
    assert_eq!(colors("", [0x8000 | 31 << 10, 31]), (vec![red, white], 6));
    assert_eq!(colors("", [31, 0]).0, [[[9.0; 3]; 3]; 2], "there are none");
    // Magics: it says that there is none, and the order is the other.
    let header = "COLOR=\0\0\x7f\0,MATERIAL=";
    assert_eq!(colors("COLOR=\0\0\0\0", [31, 31 << 10]), (vec![red, blue], 6));
    let (all, _) = colors(header, [0x8000 | 31 << 10, 0]);
    assert_eq!((all[0], all[0][0][..2].to_vec()), (all[1], vec![0.0; 2]));
    assert!((all[0][0][2] - 0.212).abs() < 0.001, "{all:?}");
}

#[test]
fn zeros_of_either_sign_are_equal() {
    let folder = Folder::new("stl-zeros");
    let mut two = TWO;
    two[1][0] = [1.0, -0.0, -0.0];
    for file in [text(&two).replace("vertex 1 -0e0 -0", "vertex 1 -0 -0.0").into_bytes(), plain("", &two)] {
        assert_eq!(mesh(&folder.load("a.stl", file).unwrap()).triangles, [[0, 1, 2], [1, 3, 2]]);
    }
}

#[test]
fn broken_text_is_named_by_its_line() {
    let folder = Folder::new("stl-text");
    let good = text(&TWO[..1]);
    let (start, loop_) = ("solid a\nfacet normal 0 0 1\n", "outer loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n");
    for (file, expected) in [
        ("solid a\nendsolid a\n".to_owned(), ": there is no triangle in it; "),
        (format!("{good}solid b\nfaset"), ":11: 'faset' where facet or endsolid is expected; "),
        ("solid a\nfacet 0 0 1\n".to_owned(), ":2: a facet without a normal; "),
        (format!("{start}outer loop\nvertex 0 0\n"), ":4: a vertex with 2 of 3 coordinates; "),
        (format!("{start}outer loop\nvertex 0 zero 0\n"), ":4: coordinate 'zero' is not a number; "),
        (format!("{start}{loop_}vertex 1 1 1\n"), ":7: a facet of more than 3 vertices; export it as triangles"),
        (format!("{start}outer loop\nendloop\nendfacet\n"), ":5: a facet of 0 instead of 3 vertices; "),
        (format!("{start}{loop_}facet"), ":7: 'facet' where vertex or endfacet is expected; "),
        (format!("{start}{loop_}"), ":6: the file ends within a facet; the file is truncated"),
        (format!("{start}\0\x01"), ": neither text that starts with `solid`, nor the 84 bytes"),
        (format!("{start}{}\0\x01", " ".repeat(600)), ":3: binary data in a text file; "),
        ("facet normal 0 0 1".to_owned(), ": neither text that starts with `solid`, nor the 84 bytes"),
        ("v 0 0 0\n".repeat(20), ": neither text that starts with `solid`, nor the 84 bytes"),
        (String::new(), ": the file is empty; "),
    ] {
        let complaint = folder.complaint("a.stl", &file);
        assert!(complaint.starts_with(&format!("a.stl{expected}")), "{file:?}: {complaint}");
    }
    for (file, expected) in [
        (good.replace("endsolid part\n", ""), "the last solid has no end: the file may be truncated"),
        (format!("{good}\n\nmore"), "what is behind the last solid, from line 12 on, is left out"),
    ] {
        assert_eq!(folder.warning("a.stl", &file), format!("a.stl: {expected}"));
    }
    // Padding is none, nor is a normal that is no number.
    let odd = good.replace("normal 0 0 1", "normal -nan(ind) x 1.#IND") + "\0\0\0";
    assert_eq!(folder.load("a.stl", odd).unwrap().report.warnings, [""; 0]);
}

#[test]
fn counts_of_binary_files_are_not_trusted() {
    let folder = Folder::new("stl-counts");
    for header in ["solid", "a header"] {
        let good = plain(header, &TWO);
        for count in [3, 1_000_000, u32::MAX] {
            let mut file = good.clone();
            file[80..84].copy_from_slice(&count.to_le_bytes());
            let needed = 84 + 50 * u64::from(count);
            let expected = format!("a.stl: {count} triangles need {needed} bytes, but there are only 184; ");
            assert!(folder.complaint("a.stl", &file).starts_with(&expected));
            let packed = folder.complaint("a.stl.gz", gzip(&file));
            assert!(packed.starts_with(&format!("a.stl.gz: the file ends after 2 of {count} triangles; ")), "{packed}");
        }
        let mut file = good.clone();
        file[80] = 1;
        assert_eq!(folder.warning("a.stl", &file), "a.stl: what is behind the last triangle is left out");
        file[80] = 0;
        assert!(folder.complaint("a.stl", &file).contains("there is no triangle in it"));
        for length in 0..good.len() {
            folder.complaint("a.stl", &good[..length]);
            folder.complaint("a.stl.gz", gzip(&good[..length]));
        }
    }
}

#[test]
fn triangles_that_are_not_finite_are_counted() {
    let folder = Folder::new("stl-nan");
    let [good, mut odd] = TWO;
    odd[1][2] = f32::NAN;
    for file in [text(&[good, odd, [good[0]; 3]]).into_bytes(), plain("", &[good, odd, [good[0]; 3]])] {
        let loaded = folder.load("a.stl", file).unwrap();
        let keys = ["triangles", "non_finite_triangles", "degenerate_triangles"];
        assert_eq!(keys.map(|key| loaded.report.census.count(key)), [3, 1, 1]);
        assert_eq!(loaded.report.bounds(), Some([[0.0; 3], [1.0, 1.0, 0.5]]));
    }
}

#[test]
fn what_is_far_away_is_moved() {
    let folder = Folder::new("stl-far");
    let far = text(&TWO).replace("vertex ", "vertex 45871");
    let loaded = folder.load("a.stl", far).unwrap();
    assert!(loaded.report.warnings[0].contains("far from the origin: it is moved by -45871"), "{:?}", loaded.report);
    assert!(mesh(&loaded).positions.as_flattened().iter().all(|x| x.abs() < 100.0));
}

/// Loads anything: a mesh that holds together, or one line.
fn check(folder: &Folder, bytes: &[u8]) {
    let file = folder.write("a.stl", bytes);
    match load(&file) {
        Ok(loaded) => {
            let found = mesh(&loaded);
            assert!(!found.triangles.is_empty() && found.triangles.len() <= bytes.len() / 16);
            assert!((0..found.triangles.len()).all(|i| found.corners(i).is_some()));
            let groups: u32 = found.groups.iter().map(|group| group.count).sum();
            assert!(groups == 0 || groups as usize == found.triangles.len());
        }
        Err(error) => assert!(!error.to_string().contains('\n') && error.file == file),
    }
    fs::remove_file(file).unwrap();
}

#[test]
fn any_byte_may_be_any_other() {
    let folder = Folder::new("stl-bytes");
    for good in [text(&TWO).into_bytes(), plain("solid", &TWO)] {
        for at in 0..good.len() {
            for byte in [0, 9, 10, b' ', b'-', b'0', b'e', b's', 0x7f, 0xff] {
                let mut file = good.clone();
                file[at] = byte;
                check(&folder, &file);
            }
            check(&folder, &good[..at]);
        }
    }
}

fn any_triangles() -> impl Strategy<Value = Vec<Triangle>> {
    // Few numbers, so that corners are shared, and some that are hard to write.
    let number = prop_oneof![(-2..3).prop_map(|x| x as f32), -1.0_f32..1.0, Just(1.1754944e-20), Just(-1234567.9)];
    prop::collection::vec(prop::array::uniform3(prop::array::uniform3(number)), 1..30)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(256) })]

    #[test]
    fn what_is_written_is_read(triangles in any_triangles(), solid in any::<bool>()) {
        let folder = Folder::new("stl-round");
        let zeros = |triangles: &[Triangle]| triangles.iter().map(|t| t.map(|c| c.map(|x| x + 0.0))).collect::<Vec<_>>();
        let header = if solid { "solid" } else { "any" };
        for file in [text(&triangles).into_bytes(), plain(header, &triangles)] {
            // Where it is, however small.
            let options = Options { place: Some(Place::default()), ..Options::default() };
            let loaded = load_with(&folder.write("a.stl", file), &options).unwrap();
            let found = mesh(&loaded);
            prop_assert_eq!(zeros(&corners(&loaded)), zeros(&triangles));
            // Equal corners are one.
            let mut all = found.positions.iter().map(|p| p.map(|x| (x + 0.0).to_bits())).collect::<Vec<_>>();
            all.sort_unstable();
            prop_assert!(all.windows(2).all(|pair| pair[0] != pair[1]));
        }
    }

    #[test]
    fn any_bytes_are_a_mesh_or_refused(
        start in 0..200_usize, bytes in prop::collection::vec(any::<u8>(), 0..300), binary in any::<bool>(),
    ) {
        let folder = Folder::new("stl-any");
        let good = if binary { plain("x", &TWO) } else { text(&TWO).into_bytes() };
        check(&folder, &[&good[..start.min(good.len())], &bytes].concat());
    }

    #[test]
    fn any_words_are_a_mesh_or_refused(words in prop::collection::vec(
        prop_oneof![
            Just("facet normal 0 0 1 outer loop"), Just("vertex 1 2 3"), Just("endloop endfacet"), Just("endsolid\n"),
            Just("solid a\n"), Just("facet"), Just("normal"), Just("nan"), Just("-1e999"), Just("vertex"), Just("\n"),
        ],
        0..60,
    )) {
        check(&Folder::new("stl-words"), format!("solid\n{}", words.join(" ")).as_bytes());
    }
}
