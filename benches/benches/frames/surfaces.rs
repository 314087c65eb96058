//! What the bare loop knows of surfaces: normals, base colours and textures.

use glam::Vec3;
use mobula::geometry::{Mesh, NO_INDEX};
use mobula::material::Lambertian;
use mobula::scene::SceneDescription;
use mobula::texture::Map;
use mobula_benches::scenes::Triangles;

/// The triangles of a scene, and how they look.
pub(crate) struct Surfaces<'a> {
    triangles: &'a Triangles,
    /// Base colours by triangle, linear RGB.
    colors: Vec<Vec3>,
    maps: Vec<Map>,
    /// By triangle; empty if nothing has a texture.
    textured: Vec<Option<Textured>>,
}

/// How a texture lies on a triangle.
#[derive(Clone, Copy)]
struct Textured {
    /// Index of the texture.
    map: usize,
    /// Texture coordinates of the corners.
    corners: [[f32; 2]; 3],
    /// Area in texture coordinates for each unit of the triangle's own.
    density: f32,
}

/// As Mobula has it: surfaces count as seen at least as steeply.
const LEAST_COSINE: f32 = 0.1;

impl<'a> Surfaces<'a> {
    pub(crate) fn new(scene: &SceneDescription, triangles: &'a Triangles) -> Self {
        let (mut colors, mut maps, mut textured) = (Vec::new(), Vec::new(), Vec::new());
        let default = Lambertian::default().diffuse;
        let map_of: Vec<Option<usize>> = scene
            .materials
            .iter()
            .map(|named| {
                maps.push(named.material.maps().color.clone()?);
                Some(maps.len() - 1)
            })
            .collect();
        for mesh in scene.geometry.iter().filter_map(|geometry| geometry.downcast_ref::<Mesh>()) {
            for i in 0..mesh.triangles.len() {
                let material = mesh.material_of(i) as usize;
                let map = map_of.get(material).copied().flatten();
                textured.push(map.and_then(|map| on_triangle(mesh, i, map, triangles.corners(colors.len()))));
                colors.push(scene.materials.get(material).map_or(default, |named| named.material.base_color()));
            }
        }
        assert_eq!(colors.len(), triangles.indices.len(), "both have the same triangles");
        if textured.iter().all(Option::is_none) {
            textured.clear();
        }
        Self { triangles, colors, maps, textured }
    }

    /// Has anything a texture?
    pub(crate) fn are_textured(&self) -> bool {
        !self.textured.is_empty()
    }

    /// The unit normal on the side that a ray comes from.
    #[inline(always)]
    pub(crate) fn normal(&self, triangle: usize, direction: Vec3) -> Vec3 {
        let [a, b, c] = self.triangles.corners(triangle).map(Vec3::from);
        let normal = (b - a).cross(c - a);
        let normal = normal * (1.0 / normal.dot(normal).sqrt());
        if normal.dot(direction) > 0.0 { -normal } else { normal }
    }

    /// The colour at a place on a triangle, through a cone of so much width there.
    #[inline(always)]
    pub(crate) fn color(&self, triangle: usize, [u, v]: [f32; 2], width: f32, direction: Vec3) -> Vec3 {
        let color = self.colors[triangle];
        let Some(&Some(Textured { map, corners: [a, b, c], density })) = self.textured.get(triangle) else {
            return color;
        };
        let place = [0, 1].map(|k| a[k] * (1.0 - u - v) + b[k] * u + c[k] * v);
        let cosine = -self.normal(triangle, direction).dot(direction);
        let area = width * width * density / cosine.max(LEAST_COSINE);
        color * self.maps[map].sample(place, area).truncate()
    }
}

fn on_triangle(mesh: &Mesh, i: usize, map: usize, corners: [[f32; 3]; 3]) -> Option<Textured> {
    let indices = mesh.triangle_texture_coordinates.get(i)?;
    if indices.contains(&NO_INDEX) {
        return None;
    }
    let uv = indices.map(|index| mesh.texture_coordinates[index as usize]);
    let [a, b, c] = corners.map(Vec3::from);
    let [ua, ub, uc] = uv.map(|[u, v]| Vec3::new(u, v, 0.0));
    let density = (ub - ua).cross(uc - ua).length() / (b - a).cross(c - a).length();
    Some(Textured { map, corners: uv, density: if density.is_finite() { density } else { 0.0 } })
}
