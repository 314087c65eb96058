//! A mesh that changes with time: one mesh a step, all of the same triangles.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::leaf::TriangleBlock;

use super::{Census, Geometry, InTree, Mesh, Structure, Tree};
use crate::accel::Build;
use crate::packet::{Hits, Surface};

/// Meshes of the same triangles, whose corners are elsewhere at each step of time; one of them is shown. To show another, structures are
/// [refitted](super::Geometries::follow).
#[derive(Clone, Debug)]
pub struct MeshSequence {
    steps: Arc<[Arc<Mesh>]>,
    step: usize,
}

impl MeshSequence {
    /// These steps, the first of them shown. `None` if there are none, or they have not all the same number of triangles.
    pub fn new(steps: Vec<Mesh>) -> Option<Self> {
        let count = steps.first()?.triangles.len();
        let alike = steps.iter().all(|mesh| mesh.triangles.len() == count);
        alike.then(|| Self { steps: steps.into_iter().map(Arc::new).collect(), step: 0 })
    }

    /// A tetrahedron that has moved.
    pub fn example(material: u32) -> Self {
        let (first, mut second) = (Mesh::example(material), Mesh::example(material));
        second.positions.iter_mut().for_each(|position| position[1] *= 0.8);
        Self::new(vec![first, second]).expect("two of the same").at(1)
    }

    /// With this step shown; behind the last comes the first.
    pub fn at(&self, step: usize) -> Self {
        Self { steps: Arc::clone(&self.steps), step: step % self.steps.len() }
    }

    /// The mesh that is shown.
    #[inline(always)]
    pub fn mesh(&self) -> &Mesh {
        &self.steps[self.step]
    }

    /// Which step is shown, from 0.
    pub fn step(&self) -> usize {
        self.step
    }

    /// All steps.
    pub fn steps(&self) -> &[Arc<Mesh>] {
        &self.steps
    }

    /// With one material for all triangles.
    pub fn with_material(&self, material: u32) -> Self {
        self.changed(|mesh| (mesh.material, mesh.materials) = (material, Vec::new()))
    }

    /// With a change to each mesh, which is copied where somebody else has it.
    fn changed(&self, change: impl Fn(&mut Mesh)) -> Self {
        let changed = |mesh: &Arc<Mesh>| {
            let mut mesh = Arc::clone(mesh);
            change(Arc::make_mut(&mut mesh));
            mesh
        };
        Self { steps: self.steps.iter().map(changed).collect(), step: self.step }
    }
}

impl InTree for MeshSequence {
    type Leaf = TriangleBlock;

    #[inline(always)]
    fn primitive(&self, i: usize) -> Option<[[f32; 3]; 3]> {
        self.mesh().primitive(i)
    }

    #[inline(always)]
    fn sound(&self, i: usize) -> [[f32; 3]; 3] {
        self.mesh().sound(i)
    }
}

impl Geometry for MeshSequence {
    fn name(&self) -> &str {
        self.mesh().name()
    }

    fn primitives(&self) -> usize {
        self.mesh().primitives()
    }

    fn census(&self) -> Census {
        self.mesh().census()
    }

    fn counts(&self) -> Option<Census> {
        self.mesh().counts()
    }

    /// Of all steps: cameras are placed for the whole time.
    fn extremes(&self, visit: &mut dyn FnMut(Vec3)) {
        self.steps.iter().for_each(|mesh| mesh.extremes(visit));
    }

    /// Of all steps together as many as are asked for.
    fn some_extremes(&self, step: usize, visit: &mut dyn FnMut(Vec3)) {
        let step = step.saturating_mul(self.steps.len());
        self.steps.iter().for_each(|mesh| mesh.some_extremes(step, visit));
    }

    fn materials(&self, primitives: &[u32], out: &mut [u32]) -> Option<u32> {
        self.mesh().materials(primitives, out)
    }

    fn shift_materials(self: Arc<Self>, shift: u32) -> Arc<dyn Geometry> {
        let mut own = Arc::unwrap_or_clone(self);
        match Arc::get_mut(&mut own.steps) {
            Some(steps) => steps.iter_mut().for_each(|mesh| Arc::make_mut(mesh).shift_own_materials(shift)),
            None => own = own.changed(|mesh| mesh.shift_own_materials(shift)),
        }
        Arc::new(own)
    }

    fn structure(&self, members: &[Arc<dyn Geometry>], build: &Build) -> Box<dyn Structure> {
        Box::new(Tree::<Self>::build(members, build))
    }
}

impl Surface for MeshSequence {
    fn geometric_normals(&self, hits: &Hits<'_>, out: [&mut [f32]; 3], error_scales: &mut [f32]) {
        self.mesh().geometric_normals(hits, out, error_scales);
    }

    fn normals(&self, hits: &Hits<'_>, out: [&mut [f32]; 3]) -> bool {
        self.mesh().normals(hits, out)
    }

    fn texture_coordinates(&self, hits: &Hits<'_>, out: [&mut [f32]; 3]) {
        self.mesh().texture_coordinates(hits, out);
    }

    fn derivatives(&self, hits: &Hits<'_>, out: [[&mut [f32]; 3]; 2]) {
        self.mesh().derivatives(hits, out);
    }

    fn edges(&self, hits: &Hits<'_>, out: [&mut [f32]; 2]) -> bool {
        self.mesh().edges(hits, out)
    }

    fn colors(&self, hits: &Hits<'_>, out: [&mut [f32]; 3]) -> bool {
        self.mesh().colors(hits, out)
    }
}
