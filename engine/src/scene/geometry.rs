//! All primitives of a scene under scene-wide ids, with their bounds; knows neither packet width nor acceleration.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;

use super::{Mesh, Object, Spheres};

/// A scene cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SceneError {
    /// More primitives than there are ids.
    TooManyPrimitives,
}

impl std::fmt::Display for SceneError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::TooManyPrimitives => write!(f, "the scene has 2^32 - 1 primitives or more: more than there are ids"),
        }
    }
}

impl std::error::Error for SceneError {}

/// What was found in a scene's objects, and what had to be left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct GeometryReport {
    /// Triangles, those left out included.
    pub triangles: u64,
    /// Spheres, those left out included.
    pub spheres: u64,
    /// Triangles left out because they have no area.
    pub degenerate: u64,
    /// Triangles and spheres left out because a coordinate or radius is not a finite number.
    pub not_finite: u64,
    /// Triangles left out because a corner has no position, and spheres without a radius.
    pub out_of_range: u64,
    /// Spheres left out because their radius is not above 0.
    pub bad_radius: u64,
}

impl GeometryReport {
    /// How many primitives were left out.
    pub fn left_out(&self) -> u64 {
        self.degenerate + self.not_finite + self.out_of_range + self.bad_radius
    }
}

/// One object under its ids: the primitives `first..first + count`.
#[derive(Clone, Debug)]
pub struct Part {
    /// Id of its first primitive.
    pub first: u32,
    /// How many ids it has.
    pub count: u32,
    /// What it is.
    pub shape: Shape,
}

/// Primitives of one kind.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Triangles.
    Mesh(Arc<Mesh>),
    /// Spheres.
    Spheres(Arc<Spheres>),
}

/// All primitives of a scene. Each object has a range of ids: first the meshes, in the order of the description, then
/// the spheres. A primitive that is left out keeps its id, which nothing then hits.
#[derive(Clone, Debug)]
pub struct Geometry {
    parts: Vec<Part>,
    /// How many of the ids are triangles'.
    triangles: u32,
    /// How many ids there are.
    count: u32,
    bounds: (Vec3, Vec3),
    report: GeometryReport,
    has_colors: bool,
}

/// Why a primitive is left out.
enum Fault {
    Degenerate,
    NotFinite,
    OutOfRange,
    BadRadius,
}

impl Geometry {
    /// Gives ids to the primitives of `objects`, checks each, and measures their bounds.
    pub fn new(objects: &[Object]) -> Result<Self, SceneError> {
        let mut geometry = Self {
            parts: Vec::new(),
            triangles: 0,
            count: 0,
            bounds: (Vec3::INFINITY, Vec3::NEG_INFINITY),
            report: GeometryReport::default(),
            has_colors: false,
        };
        let mut shapes = Vec::new();
        flatten(objects, &mut shapes);
        // Stable: meshes come first.
        shapes.sort_by_key(|shape| matches!(shape, Shape::Spheres(_)));
        for shape in shapes {
            geometry.add(shape)?;
        }
        let Self { parts, bounds, report, .. } = &mut geometry;
        let (low, high) = bounds;
        for part in parts.iter() {
            let faults = match &part.shape {
                Shape::Mesh(mesh) => {
                    report.triangles += u64::from(part.count);
                    let check = |i| triangle(mesh, i).map(|corners| corners.map(|p| grow(low, high, p, 0.0)));
                    (0..part.count as usize).map(check).filter_map(Result::err).collect::<Vec<_>>()
                }
                Shape::Spheres(spheres) => {
                    report.spheres += u64::from(part.count);
                    let check = |i| sphere(spheres, i).map(|(center, radius)| grow(low, high, center, radius));
                    (0..part.count as usize).map(check).filter_map(Result::err).collect()
                }
            };
            for fault in faults {
                *match fault {
                    Fault::Degenerate => &mut report.degenerate,
                    Fault::NotFinite => &mut report.not_finite,
                    Fault::OutOfRange => &mut report.out_of_range,
                    Fault::BadRadius => &mut report.bad_radius,
                } += 1;
            }
        }
        Ok(geometry)
    }

    fn add(&mut self, shape: Shape) -> Result<(), SceneError> {
        let count = match &shape {
            Shape::Mesh(mesh) => mesh.triangles.len(),
            Shape::Spheres(spheres) => spheres.centers.len(),
        };
        let first = self.count;
        let count = u32::try_from(count).map_err(|_| SceneError::TooManyPrimitives)?;
        // The last id is "no hit".
        let end = first.checked_add(count).filter(|&end| end < u32::MAX).ok_or(SceneError::TooManyPrimitives)?;
        match &shape {
            Shape::Mesh(_) => self.triangles = end,
            Shape::Spheres(spheres) => self.has_colors |= !spheres.colors.is_empty(),
        }
        self.count = end;
        if count > 0 {
            self.parts.push(Part { first, count, shape });
        }
        Ok(())
    }

    /// The objects, by rising ids.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    /// Least and greatest corner of all primitives that were not left out; `(inf, -inf)` if there are none.
    pub fn bounds(&self) -> (Vec3, Vec3) {
        self.bounds
    }

    /// What was counted and left out.
    pub fn report(&self) -> &GeometryReport {
        &self.report
    }

    /// Has any primitive a colour of its own?
    pub fn has_colors(&self) -> bool {
        self.has_colors
    }

    /// The ids of triangles.
    pub fn triangle_ids(&self) -> Range<u32> {
        0..self.triangles
    }

    /// The ids of spheres.
    pub fn sphere_ids(&self) -> Range<u32> {
        self.triangles..self.count
    }

    /// The corners of triangle `id`; `None` if it is left out.
    ///
    /// # Panics
    /// If there is no such primitive.
    pub fn triangle(&self, id: u32) -> Option<[Vec3; 3]> {
        let part = self.part(id, &mut 0);
        let Shape::Mesh(mesh) = &part.shape else { return None };
        triangle(mesh, (id - part.first) as usize).ok()
    }

    /// Centre and radius of sphere `id`; `None` if it is left out.
    ///
    /// # Panics
    /// If there is no such primitive.
    pub fn sphere(&self, id: u32) -> Option<(Vec3, f32)> {
        let part = self.part(id, &mut 0);
        let Shape::Spheres(spheres) = &part.shape else { return None };
        sphere(spheres, (id - part.first) as usize).ok()
    }

    /// Points that show how far the geometry reaches: all corners, and the six ends of each sphere.
    pub fn extremes(&self) -> impl Iterator<Item = Vec3> + '_ {
        let ends = |(center, radius): (Vec3, f32)| {
            [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(move |a| [center + a * radius, center - a * radius])
        };
        let corners = self.triangle_ids().filter_map(|id| self.triangle(id)).flatten();
        corners.chain(self.sphere_ids().filter_map(|id| self.sphere(id)).flat_map(ends))
    }

    /// The part that primitive `id` belongs to. `near` is where to look first: the part of the last one.
    ///
    /// # Panics
    /// If there is no such primitive.
    #[inline]
    pub fn part(&self, id: u32, near: &mut usize) -> &Part {
        let holds = |part: &Part| id.wrapping_sub(part.first) < part.count;
        if !self.parts.get(*near).is_some_and(holds) {
            *near = self.parts.partition_point(|part| part.first <= id) - 1;
        }
        &self.parts[*near]
    }

    /// Index of the material of primitive `id`. `near` as for [`part`](Self::part).
    #[inline]
    pub fn material(&self, id: u32, near: &mut usize) -> u32 {
        let part = self.part(id, near);
        let i = (id - part.first) as usize;
        match &part.shape {
            Shape::Mesh(mesh) => mesh.material_of(i),
            Shape::Spheres(spheres) => spheres.material_of(i),
        }
    }

    /// The colour of primitive `id`, which multiplies its material's; white unless it has one.
    #[inline]
    pub fn color(&self, id: u32, near: &mut usize) -> Vec3 {
        let part = self.part(id, near);
        match &part.shape {
            Shape::Spheres(s) => s.colors.get((id - part.first) as usize).map_or(Vec3::ONE, |&c| c.into()),
            Shape::Mesh(_) => Vec3::ONE,
        }
    }

    /// How large primitive `id` is: the longest edge (its greatest coordinate) of a triangle, the radius of a sphere.
    #[inline]
    pub fn extent(&self, id: u32, near: &mut usize) -> f32 {
        let part = self.part(id, near);
        let i = (id - part.first) as usize;
        match &part.shape {
            Shape::Mesh(mesh) => mesh
                .corners(i)
                .map_or(0.0, |[a, b, c]| (b - a).abs().max((c - a).abs()).max((c - b).abs()).max_element()),
            Shape::Spheres(spheres) => spheres.sphere(i).map_or(0.0, |(_, radius)| radius),
        }
    }
}

fn flatten(objects: &[Object], shapes: &mut Vec<Shape>) {
    for object in objects {
        match object {
            Object::Group(objects) => flatten(objects, shapes),
            Object::Mesh(mesh) => shapes.push(Shape::Mesh(mesh.clone())),
            Object::Spheres(spheres) => shapes.push(Shape::Spheres(spheres.clone())),
        }
    }
}

fn grow(low: &mut Vec3, high: &mut Vec3, point: Vec3, radius: f32) {
    *low = low.min(point - radius);
    *high = high.max(point + radius);
}

/// The corners of a triangle, unless it must be left out.
fn triangle(mesh: &Mesh, i: usize) -> Result<[Vec3; 3], Fault> {
    let corners = mesh.corners(i).ok_or(Fault::OutOfRange)?;
    if !corners.iter().all(|p| p.is_finite()) {
        return Err(Fault::NotFinite);
    }
    let [x, y, z] = normal_f64(corners);
    if x == 0.0 && y == 0.0 && z == 0.0 { Err(Fault::Degenerate) } else { Ok(corners) }
}

/// Centre and radius of a sphere, unless it must be left out.
fn sphere(spheres: &Spheres, i: usize) -> Result<(Vec3, f32), Fault> {
    let (center, radius) = spheres.sphere(i).ok_or(Fault::OutOfRange)?;
    let ends_finite = (center.abs() + radius).is_finite();
    match () {
        () if !(radius.is_finite() && ends_finite) => Err(Fault::NotFinite),
        () if radius <= 0.0 => Err(Fault::BadRadius),
        () => Ok((center, radius)),
    }
}

/// Normal of a triangle, of twice its area. In f64 neither differences nor products of f32 overflow or underflow.
pub(super) fn normal_f64([a, b, c]: [Vec3; 3]) -> [f64; 3] {
    let edge = |p: Vec3| [0, 1, 2].map(|i| f64::from(p[i]) - f64::from(a[i]));
    let (u, v) = (edge(b), edge(c));
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn object(positions: Vec<[f32; 3]>, triangles: Vec<[u32; 3]>) -> Object {
        Object::Mesh(Arc::new(Mesh { positions, triangles, material: 3, ..Mesh::default() }))
    }

    #[test]
    fn bad_primitives_are_counted_and_left_out() {
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [2.0, 0.0, 0.0], [f32::NAN, 9.0, 9.0]];
        let triangles = vec![[0, 1, 2], [0, 1, 3], [0, 0, 1], [0, 1, 4], [0, 1, 5], [0, 1, u32::MAX], [2, 1, 3]];
        let spheres = Spheres {
            centers: vec![[0.0; 3], [5.0, 0.0, 0.0], [0.0, f32::INFINITY, 0.0], [0.0; 3], [0.0; 3]],
            radii: vec![-1.0, 1.0, 1.0, f32::NAN],
            ..Spheres::default()
        };
        let group = Object::Group(vec![object(positions, triangles), Object::Spheres(Arc::new(spheres))]);
        let geometry = Geometry::new(&[group]).unwrap();
        let expected =
            GeometryReport { triangles: 7, spheres: 5, degenerate: 2, not_finite: 3, out_of_range: 3, bad_radius: 1 };
        assert_eq!(*geometry.report(), expected);
        assert_eq!(geometry.triangle_ids().filter(|&id| geometry.triangle(id).is_some()).collect::<Vec<_>>(), [0, 6]);
        assert_eq!(geometry.sphere_ids().filter(|&id| geometry.sphere(id).is_some()).collect::<Vec<_>>(), [8]);
        assert_eq!(geometry.bounds(), (Vec3::new(0.0, -1.0, -1.0), Vec3::new(6.0, 1.0, 1.0)));
    }

    #[test]
    fn ids_lead_to_their_parts() {
        let one = || object(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]; 3]);
        let empty = object(vec![], vec![]);
        let geometry = Geometry::new(&[one(), empty, Object::Group(vec![one(), one()])]).unwrap();
        let mut near = 0;
        for id in [0, 2, 3, 8, 5, 1, 6] {
            assert_eq!(geometry.part(id, &mut near).first, id / 3 * 3);
            assert_eq!(geometry.material(id, &mut near), 3);
        }
    }

    #[test]
    fn tiny_and_huge_triangles_have_area() {
        for scale in [1e-30_f32, 1.0, 1e30] {
            let positions = vec![[0.0; 3], [scale, 0.0, 0.0], [0.0, scale, scale]];
            assert_eq!(Geometry::new(&[object(positions, vec![[0, 1, 2]])]).unwrap().report().left_out(), 0);
        }
    }
}
