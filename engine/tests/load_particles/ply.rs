//! PLY with particles: encodings, types, columns, other elements.

use super::{Folder, gzip, kinds, only_particles, steps, values};

/// The types of PLY by their two names, with their bytes.
const TYPES: [(&str, &str, usize); 8] = [
    ("char", "int8", 1),
    ("uchar", "uint8", 1),
    ("short", "int16", 2),
    ("ushort", "uint16", 2),
    ("int", "int32", 4),
    ("uint", "uint32", 4),
    ("float", "float32", 4),
    ("double", "float64", 8),
];

fn bytes_of(number: f64, kind: &str, big: bool) -> Vec<u8> {
    let mut bytes = match kind {
        "char" => (number as i8).to_le_bytes().to_vec(),
        "uchar" => (number as u8).to_le_bytes().to_vec(),
        "short" => (number as i16).to_le_bytes().to_vec(),
        "ushort" => (number as u16).to_le_bytes().to_vec(),
        "int" => (number as i32).to_le_bytes().to_vec(),
        "uint" => (number as u32).to_le_bytes().to_vec(),
        "float" => (number as f32).to_le_bytes().to_vec(),
        _ => number.to_le_bytes().to_vec(),
    };
    if big {
        bytes.reverse();
    }
    bytes
}

/// A file in one of three encodings.
pub(crate) fn file(encoding: &str, header: &str, rows: &[&[(f64, &str)]]) -> Vec<u8> {
    let mut file = format!("ply\nformat {encoding} 1.0\n{header}end_header\n").into_bytes();
    for row in rows {
        if encoding == "ascii" {
            let words: Vec<String> = row.iter().map(|(number, _)| number.to_string()).collect();
            file.extend(words.join(" ").bytes().chain([b'\n']));
        } else {
            row.iter().for_each(|(number, kind)| file.extend(bytes_of(*number, kind, encoding.contains("big"))));
        }
    }
    file
}

pub(crate) const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

#[test]
fn every_encoding_and_type() {
    let folder = Folder::new("ply-types");
    for encoding in ENCODINGS {
        for (kind, other, _) in TYPES {
            let header = format!(
                "comment made by hand\nelement vertex 2\nproperty {kind} x\nproperty {other} y\nproperty float z\n\
                 property {kind} value\n"
            );
            let value = if kind.starts_with('u') { 200.0 } else { -100.0 };
            let rows: [&[_]; 2] = [
                &[(1.0, kind), (2.0, kind), (3.5, "float"), (7.0, kind)],
                &[(4.0, kind), (5.0, kind), (-6.5, "float"), (value, kind)],
            ];
            let file = file(encoding, &header, &rows);
            for (name, file) in [("a.ply", file.clone()), ("a.ply.gz", gzip(&file)), ("unnamed", file)] {
                let step = folder.step(name, file);
                assert_eq!(step.centers, [[1.0, 2.0, 3.5], [4.0, 5.0, -6.5]]);
                assert_eq!(values(&step, "value"), [7.0, value as f32]);
                assert_eq!(kinds(&step), [("value", if kind == "uchar" { "u8" } else { "f32" })]);
            }
        }
    }
}

#[test]
fn columns_get_their_meaning_by_name() {
    let folder = Folder::new("ply-columns");
    let header = "comment box 10 20 30 mm\nelement camera 1\nproperty float x\nproperty list uchar int a\nelement nothing 5\n\
                  element vertex 2\nproperty float vx\nproperty float vy\nproperty float vz\nproperty double x\n\
                  property double y\nproperty double z\nproperty float diameter\nproperty char kind\nproperty list uchar \
                  short near\nproperty uchar red\nelement edge 1\nproperty int a\n";
    let [d, f, c, u, s] = ["double", "float", "char", "uchar", "short"];
    let vertex = |at: f64, kind: f64, near: &[f64]| {
        let mut row = vec![(3.0, f), (0.0, f), (4.0, f), (at, d), (at + 1.0, d), (at + 2.0, d), (2.0, f), (kind, c)];
        row.push((near.len() as f64, u));
        row.extend(near.iter().map(|&near| (near, s)));
        row.push((255.0, u));
        row
    };
    let rows = [
        vec![(9.0, f), (2.0, u), (1.0, "int"), (2.0, "int")],
        vertex(1.0, 3.0, &[]),
        vertex(5.0, 4.0, &[1.0, -2.0]),
        vec![(0.0, "int")],
    ];
    let rows: Vec<&[_]> = rows.iter().map(|row| &row[..]).collect();
    for encoding in ENCODINGS {
        let loaded = folder.load("a.ply", file(encoding, header, &rows)).unwrap();
        assert!(loaded.report.warnings[0].ends_with("a.ply:8: lists of vertices are left out"), "{:?}", loaded.report);
        let [step] = &steps(only_particles(&loaded));
        assert_eq!(step.centers, [[1.0, 2.0, 3.0], [5.0, 6.0, 7.0]]);
        assert_eq!(step.radii, [1.0, 1.0]);
        let expected = [
            ("radius", "f32"),
            ("vx", "f32"),
            ("vy", "f32"),
            ("vz", "f32"),
            ("kind", "u8"),
            ("red", "u8"),
            ("speed", "f32"),
        ];
        assert_eq!(kinds(step), expected);
        assert_eq!((values(step, "kind"), values(step, "speed")), (vec![3.0, 4.0], vec![5.0, 5.0]));
        assert_eq!(step.cell.unwrap()[1], [0.0, 20.0, 0.0]);
        assert_eq!(loaded.report.bounds(), Some([[0.0, 1.0, 2.0], [6.0, 7.0, 8.0]]));
    }
}

#[test]
fn what_is_not_finite_is_left_out_and_counted() {
    let folder = Folder::new("ply-finite");
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float \
                radius\nproperty uchar kind\nend_header\n0 0 0 1 1\nnan 0 0 1 2\n0 -inf 0 1 3\n1 2 3 nan 4\n";
    let loaded = folder.load("a.ply", text).unwrap();
    let [step] = &steps(only_particles(&loaded));
    assert_eq!((step.centers.len(), values(step, "kind")), (2, vec![1.0, 4.0]));
    assert_eq!([loaded.report.census.count("particles"), loaded.report.census.left_out()], [4, 2]);
    assert!(
        folder
            .complaint("a.ply", text.replace("0 0 0 1 1", "0 0 nan 1 1").replace("1 2 3 nan 4", "inf 2 3 nan 4"))
            .contains("finite")
    );
}

#[test]
fn far_coordinates_are_moved() {
    let folder = Folder::new("ply-far");
    let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\nproperty double z\nend_header\n\
                458712.25 5428771.5 112\n458722.25 5428781.5 113\n458712 5428781 112\n458722 5428771 113";
    let loaded = folder.load("a.ply", text).unwrap();
    assert!(loaded.report.warnings[0].contains("far from the origin"), "{:?}", loaded.report);
    let [step] = &steps(only_particles(&loaded));
    assert_eq!(loaded.place.back(step.centers[1]), [458_722.25, 5_428_781.5, 113.0]);
}

#[test]
fn what_is_behind_the_rows_is_told() {
    let folder = Folder::new("ply-behind");
    let header = "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
    let row: [&[_]; 1] = [&[(1.0, "float"), (2.0, "float"), (3.0, "float")]];
    for encoding in ENCODINGS {
        let sound = file(encoding, header, &row);
        folder.step("a.ply", [&sound[..], b"\n \n"].concat());
        let more = [&sound[..], b"more\n"].concat();
        assert_eq!(folder.warning("a.ply", more), "a.ply: what is behind the last row is left out");
        // Elements that are not looked at are no mistake.
        let edges = file(encoding, &format!("{header}element edge 1\nproperty int a\n"), &row);
        folder.step("a.ply", [&edges[..], b"more\n"].concat());
    }
}
