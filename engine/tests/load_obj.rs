//! OBJ files, good and broken: what is loaded, and what is said about the rest.

use std::fs;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use mobula::geometry::{Mesh, NO_INDEX};
use mobula::load::{LoadError, Loaded, load};
use mobula::material::{Lambertian, Phong};

/// A folder of its own for each test, removed at its end.
struct Folder(PathBuf);

impl Folder {
    fn new(test: &str) -> Self {
        let path = std::env::temp_dir().join(format!("mobula-load-{test}-{}", std::process::id()));
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    fn write(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.join(name);
        fs::write(&path, bytes).unwrap();
        path
    }

    fn load(&self, bytes: impl AsRef<[u8]>) -> Result<Loaded, LoadError> {
        load(&self.write("test.obj", bytes))
    }

    /// The error of a broken file, without its path.
    fn complaint(&self, bytes: impl AsRef<[u8]>) -> String {
        let text = self.load(bytes).expect_err("loaded").to_string();
        assert!(!text.contains('\n'), "more than a line: {text}");
        text.strip_prefix(&self.0.join("test.obj").display().to_string()).expect("no path").to_owned()
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn mesh(loaded: &Loaded) -> &Mesh {
    let [geometry] = &loaded.scene.geometry[..] else { panic!("{:?}", loaded.scene.geometry) };
    geometry.downcast_ref().expect("a mesh")
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
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

const MATERIALS: &str = "newmtl red\nKd 1 0 0\n\nnewmtl glass\nKd .1 .1 .1\nKs 1 1 1\nTr .75\nillum 4\nmap_Kd x.png\n";

#[test]
fn groups_materials_normals_and_polygons() {
    let folder = Folder::new("good");
    folder.write("test.mtl", MATERIALS);
    let loaded = folder.load(TWO_PARTS).unwrap();
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
fn a_missing_mtl_is_a_warning() {
    let folder = Folder::new("missing-mtl");
    let loaded = folder.load(TWO_PARTS).unwrap();
    assert_eq!(loaded.report.warnings.len(), 2, "{:?}", loaded.report.warnings);
    assert!(loaded.report.warnings[0].contains("'test.mtl' is not there"));
}

#[test]
fn a_broken_mtl_names_its_line() {
    let folder = Folder::new("broken-mtl");
    for (text, expected) in [
        ("newmtl red\n\nKd 1 x 0\n", ":3: Kd 'x' is not a finite number; "),
        ("newmtl red\nKd\n", ":2: Kd without a number; "),
        ("newmtl\n", ":1: newmtl without a name; "),
        ("newmtl a\nNs nan\n", ":2: Ns 'nan' is not a finite number; "),
        ("newmtl a\n\0\0\0\0", ":2: binary data in a text file; "),
    ] {
        let mtl = folder.write("test.mtl", text);
        let error = folder.load(TWO_PARTS).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{}{expected}", mtl.display())), "{error}");
    }
    // One number means grey; unknown statements, texture maps and spectral colours are left out.
    folder.write("test.mtl", "newmtl red\nKd 0.5\nKs spectral a.rfl\nmap_Kd\nbump\nillum 900\nTf 1 1 1\nKE 0 0 0");
    let loaded = folder.load(TWO_PARTS).unwrap();
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
        ("v 0 0 0 0\n", ":1: a vertex of weight 0; "),
        ("vt\n", ":1: a texture coordinate without numbers; "),
        ("vn 1 2\n", ":1: a normal with 2 of 3 components; "),
        ("T+f 1 2 4\n", ":4: vertex index 4 is out of range: 3 are defined; "),
        ("T+f 1 2 3\nf 9 9 9\nf 1 2 3\nf 12 9 9", ":5: vertex index 9 is out of range: 3 are defined; "),
        ("T+f 1 2 9\ng next\nf 1 2 3\n", ":4: vertex index 9 is out of range: 3 are defined; "),
        ("T+f 0 1 2\n", ":4: vertex index 0; indices start at 1; "),
        ("T+f -1 -2 -4\n", ":4: vertex index '-4' is out of range: 3 are defined before it; "),
        ("T+f 1/7 2/7 3/7\n", ":4: texture coordinate index 7 is out of range: 0 are defined; "),
        ("T+vn 0 0 1\nf 1//1 2//1 3//2\n", ":5: normal index 2 is out of range: 1 are defined; "),
        ("T+f 1 2 99999999999999999999999\n", ":4: vertex index '99999999999999999999999' is out of range"),
        ("T+vt 0 0\nf 1/9223372036854775807 2 3\n", ":5: texture coordinate index '9223372036854775807' is out of"),
        ("T+vn 0 0 1\nf 1//6148914691236517206 2 3\n", ":5: normal index '6148914691236517206' is out of range"),
        ("T+f 1 2 -9223372036854775808\n", ":4: vertex index '-9223372036854775808' is out of range"),
        ("T+f 1 2 3.0\n", ":4: vertex index '3.0' is not a whole number; "),
        ("T+f 1 2 /3\n", ":4: face corner '/3' has no vertex index; "),
        ("T+f 1/1/1/1 2 3\n", ":4: face corner '1/1/1/1' has more than 3 indices; "),
        ("T+f\n", ":4: a face without corners; "),
        ("T+usemtl\n", ":4: usemtl without a name; "),
        ("T+f 1 2 3\n\0\0\n", ":5: binary data in a text file; "),
        ("\x7fELF\x02\x01\n\x03", ":1: not an OBJ file: 2 of its 2 lines say nothing that OBJ knows; "),
        ("T+p 1\n", ":4: no face in 4 lines (3 vertices); "),
    ] {
        let text = text.replace("T+", triangle);
        let complaint = folder.complaint(&text);
        assert!(complaint.starts_with(expected), "{text:?}: {complaint}");
        // Packed, the line is the same.
        let packed = folder.complaint(gzip(text.as_bytes()));
        assert_eq!(packed, complaint);
    }
}

#[test]
fn files_that_are_not_there_or_not_obj() {
    let folder = Folder::new("kinds");
    let complaint = |path: &Path| load(path).unwrap_err().to_string();
    assert!(complaint(&folder.0.join("no.obj")).ends_with("no.obj: no such file; check the path"));
    assert!(complaint(&folder.0).contains("is a directory"));
    let stl = complaint(&folder.write("a.stl", "solid a\n"));
    assert!(
        stl.ends_with(
            ": this is in STL format, which Mobula cannot load; Mobula loads Wavefront OBJ files (.obj, .obj.gz)"
        ),
        "{stl}"
    );
    assert!(complaint(&folder.write("a.xyz", "hello\n")).contains("in no format that Mobula knows"));
    assert!(complaint(&folder.write("a.ply.gz", gzip(b"ply\nformat"))).contains("in PLY format"));
    assert!(complaint(&folder.write("e.txt", "")).contains("the file is empty"));
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
        let complaint = folder.complaint(&packed[..length]);
        assert!(complaint.contains(": the gzip data ends too early; "), "{complaint}");
    }
    let mut damaged = packed.clone();
    let middle = damaged.len() / 2;
    damaged[middle..].fill(0xff);
    let complaint = folder.complaint(&damaged);
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
    let complaint = folder.complaint(&bomb);
    assert!(complaint.contains("out of proportion to its size"), "{complaint}");
}

#[test]
fn vertices_that_are_not_finite_are_counted() {
    let folder = Folder::new("nan");
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv nan 0 0\nv 1e999 0 0\nf 1 2 3\nf 1 2 4\nf 1 2 3 5\nf 1 1 2\n";
    let loaded = folder.load(text).unwrap();
    let report = &loaded.report;
    let keys = ["triangles", "non_finite_triangles", "degenerate_triangles"];
    assert_eq!(keys.map(|key| report.census.count(key)), [5, 2, 1]);
    assert_eq!(report.bounds(), Some([[0., 0., 0.], [1., 1., 0.]]));
    assert!(report.warnings[0].contains("test.obj:4: 2 vertices are not finite"), "{:?}", report.warnings);
}

#[test]
fn odd_but_legal_lines() {
    let folder = Folder::new("odd");
    let text = b"\xef\xbb\xbf# BOM\r\ng caf\xe9\r\n\tv 0 0 0\r\nv 1 0 0\r\nv 0 1 \\\r\n0\r\nf  1   2\t3 # triangle\r\ns off\r\n";
    let loaded = folder.load(text).unwrap();
    assert_eq!(mesh(&loaded).triangles, [[0, 1, 2]]);
    assert_eq!(loaded.report.warnings, [] as [String; 0], "{:?}", loaded.report.warnings);
    // Faces before their vertices are legal.
    let loaded = folder.load("f 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n").unwrap();
    assert_eq!(loaded.report.census.count("triangles"), 1);
}

#[test]
fn repeated_libraries_are_loaded_once() {
    let folder = Folder::new("repeated");
    folder.write("test.mtl", MATERIALS);
    let text = TWO_PARTS.replace("mtllib test.mtl\n", &"mtllib test.mtl\n".repeat(10_000));
    assert_eq!(folder.load(text).unwrap().scene.materials.len(), 2);
}
