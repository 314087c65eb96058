//! Vertices and faces of a PLY file that are a mesh, with normals, colours and texture coordinates of vertices.

use super::header::{Element, Header};
use super::rows::{Row, Rows};
use crate::color::from_srgb8;
use crate::geometry::{Geometry, Mesh};
use crate::load::lines::Fault;
use crate::load::loaded::{Loaded, Report, display_name};
use crate::load::text::counted;
use crate::load::{LoadError, Options, Place, VoxelType, polygon};
use crate::scene::SceneDescription;

/// More vertices have no numbers.
const MOST_VERTICES: u64 = u32::MAX as u64;

/// What was read, as the file has it.
#[derive(Default)]
struct Read {
    positions: Vec<[f64; 3]>,
    normals: Vec<[f32; 3]>,
    colors: Vec<[f32; 3]>,
    texture_coordinates: Vec<[f32; 2]>,
    /// The corners of all faces, and how many each has.
    corners: Vec<u32>,
    faces: Vec<u32>,
    /// Faces with fewer than three corners.
    too_few: u64,
}

/// Loads a mesh.
pub(super) fn load(mut rows: Rows<'_>, header: &Header, options: &Options) -> Result<Loaded, LoadError> {
    let file = rows.file();
    let last = header.lines;
    let named = |name: &str| {
        let missing =
            || LoadError::new(file, format!("there is no element '{name}'"), "check how it was written").at(last);
        header.elements.iter().position(|element| element.name == name).ok_or_else(missing)
    };
    let (vertex, face) = (named("vertex")?, named("face")?);
    let vertices = header.elements[vertex].count;
    if vertices >= MOST_VERTICES {
        let problem = format!("{vertices} vertices are more than 32-bit indices reach");
        return Err(LoadError::new(file, problem, "split it").at(header.elements[vertex].line));
    }
    let mut read = Read::default();
    for (at, element) in header.elements.iter().enumerate().take(vertex.max(face) + 1) {
        match at {
            _ if at == vertex => read.vertices(&mut rows, element)?,
            _ if at == face => read.faces(&mut rows, element, vertices)?,
            _ => rows.skip(element)?,
        }
    }
    let mut warnings = Vec::new();
    let place = Place::choose(options.place, file, &read.positions, &read.corners, &mut warnings);
    if read.too_few > 0 {
        let faces = counted(read.too_few, "face");
        warnings.push(format!("{}: {faces} with fewer than three corners left out", file.display()));
    }
    let faces = read.faces.len();
    let (mesh, rough) = read.into_mesh(display_name(file), &place);
    if rough > 0 {
        let file = file.display();
        warnings.push(format!(
            "{file}: {rough} polygons of very many corners, or that cross themselves, are cut only roughly"
        ));
    }
    let mut census = mesh.census();
    for (item, count) in [
        (Mesh::VERTICES, mesh.positions.len()),
        (Mesh::TEXTURE_COORDINATES, mesh.texture_coordinates.len()),
        (Mesh::NORMALS, mesh.normals.len()),
        (Mesh::FACES, faces),
    ] {
        census.set(item, count as u64);
    }
    let mut scene = SceneDescription { name: display_name(file), ..SceneDescription::default() };
    scene.add(mesh);
    Ok(Loaded { scene, report: Report { format: "PLY", census, warnings }, place })
}

impl Read {
    fn vertices(&mut self, rows: &mut Rows<'_>, element: &Element) -> Result<(), LoadError> {
        let three = |names: [&[&str]; 3]| {
            let [x, y, z] = names.map(|names| element.find(names, false));
            Some([x?, y?, z?])
        };
        let Some(position) = three([&["x"], &["y"], &["z"]]) else {
            let problem = "vertices have no properties x, y and z";
            return Err(LoadError::new(rows.file(), problem, "check how it was written").at(element.line));
        };
        let normal = three([&["nx"], &["ny"], &["nz"]]);
        let color =
            three([&["red", "diffuse_red", "r"], &["green", "diffuse_green", "g"], &["blue", "diffuse_blue", "b"]]);
        let bytes = color.is_some_and(|at| at.iter().all(|&at| element.properties[at].kind == VoxelType::U8));
        let texture = [&["u", "s", "texture_u"], &["v", "t", "texture_v"]].map(|names| element.find(names, false));
        let mut row = Row::default();
        for number in 0..element.count {
            rows.next(element, number, None, &mut row)?;
            let value = |at: usize| row.scalars[at];
            self.positions.push(position.map(value));
            if let Some(normal) = normal {
                self.normals.push(normal.map(|at| finite(value(at), 0.0)));
            }
            if let Some(color) = color {
                let color = color.map(value);
                self.colors.push(if bytes {
                    from_srgb8(color.map(|x| x as u8)).to_array()
                } else {
                    color.map(|x| finite(x, 1.0).clamp(0.0, 1.0))
                });
            }
            if let [Some(u), Some(v)] = texture {
                self.texture_coordinates.push([u, v].map(|at| finite(value(at), 0.0)));
            }
        }
        Ok(())
    }

    fn faces(&mut self, rows: &mut Rows<'_>, element: &Element, vertices: u64) -> Result<(), LoadError> {
        let Some(list) = element.find(&["vertex_indices", "vertex_index"], true) else {
            let problem = "faces have no list vertex_indices";
            return Err(LoadError::new(rows.file(), problem, "check how it was written").at(element.line));
        };
        let mut row = Row::default();
        for number in 0..element.count {
            rows.next(element, number, Some(list), &mut row)?;
            let is_vertex = |index: f64| index >= 0.0 && index.fract() == 0.0 && index < vertices as f64;
            if let Some(index) = row.list.iter().find(|index| !is_vertex(**index)) {
                let problem = format!("there is no vertex {index}: there are {vertices}, from 0");
                return Err(rows.fault(Fault::new(problem, "check how it was written"), element, Some(number)));
            }
            if row.list.len() < 3 {
                self.too_few += 1;
                continue;
            }
            self.faces.push(row.list.len() as u32);
            self.corners.extend(row.list.iter().map(|&index| index as u32));
        }
        Ok(())
    }

    /// The mesh, and how many polygons were cut only roughly.
    fn into_mesh(self, name: String, place: &Place) -> (Mesh, u64) {
        let (mut triangles, mut cut, mut cutter) = (Vec::new(), Vec::new(), polygon::Cutter::default());
        let mut rest = &self.corners[..];
        for &count in &self.faces {
            let (face, after) = rest.split_at(count as usize);
            rest = after;
            cut.clear();
            if count == 3 {
                cut.push([0, 1, 2]);
            } else {
                cutter.cut(face.iter().map(|&index| self.positions[index as usize]), &mut cut);
            }
            triangles.extend(cut.iter().map(|triangle| triangle.map(|corner| face[corner as usize])));
        }
        let all = |some: bool| if some { triangles.clone() } else { Vec::new() };
        let mesh = Mesh {
            name,
            positions: self.positions.iter().map(|&position| place.put(position)).collect(),
            triangle_normals: all(!self.normals.is_empty()),
            triangle_texture_coordinates: all(!self.texture_coordinates.is_empty()),
            normals: self.normals,
            colors: self.colors,
            texture_coordinates: self.texture_coordinates,
            triangles,
            ..Mesh::default()
        };
        (mesh, cutter.rough)
    }
}

/// A number as `f32`, or another if it is not finite.
fn finite(number: f64, other: f32) -> f32 {
    let number = number as f32;
    if number.is_finite() { number } else { other }
}
