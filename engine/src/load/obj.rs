//! Wavefront OBJ files: objects and groups, normals, texture coordinates, colours of vertices, a material per face.

use std::mem::take;
use std::path::Path;

use super::input::Input;
use super::loaded::{Loaded, Report, display_name};
use super::mtl::Library;
use super::obj_read::{Obj, Seen};
use super::place::Place;
use super::text::quoted;
use super::{LoadError, Options, polygon};
use crate::geometry::{DEFAULT_MATERIAL, Geometry, Mesh, MeshGroup, NO_INDEX};
use crate::scene::SceneDescription;

/// Loads an OBJ file and the MTL files beside it.
pub(super) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let read = Obj::read(&mut input.reader);
    let mut obj = read.map_err(|(line, stop)| stop.into_error(file, line, input.gzip))?;
    if obj.corners.is_empty() {
        return Err(nothing(file, &obj));
    }
    let mut library = Library::of(file, &obj.libraries, &options.progress)?;
    let mut warnings = take(&mut library.warnings);
    let material_of = materials(file, &obj, &library, &mut warnings);

    let faces = obj.corners.len();
    let place = Place::choose(options.place, file, &obj.positions, &obj.indices[0], &mut warnings);
    warnings.extend(left_out(file, &obj));
    warnings.extend(input.warning(file));
    let counts = [obj.positions.len(), obj.texture_coordinates.len(), obj.normals.len()];
    let (mesh, rough) = assemble(file, &mut obj, &material_of, &place)?;
    if rough > 0 {
        let file = file.display();
        warnings.push(format!(
            "{file}: {rough} polygons of very many corners, or that cross themselves, are cut only roughly"
        ));
    }
    drop(obj);

    let mut scene =
        SceneDescription { name: display_name(file), materials: library.materials, ..SceneDescription::default() };
    let mut census = mesh.census();
    for (item, count) in [
        (Mesh::VERTICES, counts[0]),
        (Mesh::TEXTURE_COORDINATES, counts[1]),
        (Mesh::NORMALS, counts[2]),
        (Mesh::FACES, faces),
    ] {
        census.set(item, count as u64);
    }
    let report = Report { format: if input.gzip { "OBJ, gzip" } else { "OBJ" }, census, warnings };
    scene.add(mesh);
    Ok(Loaded { scene, report, place })
}

/// Do all complete lines at the start of a file look like OBJ?
pub(super) fn looks_like(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    let text = text.trim_start_matches('\u{feff}');
    let mut statements = 0;
    for line in text.split_inclusive(['\n', '\r']).filter(|line| line.ends_with(['\n', '\r'])) {
        match line.split_whitespace().next() {
            Some("v" | "vn" | "vt" | "f" | "g" | "o" | "s" | "l" | "p" | "mtllib" | "usemtl") => statements += 1,
            Some(word) if !word.starts_with('#') => return false,
            _ => {}
        }
    }
    statements > 0
}

/// The index of the material that each name means. What no MTL file has is grey.
fn materials(file: &Path, obj: &Obj, library: &Library, warnings: &mut Vec<String>) -> Vec<u32> {
    let index = |(name, _): &(String, u64)| library.index_of(name).unwrap_or(DEFAULT_MATERIAL);
    let of: Vec<u32> = obj.names.iter().map(index).collect();
    let mut unknown = obj.names.iter().zip(&of).filter(|&(_, &of)| of == DEFAULT_MATERIAL && !library.missing);
    if let Some(((name, line), _)) = unknown.next() {
        let others = unknown.count();
        let others = match others {
            0 => String::new(),
            1 => " (and another)".to_owned(),
            others => format!(" (and {others} others)"),
        };
        let name = quoted(name);
        warnings.push(format!("{}:{line}: material {name}{others} is in no MTL file; grey is used", file.display()));
    }
    of
}

/// One mesh of all faces. What is done with is given back at once: files may be large.
fn assemble(file: &Path, obj: &mut Obj, material_of: &[u32], place: &Place) -> Result<(Mesh, u64), LoadError> {
    if obj.positions.len() >= NO_INDEX as usize {
        let problem = format!("{} vertices are more than 32-bit indices reach", obj.positions.len());
        return Err(LoadError::new(file, problem, "split it"));
    }
    if obj.indices[0].len() >= u32::MAX as usize {
        let problem = format!("{} corners of faces are more than there are numbers", obj.indices[0].len());
        return Err(LoadError::new(file, problem, "split it"));
    }
    let mut mesh = Mesh { name: display_name(file), ..Mesh::default() };
    let (cut, rough) = cut(obj);
    let counts = [obj.positions.len(), obj.texture_coordinates.len(), obj.normals.len()];
    let [of_vertex, of_texture, of_normal] = [0, 1, 2].map(|list| {
        let indices = whole_faces(take(&mut obj.indices[list]), &obj.corners, counts[list]);
        match &cut {
            _ if indices.is_empty() => Vec::new(),
            None => indices.as_chunks().0.to_vec(),
            Some(triangles) => triangles.iter().map(|t| t.map(|corner| indices[corner as usize])).collect(),
        }
    });
    drop(cut);
    (mesh.triangles, mesh.triangle_texture_coordinates, mesh.triangle_normals) = (of_vertex, of_texture, of_normal);
    add_groups(&mut mesh, obj);
    add_materials(&mut mesh, obj, material_of);
    mesh.positions = take(&mut obj.positions).into_iter().map(|position| place.put(position)).collect();
    mesh.texture_coordinates = take(&mut obj.texture_coordinates);
    mesh.normals = take(&mut obj.normals);
    mesh.colors = colors(take(&mut obj.colors), mesh.positions.len());
    Ok((mesh, rough))
}

/// The triangles of all faces, by their corners' places among all; `None` if all faces are triangles. And how many polygons are cut only
/// roughly.
fn cut(obj: &Obj) -> (Option<Vec<[u32; 3]>>, u64) {
    if obj.corners.iter().all(|&corners| corners == 3) {
        return (None, 0);
    }
    let of_vertex = &obj.indices[0];
    let (mut triangles, mut cutter, mut cut) = (Vec::new(), polygon::Cutter::default(), Vec::new());
    let mut first = 0;
    for &corners in &obj.corners {
        let end = first + corners as usize;
        cut.clear();
        if corners == 3 {
            cut.push([0, 1, 2]);
        } else {
            cutter.cut(of_vertex[first..end].iter().map(|&i| obj.positions[i as usize]), &mut cut);
        }
        triangles.extend(cut.iter().map(|triangle| triangle.map(|place| first as u32 + place)));
        first = end;
    }
    (Some(triangles), cutter.rough)
}

/// The indices of corners, without any for faces of which not all corners have one in range; nothing if none has.
fn whole_faces(mut indices: Vec<u32>, corners: &[u32], count: usize) -> Vec<u32> {
    if indices.is_empty() {
        return indices;
    }
    indices.resize(corners.iter().map(|&corners| corners as usize).sum(), NO_INDEX);
    let mut rest = &mut indices[..];
    for &corners in corners {
        let (face, others) = rest.split_at_mut(corners as usize);
        if face.iter().any(|&index| index as usize >= count) {
            face.fill(NO_INDEX);
        }
        rest = others;
    }
    indices
}

/// What gives the first triangle of each face, by rising faces.
fn firsts(obj: &Obj) -> impl FnMut(usize) -> u32 {
    let (mut reached, mut triangle) = (0, 0);
    move |face| {
        triangle += obj.corners[reached..face].iter().map(|corners| corners - 2).sum::<u32>();
        reached = face;
        triangle
    }
}

fn add_groups(mesh: &mut Mesh, obj: &Obj) {
    let mut first = firsts(obj);
    let group = |(face, name): &(usize, String)| MeshGroup { name: name.clone(), first: first(*face), count: 0 };
    mesh.groups = obj.groups.iter().map(group).collect();
    let mut end = mesh.triangles.len() as u32;
    for group in mesh.groups.iter_mut().rev() {
        group.count = end - group.first;
        end = group.first;
    }
    mesh.groups.retain(|group| group.count > 0);
}

/// One material for all triangles, or else one for each.
fn add_materials(mesh: &mut Mesh, obj: &Obj, material_of: &[u32]) {
    let (mut first, count) = (firsts(obj), mesh.triangles.len());
    let material = |number: u32| material_of.get(number as usize).copied().unwrap_or(DEFAULT_MATERIAL);
    let named = obj.materials.iter().map(|&(face, number)| (first(face) as usize, material(number)));
    let mut runs = std::iter::once((0, DEFAULT_MATERIAL)).chain(named).peekable();
    while let Some((first, material)) = runs.next() {
        let end = runs.peek().map_or(count, |&(first, _)| first);
        if first == end {
            continue;
        }
        if first == 0 {
            mesh.material = material;
        }
        if !mesh.materials.is_empty() || material != mesh.material {
            mesh.materials.resize(first, mesh.material);
            mesh.materials.resize(end, material);
        }
    }
}

/// Colours of all vertices, white where there is none; some programs write them from 0 to 255: whole numbers, of which more than one
/// is above 1.
fn colors(mut colors: Vec<[f32; 3]>, count: usize) -> Vec<[f32; 3]> {
    if colors.is_empty() {
        return colors;
    }
    let mut all = colors.iter().flatten();
    let bytes = all.clone().filter(|&&x| x > 1.0).take(2).count() == 2
        && all.all(|&x| (0.0..=255.0).contains(&x) && x.fract() == 0.0);
    let white = if bytes { 255.0 } else { 1.0 };
    colors.iter_mut().flatten().for_each(|x| *x = (*x / white).clamp(0.0, 1.0));
    colors.resize(count, [1.0; 3]);
    colors
}

/// The error for a file without a face.
fn nothing(file: &Path, obj: &Obj) -> LoadError {
    let (vertices, lines) = (obj.positions.len(), obj.lines);
    if lines == 0 {
        LoadError::new(file, "the file is empty", "name a file with a mesh in it").at(1)
    } else if vertices == 0 && obj.unknown.count > 0 {
        let text = format!("not an OBJ file: {} of its {lines} lines say nothing that OBJ knows", obj.unknown.count);
        LoadError::new(file, text, "export it as Wavefront OBJ").at(obj.unknown.line)
    } else {
        let text = format!("no face in {lines} lines ({vertices} vertices)");
        LoadError::new(file, text, "export it as a triangle mesh").at(lines)
    }
}

/// What is left out of a file, a line each.
fn left_out(file: &Path, obj: &Obj) -> impl Iterator<Item = String> {
    let file = file.display().to_string();
    let what = [
        (
            obj.not_finite,
            "vertex that is not finite; its triangles are left out",
            "vertices that are not finite; their triangles are left out",
        ),
        (
            obj.fourth_numbers,
            "vertex with a fourth number, which is left out",
            "vertices with a fourth number, which is left out",
        ),
        (
            obj.odd_texture_coordinates,
            "texture coordinate that is not finite; zero is used",
            "texture coordinates that are not finite; zero is used",
        ),
        (obj.odd_normals, "normal that is not finite is left out", "normals that are not finite are left out"),
        (obj.odd_colors, "colour that is not finite; white is used", "colours that are not finite; white is used"),
        (
            obj.odd_numbers,
            "vertex with 5 or more than 7 numbers, of which 3 are used",
            "vertices with 5 or more than 7 numbers, of which 3 are used",
        ),
        (obj.empty_faces, "face without corners is left out", "faces without corners are left out"),
        (
            obj.dangling,
            "list whose indices are out of range, which are left out",
            "lists whose indices are out of range, which are left out",
        ),
        (obj.nameless_materials, "usemtl without a name; grey is used", "usemtl without a name; grey is used"),
        (obj.points_and_lines, "point or line is left out", "points and lines are left out"),
        (
            obj.free_form,
            "statement about curves and surfaces is left out",
            "statements about curves and surfaces are left out",
        ),
        (obj.unknown, "line that OBJ does not know is left out", "lines that OBJ does not know are left out"),
    ];
    let said = move |(Seen { count, line }, one, many): (Seen, &'static str, &'static str)| {
        (count > 0).then(|| format!("{file}:{line}: {count} {}", if count == 1 { one } else { many }))
    };
    what.into_iter().filter_map(said)
}
