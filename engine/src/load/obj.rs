//! Wavefront OBJ files, through `tobj`: objects and groups, normals, texture coordinates, a material per face.

use std::cell::RefCell;
use std::collections::HashSet;
use std::path::Path;

use glam::Vec3;

use super::lines::CheckedLines;
use super::loaded::{Loaded, Report, display_name};
use super::obj_check::{FaceHas, ObjCheck};
use super::{LoadError, input, mtl, polygon};
use crate::geometry::{DEFAULT_MATERIAL, Geometry, Mesh, MeshGroup, NO_INDEX};
use crate::scene::SceneDescription;

/// The remedy for what is not OBJ.
const REMEDY: &str = "export it as Wavefront OBJ";
/// Statements that name MTL files beyond this many are left out.
const MOST_LIBRARIES: usize = 64;

/// Loads an OBJ file, plain or packed with gzip, and the MTL files beside it.
pub(super) fn load(file: &Path) -> Result<Loaded, LoadError> {
    let input = input::open(file)?;
    let libraries = RefCell::new(Libraries::default());
    let mut lines = CheckedLines::new(input.reader, ObjCheck::default());
    // Polygons are cut by `polygon`, which knows concave ones.
    let options = tobj::LoadOptions { triangulate: false, single_index: false, ..tobj::LoadOptions::default() };
    let parsed = tobj::load_obj_buf(&mut lines, &options, |library| {
        libraries.borrow_mut().load(file, &library.to_string_lossy())
    });
    let Libraries { mut warnings, names, broken, missing, .. } = libraries.into_inner();
    if let Some(stop) = lines.stop {
        return Err(stop.into_error(file, lines.number, input.gzip));
    }
    if let Some(error) = broken {
        return Err(error);
    }
    let check = lines.check;
    if let Some((line, fault)) = check.dangling() {
        return Err(LoadError::new(file, fault.problem, fault.remedy).at(line));
    }
    let (models, materials) =
        parsed.map_err(|e| LoadError::new(file, e.to_string(), "export the mesh again").at(lines.number.max(1)))?;
    if check.faces == 0 {
        return Err(nothing(file, &check, lines.number));
    }
    let mesh = assemble(file, &models, &check)?;
    drop(models);

    let mut unknown = check.materials.iter().filter(|(name, _)| !missing && !names.contains(*name));
    if let Some((name, &line)) = unknown.next() {
        let name = super::error::quoted(name);
        let others = unknown.count();
        let others = if others > 0 { format!(" (and {others} others)") } else { String::new() };
        warnings.push(format!("{}:{line}: material {name}{others} is in no MTL file; grey is used", file.display()));
    }
    report_left_out(file, &check, &mut warnings);

    let mut scene = SceneDescription {
        name: display_name(file),
        materials: materials.unwrap_or_default().iter().map(mtl::describe).collect(),
        ..SceneDescription::default()
    };
    let mut census = mesh.census();
    // Of the file; the mesh has those that faces use.
    for (item, count) in [
        (Mesh::VERTICES, check.counts[0]),
        (Mesh::TEXTURE_COORDINATES, check.counts[1]),
        (Mesh::NORMALS, check.counts[2]),
        (Mesh::FACES, check.faces),
    ] {
        census.set(item, count);
    }
    let report = Report { format: if input.gzip { "OBJ, gzip" } else { "OBJ" }, census, warnings };
    scene.add(mesh);
    Ok(Loaded { scene, report })
}

/// Do all complete lines at the start of a file look like OBJ?
pub(super) fn looks_like(start: &[u8]) -> bool {
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

/// What the `mtllib` statements of a file brought.
#[derive(Default)]
struct Libraries {
    /// Statements that were carried out: exporters repeat them.
    done: HashSet<String>,
    names: HashSet<String>,
    missing: bool,
    warnings: Vec<String>,
    broken: Option<LoadError>,
}

impl Libraries {
    /// Loads the materials of a statement, which may name several files. A missing file is a warning.
    fn load(&mut self, obj: &Path, library: &str) -> tobj::MTLLoadResult {
        let mut all = mtl::Materials::default();
        if self.done.len() >= MOST_LIBRARIES || !self.done.insert(library.to_owned()) {
            return Ok(all);
        }
        let one = mtl::find(obj, library).is_some();
        let files: Vec<&str> = if one { vec![library] } else { library.split_whitespace().collect() };
        for name in files {
            let Some(path) = mtl::find(obj, name) else {
                let name = super::error::quoted(name);
                self.missing = true;
                self.warnings.push(format!("{}: material file {name} is not there; grey is used", obj.display()));
                continue;
            };
            let (mut materials, names) = mtl::load(&path, &mut self.warnings).map_err(|error| {
                self.broken.get_or_insert(error);
                tobj::LoadError::ReadError
            })?;
            let shift = all.0.len();
            all.0.append(&mut materials);
            all.1.extend(names.into_iter().map(|(name, index)| (name, index + shift)));
        }
        self.names.extend(all.1.keys().cloned());
        Ok(all)
    }
}

/// One mesh of all models: `tobj` makes a model of each run of faces of one group and material.
fn assemble(file: &Path, models: &[tobj::Model], check: &ObjCheck) -> Result<Mesh, LoadError> {
    let total: usize = models.iter().map(|m| m.mesh.positions.len() / 3).sum();
    if u32::try_from(total).is_err() {
        return Err(LoadError::new(file, format!("{total} vertices are more than 32-bit indices reach"), "split it"));
    }
    let mut mesh = Mesh { name: display_name(file), ..Mesh::default() };
    let mut face_has = check.face_has.iter();
    let mut cut = Vec::new();
    let mut corner_of = Vec::new();
    let mut positions: Vec<Vec3> = Vec::new();
    for model in models {
        let part = &model.mesh;
        let base = [mesh.positions.len(), mesh.texture_coordinates.len(), mesh.normals.len()].map(|n| n as u32);
        positions.clear();
        positions.extend(part.positions.as_chunks::<3>().0.iter().map(|&p| Vec3::from(p)));
        mesh.positions.extend(part.positions.as_chunks::<3>().0);
        mesh.texture_coordinates.extend(part.texcoords.as_chunks::<2>().0);
        mesh.normals.extend(part.normals.as_chunks::<3>().0);
        let first = mesh.triangles.len();
        let arities = if part.face_arities.is_empty() { &[] } else { part.face_arities.as_slice() };
        let faces = if arities.is_empty() { part.indices.len() / 3 } else { arities.len() };
        let mut corner = 0;
        for face in 0..faces {
            let arity = arities.get(face).map_or(3, |&n| n as usize);
            let corners = corner..corner + arity;
            corner += arity;
            let has = face_has.next().copied().unwrap_or(FaceHas::empty());
            // Triangles of places in the face, not of vertices: normals and texture coordinates need them too.
            cut.clear();
            if arity == 3 {
                cut.push([0, 1, 2]);
            } else {
                corner_of.clear();
                corner_of.extend(part.indices[corners.clone()].iter().map(|&i| positions[i as usize]));
                let places: Vec<u32> = (0..arity as u32).collect();
                polygon::triangulate(&corner_of, &places, &mut cut);
            }
            let pick =
                |indices: &[u32], base: u32, triangle: &[u32; 3], present: bool| match indices.get(corners.clone()) {
                    Some(indices) if present => triangle.map(|place| base + indices[place as usize]),
                    _ => [NO_INDEX; 3],
                };
            for triangle in &cut {
                mesh.triangles.push(pick(&part.indices, base[0], triangle, true));
                if check.counts[1] > 0 {
                    let present = has.contains(FaceHas::TEXTURE_COORDINATES);
                    mesh.triangle_texture_coordinates.push(pick(&part.texcoord_indices, base[1], triangle, present));
                }
                if check.counts[2] > 0 {
                    let present = has.contains(FaceHas::NORMALS);
                    mesh.triangle_normals.push(pick(&part.normal_indices, base[2], triangle, present));
                }
            }
        }
        let material = part.material_id.map_or(DEFAULT_MATERIAL, |id| id as u32);
        mesh.materials.resize(mesh.triangles.len(), material);
        let count = (mesh.triangles.len() - first) as u32;
        match mesh.groups.last_mut() {
            Some(group) if group.name == model.name => group.count += count,
            _ => mesh.groups.push(MeshGroup { name: model.name.clone(), first: first as u32, count }),
        }
    }
    if let Some(&material) = mesh.materials.first()
        && mesh.materials.iter().all(|&m| m == material)
    {
        mesh.materials = Vec::new();
        mesh.material = material;
    }
    Ok(mesh)
}

/// The error for a file without a face.
fn nothing(file: &Path, check: &ObjCheck, lines: u64) -> LoadError {
    let (vertices, last) = (check.counts[0], lines.max(1));
    if lines == 0 {
        LoadError::new(file, "the file is empty", "export the mesh again").at(1)
    } else if vertices == 0 && check.unknown.0 > 0 {
        let text = format!("not an OBJ file: {} of its {lines} lines say nothing that OBJ knows", check.unknown.0);
        LoadError::new(file, text, REMEDY).at(check.unknown.1)
    } else {
        let text = format!("no face in {lines} lines ({vertices} vertices)");
        LoadError::new(file, text, "export it as a triangle mesh").at(last)
    }
}

fn report_left_out(file: &Path, check: &ObjCheck, warnings: &mut Vec<String>) {
    let file = file.display();
    if check.non_finite.0 > 0 {
        let (count, line) = check.non_finite;
        warnings.push(format!("{file}:{line}: {count} vertices are not finite; their triangles are left out"));
    }
    if check.points_and_lines > 0 {
        warnings.push(format!("{file}: {} points and lines are left out", check.points_and_lines));
    }
    if check.free_form.0 > 0 {
        let (count, line) = check.free_form;
        warnings.push(format!("{file}:{line}: {count} statements about curves and surfaces are left out"));
    }
    if check.unknown.0 > 0 {
        let (count, line) = check.unknown;
        warnings.push(format!("{file}:{line}: {count} lines that OBJ does not know are left out"));
    }
}
