//! Meshes whose files have no normals are smoothed, whatever the format; those that have some keep them.

use mobula::geometry::{CREASE_ANGLE, Geometry, Mesh};
use mobula::load::{Loaded, Options, load, load_with};

use super::{Folder, gzip, mesh};

/// A roof of two quads that meet at 20 degrees.
const CORNERS: [[f64; 3]; 6] = [
    [-1.0, 0.0, 0.0],
    [-1.0, 2.0, 0.0],
    [0.0, 0.0, 0.176_327],
    [0.0, 2.0, 0.176_327],
    [1.0, 0.0, 0.0],
    [1.0, 2.0, 0.0],
];
const TRIANGLES: [[usize; 3]; 4] = [[0, 2, 1], [2, 3, 1], [2, 4, 3], [4, 5, 3]];

fn obj(normals: &str, corner: &str) -> String {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n")).collect();
    let face = |corners: &[usize; 3]| {
        let corners: String = corners.iter().map(|i| format!(" {}{corner}", i + 1)).collect();
        format!("f{corners}\n")
    };
    format!("{vertices}{normals}{}", TRIANGLES.iter().map(face).collect::<String>())
}

fn ply() -> String {
    let vertices: String = CORNERS.iter().map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let faces: String = TRIANGLES.iter().map(|[a, b, c]| format!("3 {a} {b} {c}\n")).collect();
    format!(
        "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n\
         property list uchar int vertex_indices\nend_header\n{vertices}{faces}"
    )
}

fn stl() -> String {
    let vertex = |&i: &usize| format!("vertex {} {} {}\n", CORNERS[i][0], CORNERS[i][1], CORNERS[i][2]);
    let facet = |corners: &[usize; 3]| {
        let vertices: String = corners.iter().map(vertex).collect();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    format!("solid\n{}endsolid\n", TRIANGLES.iter().map(facet).collect::<String>())
}

/// Normals of the file, and normals that were made.
fn counts(loaded: &Loaded) -> [u64; 2] {
    ["normals", "made_normals"].map(|key| loaded.report.census.count(key))
}

#[test]
fn meshes_of_all_formats_are_smoothed_in_one_place() {
    let folder = Folder::new("smooth");
    for (name, text) in [("a.obj", obj("", "")), ("a.ply", ply()), ("a.stl", stl())] {
        let file = folder.write(name, &text);
        let packed = folder.load(&format!("{name}.gz"), gzip(text.as_bytes())).unwrap();
        let loaded = load(&file).unwrap();
        assert_eq!((counts(&loaded), counts(&packed)), ([0, 6], [0, 6]), "{name}");
        let found = mesh(&loaded);
        assert_eq!((found.triangle_normals.len(), found.normals.len()), (4, 6));
        // Along the ridge upwards, elsewhere that of the side.
        for (corners, normals) in found.triangles.iter().zip(&found.triangle_normals) {
            for (corner, normal) in corners.map(|i| found.positions[i as usize]).iter().zip(normals) {
                let [x, _, z] = found.normals[*normal as usize];
                assert!(
                    if corner[0] == 0.0 { x.abs() < 1e-6 } else { (x.abs() - 0.173_648).abs() < 1e-5 },
                    "{name}: {x} {z}"
                );
            }
        }
        let with = |smooth: Option<f32>| load_with(&file, &Options { smooth, ..Options::default() }).unwrap();
        assert_eq!(
            [None, Some(CREASE_ANGLE), Some(19.0), Some(0.0)].map(|angle| counts(&with(angle))[1]),
            [6, 6, 0, 0]
        );
        assert!(mesh(&with(Some(0.0))).triangle_normals.is_empty());
    }
}

#[test]
fn normals_of_files_are_kept() {
    let folder = Folder::new("smooth-kept");
    let loaded = folder.load("a.obj", obj("vn 0 0 1\nvn 0 1 0\n", "//1")).unwrap();
    assert_eq!((counts(&loaded), mesh(&loaded).normals.len()), ([2, 0], 2));
    // Also where only some triangles have any; those that no triangle has are none.
    let some = obj("vn 0 0 1\n", "").replace("f 1 3 2", "f 1//1 3//1 2//1");
    assert_eq!(counts(&folder.load("a.obj", some).unwrap()), [1, 0]);
    assert_eq!(counts(&folder.load("a.obj", obj("vn 0 0 1\n", "")).unwrap()), [1, 6]);
}

#[test]
fn scene_files_say_how_smooth_their_parts_are() {
    let folder = Folder::new("smooth-scene");
    folder.write("a.obj", obj("", ""));
    let file = |keys: &str| {
        let text = format!("mobula = 1\n{keys}\n[[object]]\nmesh = \"a.obj\"\n\n[[object]]\nmesh = \"gen:terr20k\"\n");
        folder.write("a.toml", text)
    };
    for (keys, option, made) in [
        ("", None, 6),
        ("smooth = 19", None, 0),
        ("smooth = 0", None, 0),
        ("smooth = 19", Some(30.0), 6),
        ("smooth = 30", Some(0.0), 0),
    ] {
        let loaded = load_with(&file(keys), &Options { smooth: option, ..Options::default() }).unwrap();
        assert_eq!(counts(&loaded)[1], made, "{keys} {option:?}");
        // What is generated is as it was made.
        let made_up = loaded.scene.geometry[1].downcast_ref::<Mesh>().unwrap();
        let generated = mobula::generate::generate("gen:terr20k").unwrap();
        let original: &Mesh = generated.geometry[0].downcast_ref().unwrap();
        assert_eq!(made_up.triangle_normals, original.triangle_normals);
        assert_eq!(made_up.census(), original.census());
    }
    let error = load(&file("smooth = 200")).unwrap_err().to_string();
    assert!(error.contains("a.toml:2:10: invalid value: integer `200`, expected an angle from 0 to 180"), "{error}");
}
