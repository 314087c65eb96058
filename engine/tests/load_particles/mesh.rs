//! PLY with faces: a mesh.

use mobula::geometry::Mesh;

use super::Folder;
use super::ply::{ENCODINGS, file};

const HEADER: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\nproperty float nx\nproperty float \
                      ny\nproperty float nz\nproperty uchar red\nproperty uchar green\nproperty uchar blue\nproperty float \
                      s\nproperty float t\nelement face 3\nproperty uchar flags\nproperty list uchar int vertex_indices\n";

#[test]
fn faces_make_a_mesh() {
    let folder = Folder::new("ply-mesh");
    let [f, u, i] = ["float", "uchar", "int"];
    let vertex = |x: f64, y: f64| {
        vec![(x, f), (y, f), (0.0, f), (0.0, f), (0.0, f), (1.0, f), (255.0, u), (0.0, u), (0.0, u), (x, f), (y, f)]
    };
    let face = |corners: &[f64]| {
        [(7.0, u), (corners.len() as f64, u)].into_iter().chain(corners.iter().map(|&corner| (corner, i))).collect()
    };
    let rows: [Vec<(f64, &str)>; 7] = [
        vertex(0.0, 0.0),
        vertex(2.0, 0.0),
        vertex(2.0, 2.0),
        vertex(0.0, 2.0),
        face(&[0.0, 1.0, 2.0, 3.0]),
        face(&[0.0, 1.0]),
        face(&[2.0, 1.0, 0.0]),
    ];
    let slices: Vec<&[_]> = rows.iter().map(|row| &row[..]).collect();
    for encoding in ENCODINGS {
        let loaded = folder.load("a.ply", file(encoding, HEADER, &slices)).unwrap();
        assert!(loaded.report.warnings[0].ends_with("a.ply: 1 face with fewer than three corners left out"));
        let mesh = loaded.scene.geometry[0].downcast_ref::<Mesh>().unwrap();
        assert_eq!(mesh.triangles.len(), 3);
        assert_eq!(mesh.triangles[2], [2, 1, 0]);
        assert_eq!((&mesh.triangle_normals, &mesh.triangle_texture_coordinates), (&mesh.triangles, &mesh.triangles));
        assert_eq!((mesh.colors[3], mesh.texture_coordinates[2]), ([1.0, 0.0, 0.0], [2.0, 2.0]));
        let keys = ["vertices", "normals", "texture_coordinates", "faces", "triangles"];
        assert_eq!(keys.map(|key| loaded.report.census.count(key)), [4, 4, 4, 2, 3]);
        assert_eq!((loaded.report.format, loaded.report.bounds()), ("PLY", Some([[0.0; 3], [2.0, 2.0, 0.0]])));
    }
}

#[test]
fn broken_meshes() {
    let folder = Folder::new("ply-mesh-broken");
    let head = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n";
    let vertices = "0 0 0\n1 0 0\n0 1 0\n";
    let with = |property: &str, faces: &str| format!("{head}{property}\nend_header\n{vertices}{faces}");
    let list = "property list uchar int vertex_index";
    for (text, expected) in [
        (with(list, "3 0 1 3\n"), ":13: there is no vertex 3: there are 3, from 0"),
        (with(list, "3 0 1 -1\n"), ":13: there is no vertex -1"),
        (with(list, "3 0 1\n"), ":13: numbers are missing"),
        (with(list, "-3 0 1 2\n"), ":13: -3 is no length of a list"),
        (with(list, "99999999999 0 1 2\n"), ":13: 99999999999 is no length of a list"),
        (with(list, "3 0 1 2 4\n"), ":13: '4' is behind the last number of the row"),
        (with(list, ""), ":12: the file ends after 0 of 1 row of 'face'"),
        (with("property int vertex_index", "1\n"), ":7: faces have no list vertex_indices"),
        (with(list, "3 0 1 2\n").replace("float z", "float w"), ":3: vertices have no properties x, y and z"),
        (
            "ply\nformat ascii 1.0\nelement tristrips 1\nproperty list int int a\nend_header\n1 1\n".into(),
            ":3: its triangles are in strips",
        ),
    ] {
        let complaint = folder.complaint("a.ply", &text);
        assert!(complaint.starts_with(&format!("a.ply{expected}")), "{text}: {complaint}");
    }
    let binary = with(list, "").replace("ascii", "binary_little_endian");
    let header = &binary[..binary.find("end_header\n").unwrap() + 11];
    let bytes = [header.as_bytes(), &[0; 36], &[3], &[0; 8], &[9, 0, 0, 0]].concat();
    assert!(folder.complaint("a.ply", bytes).starts_with("a.ply: 'face' 0: there is no vertex 9"));
}
