//! Spheres: particles, atoms.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::kernel::sphere::RADII;
use mobula_core::leaf::SphereBlock;

use super::ball;
use super::{Census, DEFAULT_MATERIAL, Geometry, InTree, Item, Structure, Tree, draw, shift_material};
use crate::accel::Build;
use crate::packet::{Hits, Surface, set_vec3};

/// Spheres.
#[derive(Clone, Debug)]
pub struct Spheres {
    /// What people call them.
    pub name: String,
    /// Centres.
    pub centers: Vec<[f32; 3]>,
    /// Radii: one of each sphere, or a single one for all.
    pub radii: Vec<f32>,
    /// Colour of each sphere, linear RGB: what its material's diffuse colour is multiplied by. May be empty (white).
    pub colors: Vec<[f32; 3]>,
    /// Index of each sphere's material. Empty (all have [`material`](Self::material)), or as long as `centers`.
    pub materials: Vec<u32>,
    /// Index of the material of all spheres, where `materials` is empty.
    pub material: u32,
}

impl Default for Spheres {
    fn default() -> Self {
        Self {
            name: String::new(),
            centers: Vec::new(),
            radii: Vec::new(),
            colors: Vec::new(),
            materials: Vec::new(),
            material: DEFAULT_MATERIAL,
        }
    }
}

/// What is counted of spheres.
const SPHERES: Item = Item::primitives("spheres", "sphere", "spheres");
const NOT_FINITE: Item =
    Item::left_out("non_finite_spheres", "sphere that is not finite", "spheres that are not finite");
const WITHOUT_RADIUS: Item =
    Item::left_out("spheres_without_radius", "sphere without a radius", "spheres without a radius");
const BAD_RADIUS: Item = Item::left_out(
    "degenerate_spheres",
    "sphere with a radius below 1e-18 or above 9e18",
    "spheres with a radius below 1e-18 or above 9e18",
);

impl Spheres {
    /// Two spheres that meet, each of a colour of its own.
    pub fn example(material: u32) -> Self {
        Self {
            name: "two spheres".to_owned(),
            centers: vec![[-0.3, 0.0, 0.0], [0.4, 0.2, 0.1]],
            radii: vec![0.6, 0.45],
            colors: vec![[0.9, 0.5, 0.3], [0.3, 0.6, 0.9]],
            material,
            ..Self::default()
        }
    }

    /// Centre and radius of sphere `i`; `None` if it has none.
    #[inline]
    pub fn sphere(&self, i: usize) -> Option<(Vec3, f32)> {
        let center = *self.centers.get(i)?;
        let radius = if self.radii.len() == 1 { self.radii[0] } else { *self.radii.get(i)? };
        Some((center.into(), radius))
    }

    /// Index of the material of sphere `i`.
    #[inline]
    pub fn material_of(&self, i: usize) -> u32 {
        self.materials.get(i).copied().unwrap_or(self.material)
    }

    /// Centre and radius of sphere `i`, or why it is left out.
    fn checked(&self, i: usize) -> Result<(Vec3, f32), Item> {
        let (center, radius) = self.sphere(i).ok_or(WITHOUT_RADIUS)?;
        let ends_finite = (center.abs() + radius).is_finite();
        match () {
            () if !(radius.is_finite() && ends_finite) => Err(NOT_FINITE),
            () if !RADII.contains(&radius) => Err(BAD_RADIUS),
            () => Ok((center, radius)),
        }
    }
}

impl InTree for Spheres {
    type Leaf = SphereBlock;

    fn primitive(&self, i: usize) -> Option<[f32; 4]> {
        self.checked(i).ok().map(|(center, radius)| center.extend(radius).to_array())
    }
}

impl Geometry for Spheres {
    fn name(&self) -> &str {
        &self.name
    }

    fn primitives(&self) -> usize {
        self.centers.len()
    }

    fn census(&self) -> Census {
        let mut census = Census::default();
        census.add(SPHERES, self.centers.len() as u64);
        for i in 0..self.centers.len() {
            match self.checked(i) {
                Ok((center, radius)) => census.include(center, radius),
                Err(reason) => census.add(reason, 1),
            }
        }
        census
    }

    /// The six ends of each sphere.
    fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        self.some_extremes(1, visit);
    }

    fn some_extremes(&self, step: usize, visit: &mut dyn FnMut(Vec3)) {
        for (center, radius) in draw(self.centers.len(), step).filter_map(|i| self.checked(i).ok()) {
            for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
                visit(center + axis * radius);
                visit(center - axis * radius);
            }
        }
    }

    fn materials(&self, primitives: &[u32], out: &mut [u32]) -> Option<u32> {
        if self.materials.is_empty() {
            return Some(self.material);
        }
        for (out, &primitive) in out.iter_mut().zip(primitives) {
            *out = self.material_of(primitive as usize);
        }
        None
    }

    fn shift_materials(mut self: Arc<Self>, shift: u32) -> Arc<dyn Geometry> {
        let spheres = Arc::make_mut(&mut self);
        shift_material(&mut spheres.material, shift);
        spheres.materials.iter_mut().for_each(|index| shift_material(index, shift));
        self
    }

    fn structure(&self, members: &[Arc<dyn Geometry>], build: &Build) -> Box<dyn Structure> {
        Box::new(Tree::<Self>::build(members, build))
    }
}

impl Surface for Spheres {
    /// Outwards.
    fn geometric_normals(&self, hits: &Hits<'_>, out: [&mut [f32]; 3], error_scales: &mut [f32]) {
        ball::normals(hits, out, error_scales, |k| self.sphere(k));
    }

    /// Longitude and latitude, 0..1, around y.
    fn texture_coordinates(&self, hits: &Hits<'_>, out: [&mut [f32]; 3]) {
        ball::texture_coordinates(hits, out, |k| self.sphere(k));
    }

    /// Eastwards and northwards around y.
    fn derivatives(&self, hits: &Hits<'_>, out: [[&mut [f32]; 3]; 2]) {
        ball::derivatives(hits, out, |k| self.sphere(k));
    }

    fn colors(&self, hits: &Hits<'_>, mut out: [&mut [f32]; 3]) -> bool {
        if self.colors.is_empty() {
            return false;
        }
        for (i, &k) in hits.primitives.iter().enumerate() {
            set_vec3(&mut out, i, self.colors.get(k as usize).map_or(Vec3::ONE, |&color| color.into()));
        }
        true
    }
}

#[cfg(test)]
mod tests {
    use mobula_core::simd::AnyToken;

    use super::*;
    use crate::packet::{columns3, part_mut, vec3};

    #[test]
    fn spheres_have_normals_and_longitudes() {
        let spheres = Spheres { centers: vec![[1.0, 0.0, 0.0]], radii: vec![2.0], ..Spheres::default() };
        let hits = Hits {
            token: AnyToken::detect(),
            origins: [&[10.0], &[0.0], &[0.0]],
            directions: [&[-1.0], &[0.0], &[0.0]],
            t: &[7.0],
            primitives: &[0],
        };
        let (mut out, mut second) = (columns3(1), columns3(1));
        let mut scale = [0.0];
        spheres.geometric_normals(&hits, part_mut(&mut out, 0..1), &mut scale);
        assert_eq!((vec3(&out, 0), scale), (Vec3::X, [2.0]));
        spheres.texture_coordinates(&hits, part_mut(&mut out, 0..1));
        assert_eq!(vec3(&out, 0), Vec3::new(0.5, 0.5, 0.0));
        spheres.derivatives(&hits, [part_mut(&mut out, 0..1), part_mut(&mut second, 0..1)]);
        assert!(
            vec3(&out, 0).normalize().dot(Vec3::NEG_Z) > 0.999 && vec3(&second, 0).normalize().dot(Vec3::Y) > 0.999
        );
        assert!(!spheres.colors(&hits, part_mut(&mut out, 0..1)), "there are none");
    }

    #[test]
    fn bad_spheres_are_counted_and_left_out() {
        let spheres = Spheres {
            centers: vec![[0.0; 3], [5.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [0.0; 3], [0.0; 3]],
            radii: vec![-1.0, 1.0, 1.0, f32::NAN],
            ..Spheres::default()
        };
        let census = spheres.census();
        let keys = ["spheres", "degenerate_spheres", "non_finite_spheres", "spheres_without_radius"];
        assert_eq!(keys.map(|key| census.count(key)), [5, 1, 2, 1]);
        assert_eq!(census.bounds, (Vec3::new(4.0, -1.0, -1.0), Vec3::new(6.0, 1.0, 1.0)));
        assert_eq!((0..5).filter(|&i| spheres.primitive(i).is_some()).collect::<Vec<_>>(), [1]);
    }
}
