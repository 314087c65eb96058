//! One mesh of all meshes of a document, each where its node puts it.

use glam::{DMat3, DMat4, DVec3};
use gltf::mesh::Mode;
use gltf::{Mesh as GltfMesh, Node, Semantic};

use super::buffers::Buffers;
use crate::geometry::{DEFAULT_MATERIAL, Mesh, MeshGroup, NO_INDEX};
use crate::load::Place;

/// Instances of meshes become triangles of their own: more than this, beyond what the document itself holds, are refused.
const MOST_COPIES: usize = 1 << 26;

/// What has been gathered.
#[derive(Default)]
pub(super) struct Assembly {
    /// Of the scene, before they are put anywhere.
    pub(super) positions: Vec<[f64; 3]>,
    normals: Vec<[f32; 3]>,
    texture_coordinates: Vec<[f32; 2]>,
    /// As many as positions, if any has one.
    colors: Vec<[f32; 3]>,
    triangles: Vec<[u32; 3]>,
    triangle_normals: Vec<[u32; 3]>,
    triangle_texture_coordinates: Vec<[u32; 3]>,
    materials: Vec<u32>,
    groups: Vec<MeshGroup>,
    /// Parts that are left out, as they are points or lines.
    pub(super) other_modes: u64,
    /// Triangles with corners that are not there, which are left out.
    pub(super) dangling: u64,
    /// Parts whose material names several sets of texture coordinates.
    pub(super) other_sets: u64,
}

impl Assembly {
    /// Adds a mesh where a node is.
    pub(super) fn add(
        &mut self,
        node: &Node<'_>,
        mesh: &GltfMesh<'_>,
        transform: &DMat4,
        buffers: &Buffers,
    ) -> Result<(), String> {
        let first = self.triangles.len() as u32;
        for part in mesh.primitives() {
            if !matches!(part.mode(), Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
                self.other_modes += 1;
                continue;
            }
            let Some(positions) = part.get(&Semantic::Positions) else { continue };
            let positions = buffers.numbers::<3>(&positions)?;
            let indices = match part.indices() {
                Some(accessor) => buffers.indices(&accessor)?,
                None => (0..positions.len() as u32).collect(),
            };
            self.add_part(&part, &positions, &triangles(part.mode(), &indices), transform, buffers)?;
        }
        let count = self.triangles.len() as u32 - first;
        if count > 0 {
            let name = node.name().or(mesh.name()).map_or_else(|| format!("node {}", node.index()), str::to_owned);
            self.groups.push(MeshGroup { name, first, count });
        }
        Ok(())
    }

    fn add_part(
        &mut self,
        part: &gltf::Primitive<'_>,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        transform: &DMat4,
        buffers: &Buffers,
    ) -> Result<(), String> {
        let first = self.positions.len();
        if first + positions.len() >= NO_INDEX as usize || self.triangles.len() + triangles.len() > MOST_COPIES {
            return Err(format!(
                "with all its instances it has more than {MOST_COPIES} triangles, or too many vertices"
            ));
        }
        let count = positions.len() as u32;
        let put = |p: &[f32; 3]| transform.transform_point3(DVec3::from(p.map(f64::from))).to_array();
        self.positions.extend(positions.iter().map(put));
        let shift = |triangle: &[u32; 3], by: usize| triangle.map(|corner| corner + by as u32);
        // What shows one side here shows the other where a transform mirrors.
        let mirrored = transform.determinant() < 0.0;
        let there = triangles.iter().filter(|triangle| triangle.iter().all(|&corner| corner < count));
        let turned: Vec<[u32; 3]> = there.map(|&[a, b, c]| if mirrored { [a, c, b] } else { [a, b, c] }).collect();
        self.dangling += (triangles.len() - turned.len()) as u64;
        self.triangles.extend(turned.iter().map(|triangle| shift(triangle, first)));

        let of_normals = self.normals.len();
        if let Some(accessor) = part.get(&Semantic::Normals) {
            let turn = DMat3::from_mat4(*transform).inverse().transpose();
            let put = |n: [f32; 3]| (turn * DVec3::from(n.map(f64::from))).normalize_or_zero().as_vec3().to_array();
            self.normals.extend(buffers.numbers::<3>(&accessor)?.into_iter().map(put));
        }
        let has_normals = self.normals.len() == of_normals + count as usize;
        let none = [NO_INDEX; 3];
        self.triangle_normals.extend(turned.iter().map(|t| if has_normals { shift(t, of_normals) } else { none }));

        let set = self.coordinate_set(part);
        let of_coordinates = self.texture_coordinates.len();
        if let Some(accessor) = part.get(&Semantic::TexCoords(set)) {
            self.texture_coordinates.extend(buffers.numbers::<2>(&accessor)?.into_iter().map(|[u, v]| [u, 1.0 - v]));
        }
        let has_coordinates = self.texture_coordinates.len() == of_coordinates + count as usize;
        let to = |t| if has_coordinates { shift(t, of_coordinates) } else { none };
        self.triangle_texture_coordinates.extend(turned.iter().map(to));

        if let Some(accessor) = part.get(&Semantic::Colors(0)) {
            self.colors.resize(first, [1.0; 3]);
            let sound = |x: f32| if x > 0.0 { x.min(1.0) } else { 0.0 };
            self.colors.extend(buffers.numbers::<3>(&accessor)?.into_iter().map(|color| color.map(sound)));
        }
        if !self.colors.is_empty() {
            self.colors.resize(self.positions.len(), [1.0; 3]);
        }
        let material = part.material().index().map_or(DEFAULT_MATERIAL, |index| index as u32);
        self.materials.resize(self.triangles.len(), material);
        Ok(())
    }

    /// Which set of texture coordinates the material of a part uses.
    fn coordinate_set(&mut self, part: &gltf::Primitive<'_>) -> u32 {
        let material = part.material();
        let metallic = material.pbr_metallic_roughness();
        let set = |info: Option<gltf::texture::Info<'_>>| {
            let info = info?;
            Some(info.texture_transform().and_then(|transform| transform.tex_coord()).unwrap_or(info.tex_coord()))
        };
        let mut sets = [
            set(metallic.base_color_texture()),
            material.normal_texture().map(|normal| normal.tex_coord()),
            set(metallic.metallic_roughness_texture()),
            set(material.emissive_texture()),
        ]
        .into_iter()
        .flatten();
        let first = sets.next().unwrap_or(0);
        self.other_sets += u64::from(sets.any(|other| other != first));
        first
    }

    /// The corners of all triangles.
    pub(super) fn corners(&self) -> Vec<u32> {
        self.triangles.as_flattened().to_vec()
    }

    /// The mesh, where it is put.
    pub(super) fn into_mesh(self, name: String, place: &Place) -> Mesh {
        let normals = if self.normals.is_empty() { Vec::new() } else { self.triangle_normals };
        let coordinates =
            if self.texture_coordinates.is_empty() { Vec::new() } else { self.triangle_texture_coordinates };
        let one = self.materials.windows(2).all(|pair| pair[0] == pair[1]);
        Mesh {
            name,
            positions: self.positions.into_iter().map(|position| place.put(position)).collect(),
            normals: self.normals,
            texture_coordinates: self.texture_coordinates,
            colors: self.colors,
            triangles: self.triangles,
            triangle_normals: normals,
            triangle_texture_coordinates: coordinates,
            material: self.materials.first().copied().unwrap_or(DEFAULT_MATERIAL),
            materials: if one { Vec::new() } else { self.materials },
            groups: self.groups,
        }
    }
}

/// The triangles that indices stand for. Every other one of a strip is turned round.
fn triangles(mode: Mode, indices: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turn = |(i, three): (usize, &[u32])| {
                if i % 2 == 0 { [three[0], three[1], three[2]] } else { [three[1], three[0], three[2]] }
            };
            indices.windows(3).enumerate().map(turn).collect()
        }
        Mode::TriangleFan => match indices.split_first() {
            Some((&middle, rim)) => rim.windows(2).map(|pair| [middle, pair[0], pair[1]]).collect(),
            None => Vec::new(),
        },
        _ => indices.as_chunks().0.to_vec(),
    }
}
