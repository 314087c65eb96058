//! OBJ, STL and glTF files, good and broken: what is loaded, and what is said about the rest.

#[path = "support/files.rs"]
mod files;
#[path = "load_obj/gltf.rs"]
mod gltf;
#[path = "load_obj/odd.rs"]
mod odd;
#[path = "load_obj/packed.rs"]
mod packed;
#[path = "load_obj/smooth.rs"]
mod smooth;
#[path = "load_obj/steps.rs"]
mod steps;
#[path = "load_obj/stl.rs"]
mod stl;
#[path = "load_obj/textures.rs"]
mod textures;

use std::fs;
use std::io::Write as _;
use std::path::Path;

use mobula::geometry::{Mesh, NO_INDEX};
use mobula::load::{LoadError, Loaded, load};
use mobula::material::{Lambertian, Phong};

use files::{Folder, gzip};

impl Folder {
    fn obj(&self, bytes: impl AsRef<[u8]>) -> Result<Loaded, LoadError> {
        self.load("test.obj", bytes)
    }

    /// The error of a broken file, without its path.
    fn refusal(&self, bytes: impl AsRef<[u8]>) -> String {
        self.complaint("test.obj", bytes).strip_prefix("test.obj").expect("no path").to_owned()
    }
}

fn mesh(loaded: &Loaded) -> &Mesh {
    let [geometry] = &loaded.scene.geometry[..] else { panic!("{:?}", loaded.scene.geometry) };
    geometry.downcast_ref().expect("a mesh")
}

const TWO_PARTS: &str = "\
# two parts
mtllib test.mtl
v 0 0 0
v 1 0 0 # a comment
v 1 1 0 0.5 0.5 0.5
v 0 1 0 1
v 0.5 0.5 1
vt 0 0
vt 1
vn 0 0 1
vn 1 0 0
g base
usemtl red
f 1/1/1 2/2/1 3/1/1 4/2/2
g top point
usemtl glass
f -5 -4 -1
f 2//1 3//1 5//1
usemtl red
f 3 4 5
l 1 2
";

fn corners(loaded: &Loaded) -> Vec<[[f32; 3]; 3]> {
    let mesh = mesh(loaded);
    (0..mesh.triangles.len()).map(|i| mesh.corners(i).unwrap().map(|p| p.to_array())).collect()
}

const TRIANGLE: [[f32; 3]; 3] = [[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];

const MATERIALS: &str = "newmtl red\nKd 1 0 0\n\nnewmtl glass\nKd .1 .1 .1\nKs 1 1 1\nTr .75\nillum 4\nmap_Kd x.png\n";

#[test]
fn groups_materials_normals_and_polygons() {
    let folder = Folder::new("good");
    folder.write("test.mtl", MATERIALS);
    let loaded = folder.obj(TWO_PARTS).unwrap();
    let mesh = mesh(&loaded);
    assert_eq!(mesh.triangles.len(), 5);
    assert_eq!(mesh.materials, [0, 0, 1, 1, 0]);
    let names: Vec<_> = mesh.groups.iter().map(|g| (g.name.as_str(), g.first, g.count)).collect();
    assert_eq!(names, [("base", 0, 2), ("top point", 2, 3)]);
    let corners = |i| mesh.corners(i).unwrap().map(|p| p.to_array());
    assert_eq!(corners(0), [[0., 0., 0.], [1., 0., 0.], [1., 1., 0.]]);
    assert_eq!(corners(1), [[0., 0., 0.], [1., 1., 0.], [0., 1., 0.]]);
    assert_eq!(corners(2), [[0., 0., 0.], [1., 0., 0.], [0.5, 0.5, 1.]]);
    let normals = |i: usize| mesh.triangle_normals[i].map(|n| mesh.normals[n as usize]);
    assert_eq!(normals(1), [[0., 0., 1.], [0., 0., 1.], [1., 0., 0.]]);
    assert_eq!(mesh.triangle_normals[2], [NO_INDEX; 3]);
    assert_eq!(normals(3), [[0., 0., 1.]; 3]);
    assert_eq!(mesh.triangle_normals[4], [NO_INDEX; 3]);
    let texture = |i: usize| mesh.triangle_texture_coordinates[i].map(|n| mesh.texture_coordinates[n as usize]);
    assert_eq!(texture(0), [[0., 0.], [1., 0.], [0., 0.]]);
    assert_eq!(mesh.triangle_texture_coordinates[3], [NO_INDEX; 3]);
    let [red, glass] = &loaded.scene.materials[..] else { panic!("{:?}", loaded.scene.materials) };
    assert_eq!(red.name, "red");
    assert_eq!(red.material.downcast_ref::<Lambertian>().unwrap().diffuse.to_array(), [1., 0., 0.]);
    assert_eq!(glass.material.downcast_ref::<Phong>().unwrap().transparency, 0.75);
    let report = &loaded.report;
    assert_eq!(["vertices", "faces", "triangles", "groups"].map(|key| report.census.count(key)), [5, 4, 5, 2]);
    assert_eq!(report.bounds(), Some([[0., 0., 0.], [1., 1., 1.]]));
    assert_eq!(report.warnings.len(), 2, "{:?}", report.warnings);
}

#[test]
fn a_missing_mtl_is_a_warning() {
    let folder = Folder::new("missing-mtl");
    let loaded = folder.obj(TWO_PARTS).unwrap();
    assert_eq!(loaded.report.warnings.len(), 2, "{:?}", loaded.report.warnings);
    assert!(loaded.report.warnings[0].contains("'test.mtl' is not there"));
}

#[test]
fn what_an_mtl_says_that_means_nothing_is_left_out_and_named() {
    let folder = Folder::new("broken-mtl");
    for (text, expected) in [
        ("newmtl red\n\nKd 1 x 0\n", ":3: Kd 'x' is not a finite number; the line is left out"),
        ("newmtl red\nKd\nKs\nNs\n", ":2: Kd without a number; the line is left out, and 2 others"),
        ("newmtl\nKd 9 9 9\nnewmtl red\n", ":1: newmtl without a name; the line is left out"),
        ("newmtl a\nNs nan\n", ":2: Ns 'nan' is not a finite number; the line is left out"),
        ("newmtl a\nd -nan(ind)\n", ":2: d '-nan(ind)' is not a finite number; the line is left out"),
    ] {
        let mtl = folder.write("test.mtl", text);
        let warnings = folder.obj(TWO_PARTS).unwrap().report.warnings;
        assert!(warnings.contains(&format!("{}{expected}", mtl.display())), "{warnings:?}");
    }
    let mtl = folder.write("test.mtl", "newmtl a\n\0\0x\0\0");
    let warnings = folder.obj(TWO_PARTS).unwrap().report.warnings;
    assert!(warnings[0].starts_with(&format!("{}:2: binary data in a text file; ", mtl.display())), "{warnings:?}");
    // One number means grey; unknown statements, texture maps and spectral colours are left out.
    folder.write("test.mtl", "newmtl red\nKd 0.5\nKs spectral a.rfl\nmap_Kd\nbump\nillum 900\nTf 1 1 1\nKE 0 0 0");
    let loaded = folder.obj(TWO_PARTS).unwrap();
    let grey = loaded.scene.materials[0].material.downcast_ref::<Lambertian>();
    assert_eq!(grey.map(|material| material.diffuse.y), Some(0.5));
}

#[test]
fn broken_lines_are_named() {
    let folder = Folder::new("broken");
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, expected) in [
        ("", ":1: the file is empty; "),
        ("# nothing\n", ":1: no face in 1 lines (0 vertices); "),
        ("v 0 0 0\nv 1 zero 0\n", ":2: coordinate 'zero' is not a number; "),
        ("v 0 0\n", ":1: a vertex with 2 of 3 coordinates; "),
        ("vt\n", ":1: a texture coordinate without numbers; "),
        ("vn 1 2\n", ":1: a normal with 2 of 3 components; "),
        ("T+f 1 2 4\n", ":4: vertex index 4 is out of range: 3 are defined; "),
        ("T+f 1 2 3\nf 9 9 9\nf 1 2 3\nf 12 9 9", ":5: vertex index 9 is out of range: 3 are defined; "),
        ("T+f 1 2 9\ng next\nf 1 2 3\n", ":4: vertex index 9 is out of range: 3 are defined; "),
        ("T+f 0 1 2\n", ":4: vertex index 0; indices start at 1; "),
        ("T+f -1 -2 -4\n", ":4: vertex index '-4' is out of range: 3 are defined before it; "),
        ("T+f 1 2 99999999999999999999999\n", ":4: vertex index '99999999999999999999999' is out of range"),
        ("T+vt 0 0\nf 1/9223372036854775807 2 3\n", ":5: texture coordinate index '9223372036854775807' is out of"),
        ("T+vn 0 0 1\nf 1//6148914691236517206 2 3\n", ":5: normal index '6148914691236517206' is out of range"),
        ("T+f 1 2 -9223372036854775808\n", ":4: vertex index '-9223372036854775808' is out of range"),
        ("T+f 1 2 3.0\n", ":4: vertex index '3.0' is not a whole number; "),
        ("T+f 1 2 /3\n", ":4: face corner '/3' has no vertex index; "),
        ("T+f 1/1/1/1 2 3\n", ":4: face corner '1/1/1/1' has more than 3 indices; "),
        ("T+f 1 2 3\n\0\0\n", ":5: binary data in a text file; "),
        ("\x7fELF\x02\x01\n\x03", ":1: not an OBJ file: 2 of its 2 lines say nothing that OBJ knows; "),
        ("T+p 1\n", ":4: no face in 4 lines (3 vertices); "),
    ] {
        let text = text.replace("T+", triangle);
        let complaint = folder.refusal(&text);
        assert!(complaint.starts_with(expected), "{text:?}: {complaint}");
        // Packed, the line is the same.
        let packed = folder.refusal(gzip(text.as_bytes()));
        assert_eq!(packed, complaint);
    }
}

#[test]
fn files_that_are_not_there_or_not_obj() {
    let folder = Folder::new("kinds");
    let complaint = |path: &Path| load(path).unwrap_err().to_string();
    assert!(complaint(&folder.0.join("no.obj")).ends_with("no.obj: no such file; check the path"));
    assert!(complaint(&folder.0).contains("is a directory"));
    let fbx = complaint(&folder.write("a.fbx", "{}\n"));
    assert!(
        fbx.ends_with(
            ": this is in FBX format, which Mobula cannot load; Mobula loads Wavefront OBJ (.obj), PLY (.ply), STL (.stl), glTF (.gltf, \
             .glb), NRRD (.nrrd, .nhdr), NIfTI (.nii), MetaImage (.mha, .mhd), LAMMPS dump (.lammpstrj, .lammpsdump, .dump), XYZ (.xyz, \
             .extxyz), CSV (.csv, .tsv), Mobula scene (.toml), each also with .gz, raw voxels (--raw-dims) and raw particles \
             (--raw-layout)"
        ),
        "{fbx}"
    );
    assert!(complaint(&folder.write("a.abc", "hello\n")).contains("in no format that Mobula knows"));
    assert!(complaint(&folder.write("a.glb.gz", gzip(b"glTF\x02"))).contains("ends in its header"));
    assert!(complaint(&folder.write("e.txt", "")).contains("the file is empty"));
}

#[test]
fn vertices_that_are_not_finite_are_counted() {
    let folder = Folder::new("nan");
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 1e999 0 0\nf 1 2 3\nf 1 2 4\nf 1 2 3 5\nf 1 1 2\n";
    let loaded = folder.obj(text).unwrap();
    let report = &loaded.report;
    let keys = ["triangles", "non_finite_triangles", "degenerate_triangles"];
    assert_eq!(keys.map(|key| report.census.count(key)), [5, 2, 1]);
    assert_eq!(report.bounds(), Some([[0., 0., 0.], [1., 1., 0.]]));
    assert!(report.warnings[0].contains("test.obj:4: 2 vertices that are not finite"), "{:?}", report.warnings);
}

#[test]
fn odd_but_legal_lines() {
    let folder = Folder::new("odd");
    let text = b"\xef\xbb\xbf# BOM\r\ng caf\xe9\r\n\tv 0 0 0\r\nv 1 0 0\r\nv 0 1 \\\r\n0\r\nf  1   2\t3 # triangle\r\ns off\r\n";
    let loaded = folder.obj(text).unwrap();
    assert_eq!(mesh(&loaded).triangles, [[0, 1, 2]]);
    assert_eq!(loaded.report.warnings, [] as [String; 0], "{:?}", loaded.report.warnings);
    // Faces before their vertices are legal.
    let loaded = folder.obj("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    assert_eq!(loaded.report.census.count("triangles"), 1);
}

#[test]
fn repeated_libraries_are_loaded_once() {
    let folder = Folder::new("repeated");
    folder.write("test.mtl", MATERIALS);
    let text = TWO_PARTS.replace("mtllib test.mtl\n", &"mtllib test.mtl\n".repeat(10_000));
    assert_eq!(folder.obj(text).unwrap().scene.materials.len(), 2);
}

#[test]
fn one_file_named_often_is_loaded_once() {
    let folder = Folder::new("often");
    let materials: String = (0..200).map(|i| format!("newmtl m{i}\nKd 1 0 0\n")).collect();
    folder.write("m.mtl", materials);
    let names = ["m.mtl", "./m.mtl", "M.MTL", "\"m.mtl\"", "C:\\models\\m.mtl"];
    let text = format!("mtllib {}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m7\nf 1 2 3\n", names.join(" ").repeat(1000));
    let loaded = folder.obj(text).unwrap();
    assert_eq!(loaded.scene.materials.len(), 200);
    assert_eq!(mesh(&loaded).material, 7);
}

#[test]
fn what_is_said_often_costs_no_more_than_it_takes_to_say() {
    let folder = Folder::new("runs");
    // A long name and many runs of materials in it.
    let mut text = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\ng {}\n", "x".repeat(1 << 20));
    for i in 0..20_000 {
        text.push_str(&format!("usemtl {}\nf 1 2 3\n", i % 2));
    }
    let loaded = folder.obj(text).unwrap();
    assert_eq!(mesh(&loaded).groups.len(), 1);
    assert_eq!(mesh(&loaded).triangles.len(), 20_000);
}

#[test]
fn a_statement_ends_with_its_line() {
    let folder = Folder::new("backslash");
    for text in [
        "# made from C:\\scenes\\\nv 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n",
        "v 9 9 9 # the \\\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 3 4\n",
        "o C:\\\nv 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng a\\\nusemtl b\\\nf 2 3 4\n",
        "v 9 9 \\\n9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 2 \\\r\n3 4\n",
        "v 9 9 9\rv 0 0 0\rv 1 0 0\rv 0 1 0\rf 2 3 4",
    ] {
        assert_eq!(corners(&folder.obj(text).unwrap()), [TRIANGLE], "{text:?}");
    }
}

#[test]
fn what_is_odd_is_left_out_and_said() {
    let folder = Folder::new("left-out");
    folder.write("m.mtl", "newmtl red\nKd 1 0 0\n");
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    for (text, triangles, warning) in [
        ("V+usemtl\nf 1 2 3\n", 1, ":4: 1 usemtl without a name; grey is used"),
        ("V+v -nan(ind) 0 0\nf 1 2 3\nf 1 2 4\n", 2, ":4: 1 vertex that is not finite"),
        ("V+v 1.#QNAN 1.#INF -1.#IND\nf 1 2 3\nf 1 2 4\n", 2, ":4: 1 vertex that is not finite"),
        ("V+vt nan 0\nf 1/1 2/1 3/1\n", 1, ":4: 1 texture coordinate that is not finite; zero is used"),
        ("V+vn nan 0 0\nf 1//1 2//1 3//1\n", 1, ":4: 1 normal that is not finite is left out"),
        ("v 0 0 0 200\nv 1 0 0 50\nv 0 1 0 100\nf 1 2 3\n", 1, ":1: 3 vertices with a fourth number"),
        ("v 0 0 0 0\nv 1 0 0 0\nv 0 1 0 0\nf 1 2 3\n", 1, ":1: 3 vertices with a fourth number"),
    ] {
        let text = text.replace("V+", vertices);
        let loaded = folder.obj(&text).unwrap();
        assert_eq!(corners(&loaded)[0], TRIANGLE, "{text:?}");
        assert_eq!(loaded.report.census.count("triangles"), triangles, "{text:?}");
        let warnings = &loaded.report.warnings;
        assert!(warnings.len() == 1 && warnings[0].contains(warning), "{text:?}: {warnings:?}");
    }
    // Neither is odd: a weight of one, Fortran's exponents.
    let loaded = folder.obj("v 0 0 0 1\nv 1.0D+00 0 0\nv 0 1 0 1.0\nf 1 2 3\n").unwrap();
    assert_eq!((corners(&loaded), loaded.report.warnings), (vec![TRIANGLE], vec![]));
    // A material may come before its file, and a comment behind its name.
    let loaded = folder.obj(format!("usemtl red # a comment\n{vertices}f 1 2 3\nmtllib m.mtl\n")).unwrap();
    assert_eq!((mesh(&loaded).material, loaded.report.warnings), (0, vec![]));
    // What is defined later may be pointed at from any group.
    for text in ["f 1 2 3\nV+f 3 2 1\n", "g a\nf 1 2 3\ng b\nV+f 3 2 1\n", "usemtl a\nf 1 2 3\nusemtl b\nV+f 3 2 1\n"] {
        let loaded = folder.obj(text.replace("V+", vertices)).unwrap();
        assert_eq!(corners(&loaded), [TRIANGLE, [TRIANGLE[2], TRIANGLE[1], TRIANGLE[0]]], "{text:?}");
    }
}

#[test]
fn vertices_have_colours() {
    let folder = Folder::new("colours");
    let loaded = folder.obj("v 0 0 0\nv 1 0 0 1 0.5 0\nv 0 1 0 0 0 1\nv 1 1 0\nf 1 2 3\nf 2 3 4\n").unwrap();
    assert_eq!(mesh(&loaded).colors, [[1., 1., 1.], [1., 0.5, 0.], [0., 0., 1.], [1., 1., 1.]]);
    let loaded = folder.obj("v 0 0 0 255 0 0\nv 1 0 0 0 51 0\nv 0 1 0 0 0 255\nf 1 2 3\n").unwrap();
    assert_eq!(mesh(&loaded).colors, [[1., 0., 0.], [0., 0.2, 0.], [0., 0., 1.]]);
    assert_eq!(loaded.report.warnings, [] as [String; 0]);
    assert!(mesh(&folder.obj(TWO_PARTS).unwrap()).colors.len() == 5);
}

#[test]
fn text_of_16_bits_is_read() {
    let folder = Folder::new("utf16");
    let text = "# \u{1f40d}\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng r\u{e9}\nf 1 2 3\n";
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    for bytes in [[&[0xfe, 0xff], &big[..]].concat(), [&[0xff, 0xfe], &little[..]].concat(), big, little] {
        for bytes in [gzip(&bytes), bytes] {
            let loaded = folder.obj(&bytes).unwrap();
            assert_eq!((corners(&loaded), mesh(&loaded).groups[0].name.as_str()), (vec![TRIANGLE], "r\u{e9}"));
        }
    }
    // More than is turned at once, with a pair across the seam.
    let long = format!("# {}\n{text}", "\u{1f40d}".repeat(20_000));
    let bytes: Vec<u8> = long.encode_utf16().flat_map(u16::to_le_bytes).collect();
    assert_eq!(corners(&folder.obj(bytes).unwrap()), [TRIANGLE]);
}

#[test]
fn paths_of_other_machines_are_understood() {
    let folder = Folder::new("paths");
    fs::create_dir_all(folder.0.join("sub")).unwrap();
    folder.write("sub/in sub.mtl", "newmtl red\nKd 1 0 0\n");
    folder.write("Beside.mtl", "newmtl red\nKd 0 1 0\n");
    let outside = Folder::new("paths-outside");
    outside.write("secret.mtl", "newmtl red\nKd 0 0 1\n");
    let up = format!("../{}/secret.mtl", outside.0.file_name().unwrap().display());
    let absolute = outside.0.join("secret.mtl").display().to_string();
    for (name, expected) in [
        ("sub/in sub.mtl", Some([1., 0., 0.])),
        ("sub\\in sub.mtl", Some([1., 0., 0.])),
        ("\"sub/in sub.mtl\"", Some([1., 0., 0.])),
        ("./Beside.mtl", Some([0., 1., 0.])),
        ("C:\\Users\\x\\Beside.mtl", Some([0., 1., 0.])),
        ("/home/x/BESIDE.MTL", Some([0., 1., 0.])),
        ("beside.mtl", Some([0., 1., 0.])),
        (up.as_str(), None),
        (absolute.as_str(), None),
        ("/dev/stdin", None),
    ] {
        let loaded = folder.obj(format!("mtllib {name}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl red\nf 1 2 3\n")).unwrap();
        let material = loaded.scene.materials.first().and_then(|named| named.material.downcast_ref::<Lambertian>());
        assert_eq!(material.map(|material| material.diffuse.to_array()), expected, "{name}");
    }
}

#[test]
fn a_polygon_of_any_size_is_cut_right() {
    let folder = Folder::new("polygon");
    let teeth = 1000;
    let mut text = String::new();
    for i in 0..teeth {
        text.push_str(&format!("v {i} 0 3\nv {i}.5 9 3\n"));
    }
    text.push_str(&format!("v {teeth} -1 3\nv 0 -1 3\nf"));
    (1..=2 * teeth + 2).for_each(|i| text.push_str(&format!(" {i}")));
    let area = |[a, b, c]: [[f32; 3]; 3]| ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])) / 2.0;
    let areas: Vec<f32> = corners(&folder.obj(text).unwrap()).into_iter().map(area).collect();
    assert_eq!(areas.len(), 2 * teeth);
    assert!(areas.iter().all(|&area| area <= 0.0), "all go round the same way");
    // The teeth, half of what lies between two of them, and what is below.
    let expected = 9.0 * (teeth as f32 - 0.5) / 2.0 + 9.0 / 4.0 + teeth as f32;
    assert!((areas.iter().sum::<f32>() + expected).abs() < 10.0, "{} {expected}", areas.iter().sum::<f32>());
}

#[test]
fn models_that_do_not_fit_the_numbers_are_put_where_they_do() {
    let folder = Folder::new("place");
    let text = |size: f64, at: f64| {
        let corner = |x: f64, y: f64| format!("v {:e} {:e} 7\n", at + size * x, 10.0 * at + size * y);
        let corners: String = (0..6).map(|i| corner(f64::from(i % 3), f64::from(i / 3))).collect();
        format!("{corners}f 1 2 5 4\nf 2 3 6 5\n")
    };
    let loaded = folder.obj(text(0.125, 458_712.0)).unwrap();
    assert!(
        loaded.report.warnings[0].contains("far from the origin: it is moved by -4"),
        "{:?}",
        loaded.report.warnings
    );
    let [low, high] = loaded.report.bounds().unwrap();
    assert_eq!([high[0] - low[0], high[1] - low[1]], [0.25, 0.125]);
    assert!(low.iter().chain(&high).all(|x| x.abs() < 100.0), "{low:?} {high:?}");
    // Shown together they keep their places.
    let other = {
        let options = mobula::load::Options { place: Some(loaded.place), ..Default::default() };
        mobula::load::load_with(&folder.write("other.obj", text(0.125, 458_713.0)), &options).unwrap()
    };
    assert_eq!(other.report.bounds().unwrap()[0][0], low[0] + 1.0);
    for size in [1e-30, 1e38, 1e200] {
        let loaded = folder.obj(text(size, 0.0)).unwrap();
        let [_, high] = loaded.report.bounds().unwrap();
        assert!((0.5..4.0).contains(&high[0]), "{size:e}: {high:?}");
        assert!(loaded.report.warnings[0].contains("it is scaled by"), "{:?}", loaded.report.warnings);
    }
}

#[test]
#[cfg(unix)]
fn pipes_are_read() {
    let folder = Folder::new("pipe");
    let path = folder.0.join("a pipe");
    assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
    for bytes in [TWO_PARTS.as_bytes().to_vec(), gzip(TWO_PARTS.as_bytes())] {
        let writer = std::thread::spawn({
            let path = path.clone();
            move || {
                let mut pipe = fs::OpenOptions::new().write(true).open(path).unwrap();
                // In two pieces, the first shorter than what is looked at.
                let (first, rest) = bytes.split_at(30);
                pipe.write_all(first).unwrap();
                std::thread::sleep(std::time::Duration::from_millis(50));
                pipe.write_all(rest).unwrap();
            }
        });
        assert_eq!(load(&path).unwrap().report.census.count("triangles"), 5);
        writer.join().unwrap();
    }
}

#[test]
fn names_from_files_are_shown_without_what_could_change_a_terminal() {
    let folder = Folder::new("escapes");
    let name = "bad\u{1b}[2Jname";
    let text = format!("mtllib {name}.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl {name}\nf 1 2 {name}\n");
    let complaint = folder.refusal(&text);
    assert!(complaint.contains("'bad?[2Jname' is not a whole number"), "{complaint:?}");
    let loaded = folder.obj(text.replace(&format!("f 1 2 {name}"), "f 1 2 3")).unwrap();
    assert!(loaded.report.warnings.iter().all(|text| !text.contains('\u{1b}')), "{:?}", loaded.report.warnings);
}
