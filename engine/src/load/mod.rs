//! Loaders: files from strangers become a [`SceneDescription`], or one clear line that names file, line and remedy.
//!
//! | file | what it holds |
//! |---|---|
//! | `obj` | OBJ through `tobj`, assembled into one mesh |
//! | `obj_check`, `mtl_check` | what a line must look like before the parser sees it |
//! | `mtl` | materials of OBJ files |
//! | `polygon` | polygons into triangles |
//! | `lines` | the reader that checks line by line |
//! | `input` | plain and gzip files, with a limit on what they unpack to |
//! | `error` | [`LoadError`] |

mod error;
mod input;
mod lines;
mod mtl;
mod mtl_check;
mod obj;
mod obj_check;
mod polygon;

use std::path::Path;

use glam::Vec3;

pub use error::LoadError;

use crate::scene::{Mesh, SceneDescription, Spheres};

/// What can be loaded, for messages.
const SUPPORTED: &str = "Mobula loads Wavefront OBJ files (.obj, .obj.gz)";

/// A loaded file.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// What is in it.
    pub scene: SceneDescription,
    /// What was found on the way.
    pub report: Report,
}

/// What was found in a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Its format, for people.
    pub format: &'static str,
    /// Least and greatest corner of the finite triangles; `None` if there is none.
    pub bounds: Option<[[f32; 3]; 2]>,
    /// Vertices in the file.
    pub vertices: u64,
    /// Texture coordinates in the file.
    pub texture_coordinates: u64,
    /// Normals in the file.
    pub normals: u64,
    /// Faces in the file, of three corners or more.
    pub faces: u64,
    /// Triangles that the faces were cut into.
    pub triangles: u64,
    /// Spheres.
    pub spheres: u64,
    /// Triangles without area.
    pub degenerate_triangles: u64,
    /// Triangles with a corner that is not finite.
    pub non_finite_triangles: u64,
    /// Named groups.
    pub groups: u64,
    /// What people should know, a line each.
    pub warnings: Vec<String>,
}

/// Loads a file, choosing the format by its name and its content.
///
/// # Errors
/// If it cannot be read, is of no supported format, or is broken; the error is one line that says where and what to do.
pub fn load(file: &Path) -> Result<Loaded, LoadError> {
    let name = file.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    if stem.ends_with(".obj") {
        return obj::load(file);
    }
    let mut start = [0; 512];
    let mut input = input::open(file)?;
    let mut length = 0;
    while length < start.len() {
        match input.reader.read(&mut start[length..]) {
            Ok(0) | Err(_) => break,
            Ok(count) => length += count,
        }
    }
    let start = &start[..length];
    if looks_like_obj(start) {
        return obj::load(file);
    }
    let problem = match known_format(start, stem) {
        Some(format) => format!("this is in {format} format, which Mobula cannot load"),
        None if start.is_empty() => "the file is empty".into(),
        None => "this is in no format that Mobula knows".into(),
    };
    Err(LoadError::new(file, problem, SUPPORTED))
}

/// Do all complete lines at the start of a file look like OBJ?
fn looks_like_obj(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let mut statements = 0;
    for line in text.split_inclusive('\n').filter(|line| line.ends_with('\n')) {
        match line.split_whitespace().next() {
            Some("v" | "vn" | "vt" | "f" | "g" | "o" | "s" | "l" | "p" | "mtllib" | "usemtl") => statements += 1,
            Some(word) if !word.starts_with('#') => return false,
            _ => {}
        }
    }
    statements > 0
}

/// The name of a format that we know but cannot load.
fn known_format(start: &[u8], name: &str) -> Option<&'static str> {
    const MAGIC: [(&[u8], &str); 7] = [
        (b"ply", "PLY"),
        (b"NRRD", "NRRD"),
        (b"glTF", "glTF"),
        (b"solid", "STL"),
        (b"PK\x03\x04", "ZIP"),
        (b"\x89PNG", "PNG"),
        (b"<?xml", "XML"),
    ];
    const EXTENSIONS: [(&str, &str); 8] = [
        (".stl", "STL"),
        (".ply", "PLY"),
        (".nrrd", "NRRD"),
        (".nhdr", "NRRD"),
        (".gltf", "glTF"),
        (".fbx", "FBX"),
        (".3ds", "3DS"),
        (".mtl", "material (MTL)"),
    ];
    let magic = MAGIC.iter().find(|(magic, _)| start.starts_with(magic)).map(|&(_, format)| format);
    magic.or_else(|| EXTENSIONS.iter().find(|(end, _)| name.ends_with(end)).map(|&(_, format)| format))
}

/// A file's name without folder and extensions.
fn display_name(file: &Path) -> String {
    let name = file.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

/// Does a triangle of finite corners have an area? In f64 it does not vanish by rounding.
fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.to_array().map(f64::from));
    let edge = |to: [f64; 3]| [0, 1, 2].map(|i| to[i] - a[i]);
    let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
    uy * vz - uz * vy != 0.0 || uz * vx - ux * vz != 0.0 || ux * vy - uy * vx != 0.0
}

impl Report {
    /// Counts what is in a mesh.
    pub fn of_mesh(mesh: &Mesh) -> Self {
        let mut report = Self {
            vertices: mesh.positions.len() as u64,
            texture_coordinates: mesh.texture_coordinates.len() as u64,
            normals: mesh.normals.len() as u64,
            faces: mesh.triangles.len() as u64,
            triangles: mesh.triangles.len() as u64,
            groups: mesh.groups.len() as u64,
            ..Self::default()
        };
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for i in 0..mesh.triangles.len() {
            let Some([a, b, c]) = mesh.corners(i).filter(|corners| corners.iter().all(|p| p.is_finite())) else {
                report.non_finite_triangles += 1;
                continue;
            };
            if !has_area([a, b, c]) {
                report.degenerate_triangles += 1;
            }
            (low, high) = (low.min(a).min(b).min(c), high.max(a).max(b).max(c));
        }
        if low.cmple(high).all() {
            report.bounds = Some([low.into(), high.into()]);
        }
        report
    }

    /// Counts what is in a set of spheres.
    pub fn of_spheres(spheres: &Spheres) -> Self {
        let mut report = Self { spheres: spheres.centers.len() as u64, ..Self::default() };
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        let finite = |(center, radius): &(Vec3, f32)| center.is_finite() && radius.is_finite();
        for (center, radius) in (0..spheres.centers.len()).filter_map(|i| spheres.sphere(i)).filter(finite) {
            (low, high) = (low.min(center - radius), high.max(center + radius));
        }
        if low.cmple(high).all() {
            report.bounds = Some([low.into(), high.into()]);
        }
        report
    }

    /// Adds what was found in another file.
    pub fn merge(&mut self, other: Self) {
        self.vertices += other.vertices;
        self.texture_coordinates += other.texture_coordinates;
        self.normals += other.normals;
        self.faces += other.faces;
        self.triangles += other.triangles;
        self.spheres += other.spheres;
        self.degenerate_triangles += other.degenerate_triangles;
        self.non_finite_triangles += other.non_finite_triangles;
        self.groups += other.groups;
        self.warnings.extend(other.warnings);
        self.bounds = match (self.bounds, other.bounds) {
            (Some([a, b]), Some([c, d])) => {
                let low = Vec3::from(a).min(Vec3::from(c));
                let high = Vec3::from(b).max(Vec3::from(d));
                Some([low.into(), high.into()])
            }
            (one, None) => one,
            (None, one) => one,
        };
    }
}
