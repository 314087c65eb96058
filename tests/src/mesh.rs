//! Closed meshes for tests: every edge belongs to two triangles, whose corners are the same bits.

use std::collections::HashMap;

use mobula_core::glam::Vec3;

/// A closed triangle mesh.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Corner positions.
    pub vertices: Vec<Vec3>,
    /// Corners of each triangle.
    pub triangles: Vec<[usize; 3]>,
}

impl Mesh {
    /// An icosahedron whose faces are divided `levels` times in four, on the unit sphere, then dented by waves and noise as
    /// an animal is. It stays star-shaped: rays from near its middle leave it.
    pub fn lump(levels: u32, noise: f32) -> Self {
        let golden = (1.0 + 5f32.sqrt()) / 2.0;
        let mut vertices = Vec::new();
        for (a, b) in [(-1.0, -golden), (1.0, -golden), (-1.0, golden), (1.0, golden)] {
            vertices.extend([Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)]);
        }
        let mut vertices: Vec<Vec3> = vertices.into_iter().map(Vec3::normalize).collect();
        let edge = vertices[1..].iter().map(|v| v.distance(vertices[0])).fold(f32::INFINITY, f32::min) * 1.01;
        let near = |a: usize, b: usize| vertices[a].distance(vertices[b]) < edge;
        let mut triangles = Vec::new();
        for a in 0..12 {
            for b in a + 1..12 {
                triangles.extend((b + 1..12).filter(|&c| near(a, b) && near(b, c) && near(c, a)).map(|c| [a, b, c]));
            }
        }
        for _ in 0..levels {
            let mut middles = HashMap::new();
            let mut finer = Vec::with_capacity(triangles.len() * 4);
            for [a, b, c] in triangles {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q): (usize, usize)| {
                    *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                        vertices.push((vertices[p] + vertices[q]).normalize());
                        vertices.len() - 1
                    })
                });
                finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            }
            triangles = finer;
        }
        let dent = |(i, v): (usize, Vec3)| {
            let waves = 0.25 * (3.0 * v.x + 1.0).sin() * (4.0 * v.y).cos() + 0.15 * (9.0 * v.z + 2.0 * v.x).sin();
            let rough = ((i as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32;
            v * (1.0 + waves + noise * rough)
        };
        let vertices = vertices.into_iter().enumerate().map(dent).collect();
        Self { vertices, triangles }
    }

    /// A box, each face divided into `n` x `n` squares of two triangles: edges along the axes, flat leaves.
    pub fn crate_of(n: usize) -> Self {
        let mut places = HashMap::new();
        let mut mesh = Self { vertices: Vec::new(), triangles: Vec::new() };
        let mut corner = |p: [usize; 3]| {
            *places.entry(p).or_insert_with(|| {
                mesh.vertices.push(Vec3::from(p.map(|x| x as f32 / n as f32 * 2.0 - 1.0)));
                mesh.vertices.len() - 1
            })
        };
        for axis in 0..3 {
            for side in [0, n] {
                for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                    let mut at = |u: usize, v: usize| {
                        let mut p = [side; 3];
                        (p[(axis + 1) % 3], p[(axis + 2) % 3]) = (u, v);
                        corner(p)
                    };
                    let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                    mesh.triangles.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
        mesh
    }

    /// Every vertex moved.
    #[must_use]
    pub fn map(mut self, place: impl Fn(Vec3) -> Vec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = place(*v));
        self
    }

    /// The corners of triangle `i`.
    pub fn corners(&self, i: usize) -> [[f32; 3]; 3] {
        self.triangles[i].map(|v| self.vertices[v].to_array())
    }

    /// Panics unless every edge belongs to exactly two triangles.
    pub fn assert_closed(&self) {
        let mut edges: HashMap<(usize, usize), u32> = HashMap::new();
        for &[a, b, c] in &self.triangles {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                *edges.entry((p.min(q), p.max(q))).or_default() += 1;
            }
        }
        assert!(edges.values().all(|&sides| sides == 2), "the mesh is not closed");
    }
}
