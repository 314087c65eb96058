//! The scenes of the peer bench: triangles or spheres, where to look from, where light comes from.
//!
//! The meshes are those of the data folder beside the repository and are skipped, with a reason, where it is not; the
//! others are made by arithmetic and are the same bits everywhere.

use std::path::Path;
use std::sync::Arc;

use mobula::generate;
use mobula::geometry::{Mesh, Spheres};
use mobula::load;
use mobula::particles::ParticleStep;
use mobula::scene::SceneDescription;

use crate::rays::{cross, sub};

/// What one table row is about.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Name of the row.
    pub name: &'static str,
    /// File in the data folder, or name of a generator (`gen:...`).
    pub source: &'static str,
    /// Where the rays start.
    pub eye: [f32; 3],
    /// What is in the middle of the picture.
    pub at: [f32; 3],
    /// Which way is up.
    pub up: [f32; 3],
    /// Tangent of half the field of view.
    pub tangent: f32,
    /// Pixels a side of the picture; a multiple of 16.
    pub pixels: u32,
    /// The point light.
    pub light: [f32; 3],
    /// Direction to the directional light; of any length.
    pub sun: [f32; 3],
    /// How far occlusion rays go.
    pub reach: f32,
    /// How far secondary rays start above the surface.
    pub offset: f32,
    /// What others found there, if it is known.
    pub known: Option<Known>,
    /// What is far away.
    pub far: Far,
}

/// What is far away: a stray vertex must not cost the rest of the scene anything, nor map coordinates the whole.
#[derive(Clone, Copy, Debug)]
pub enum Far {
    /// Nothing.
    Nothing,
    /// A corner of one triangle.
    Corner([f32; 3]),
    /// The scene, from where it is in its file.
    All([f32; 3]),
}

/// Results of Embree, one ray at a time: of version 4 and another program, but for the atrium, which is our own.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Primary rays that hit.
    pub hits: usize,
    /// Sum of their distances.
    pub distances: f64,
    /// Rays to the point light that are blocked.
    pub shadowed: usize,
}

const Y: [f32; 3] = [0.0, 1.0, 0.0];
const Z: [f32; 3] = [0.0, 0.0, 1.0];

const fn known(hits: usize, distances: f64, shadowed: usize) -> Option<Known> {
    Some(Known { hits, distances, shadowed })
}

const TERRAIN: View = View {
    name: "terr1m",
    source: "gen:terr1m",
    eye: [50.0, 45.0, 5.0],
    at: [50.0, 5.0, 45.0],
    up: Y,
    tangent: 0.4,
    pixels: 1024,
    light: [25.0, 40.0, 80.0],
    sun: [-0.4, 0.7, 0.6],
    reach: 3.0,
    offset: 1e-3,
    known: known(1_048_572, 5.02151e7, 723_646),
    far: Far::Nothing,
};

/// Outside, from the garden, and the rooms inside; the file's z is up and its unit the metre.
const HOUSE: View = View {
    name: "fzk_outside",
    source: "fzk_house.obj.gz",
    eye: [-12.0, -14.0, 9.0],
    at: [6.0, 5.0, 2.0],
    up: Z,
    tangent: 0.4,
    pixels: 1024,
    light: [-10.0, -20.0, 25.0],
    sun: [-0.5, -0.6, 0.7],
    reach: 1.0,
    offset: 1e-3,
    known: None,
    far: Far::Nothing,
};

const BUNNY: View = View {
    name: "bunny",
    source: "bunny.obj.gz",
    eye: [0.6, 0.5, 3.0],
    at: [0.0, 0.0, 0.0],
    up: Y,
    tangent: 0.36,
    pixels: 1024,
    light: [3.0, 4.0, 3.0],
    sun: [0.6, 0.7, 0.4],
    reach: 0.5,
    offset: 1e-4,
    known: known(586_683, 1.60425e6, 64_868),
    far: Far::Nothing,
};

/// Upright in z, about two metres long: from the left, slightly above.
const MOTORBIKE: View = View {
    name: "motorbike",
    source: "motorbike.obj.gz",
    eye: [-0.9, -2.3, 1.3],
    at: [0.73, 0.0, 0.6],
    up: Z,
    tangent: 0.36,
    pixels: 1024,
    light: [-1.0, -2.0, 3.0],
    sun: [-0.3, -0.6, 0.8],
    reach: 0.3,
    offset: 1e-4,
    known: None,
    far: Far::Nothing,
};

/// In millimetres, 743 long.
const ENGINE: View = View {
    name: "engine2cyl",
    source: "engine2cyl.obj.gz",
    eye: [550.0, 320.0, 700.0],
    at: [0.0, -40.0, 0.0],
    up: Y,
    tangent: 0.36,
    pixels: 1024,
    light: [500.0, 800.0, 600.0],
    sun: [0.4, 0.8, 0.5],
    reach: 60.0,
    offset: 0.02,
    known: None,
    far: Far::Nothing,
};

/// In centimetres, with a texture of cloth.
const COUCH: View = View {
    name: "couch",
    source: "../models/couch/couch.obj",
    eye: [110.0, 110.0, 220.0],
    at: [0.0, 40.0, 0.0],
    up: Y,
    tangent: 0.4,
    pixels: 1024,
    light: [150.0, 300.0, 200.0],
    sun: [0.4, 0.8, 0.5],
    reach: 40.0,
    offset: 0.01,
    known: None,
    far: Far::Nothing,
};

/// In centimetres, textured all over.
const CHICKEN: View = View {
    name: "chicken",
    source: "../models/chicken/chicken.obj",
    eye: [50.0, 35.0, 60.0],
    at: [0.0, 22.0, 0.0],
    light: [60.0, 100.0, 80.0],
    reach: 10.0,
    offset: 2e-3,
    ..COUCH
};

/// Where the bunny is ten thousand times its size away from the origin.
const AWAY: [f32; 3] = [1e4, -5e3, 2e4];

/// Every row. The atrium and the house's inside are closed, so most of the sun's rays end at the ceiling there.
pub const VIEWS: [View; 23] = [
    BUNNY,
    View { name: "bunny_stray", far: Far::Corner([-1e6, 1e6, 1e6]), ..BUNNY },
    View {
        name: "bunny_moved",
        eye: [AWAY[0] + 0.6, AWAY[1] + 0.5, AWAY[2] + 3.0],
        at: AWAY,
        light: [AWAY[0] + 3.0, AWAY[1] + 4.0, AWAY[2] + 3.0],
        offset: 1e-3,
        known: None,
        far: Far::All(AWAY),
        ..BUNNY
    },
    MOTORBIKE,
    ENGINE,
    HOUSE,
    View {
        name: "fzk_inside",
        eye: [1.0, 1.0, 1.7],
        at: [6.0, 6.0, 1.2],
        tangent: 0.8,
        light: [3.0, 2.5, 2.2],
        ..HOUSE
    },
    View {
        name: "atrium",
        source: "gen:atrium",
        eye: [4.0, 5.0, 12.0],
        at: [40.0, 5.5, 12.5],
        up: Y,
        tangent: 0.7,
        pixels: 1024,
        light: [30.0, 12.0, 12.0],
        sun: [0.3, 0.9, 0.2],
        reach: 3.0,
        offset: 1e-3,
        known: known(1_048_576, 2.27840e7, 264_542),
        far: Far::Nothing,
    },
    View { name: "terr20k", source: "gen:terr20k", known: None, ..TERRAIN },
    View { name: "terr245k", source: "gen:terr245k", known: None, ..TERRAIN },
    TERRAIN,
    View { name: "terr10m", source: "gen:terr10m", known: known(1_048_568, 4.88381e7, 847_815), ..TERRAIN },
    // Grains of a hundredth of the cube, as of a simulated container.
    View {
        name: "csafe",
        source: "gen:csafe",
        eye: [1.7, 1.3, 2.4],
        at: [0.5, 0.5, 0.5],
        up: Y,
        tangent: 0.3,
        pixels: 1024,
        light: [0.5, 3.0, 2.5],
        sun: [0.3, 0.8, 0.5],
        reach: 0.05,
        offset: 1e-5,
        known: known(819_064, 1.67012e6, 462_723),
        far: Far::Nothing,
    },
    // 8.5 million atoms in a cube of 440 angstroms: a periodic box of water, tiled 4 x 4 x 4.
    View {
        name: "waterbox",
        source: "../particles/waterbox.ply.gz",
        eye: [750.0, 570.0, 1050.0],
        at: [220.0, 220.0, 220.0],
        up: Y,
        tangent: 0.3,
        pixels: 1024,
        light: [220.0, 1300.0, 1100.0],
        sun: [0.3, 0.8, 0.5],
        reach: 22.0,
        offset: 1e-2,
        known: None,
        far: Far::Nothing,
    },
    // Triangles of about a pixel and less: small pictures, models far away, and from above; and larger than ever, a crop of 4096x4096.
    View { name: "bunny_256", pixels: 256, known: None, ..BUNNY },
    View { name: "motorbike_256", pixels: 256, ..MOTORBIKE },
    View { name: "engine2cyl_256", pixels: 256, ..ENGINE },
    View { name: "terr1m_256", pixels: 256, known: None, ..TERRAIN },
    // Fifty pixels wide.
    View { name: "motorbike_far", eye: [-27.0, -36.8, 12.0], ..MOTORBIKE },
    View { name: "terr1m_above", eye: [50.0, 160.0, 50.0], at: [50.0, 0.0, 49.9], known: None, ..TERRAIN },
    View { name: "terr1m_crop", tangent: 0.1, known: None, ..TERRAIN },
    // Textured.
    COUCH,
    CHICKEN,
];

/// What a scene is made of.
#[derive(Clone, Debug)]
pub enum Primitives {
    /// A mesh.
    Triangles(Triangles),
    /// Centre and radius of each.
    Spheres(Vec<[f32; 4]>),
}

impl Primitives {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::Triangles(triangles) => triangles.indices.len(),
            Self::Spheres(spheres) => spheres.len(),
        }
    }

    /// Is there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What they are called.
    pub fn shape(&self) -> &'static str {
        match self {
            Self::Triangles(_) => "triangles",
            Self::Spheres(_) => "spheres",
        }
    }

    /// A normal of primitive `i` at a point on it, of any length.
    pub fn normal(&self, i: usize, point: [f32; 3]) -> [f32; 3] {
        match self {
            Self::Triangles(triangles) => {
                let [a, b, c] = triangles.corners(i);
                cross(sub(b, a), sub(c, a))
            }
            Self::Spheres(spheres) => {
                let [x, y, z, _] = spheres[i];
                sub(point, [x, y, z])
            }
        }
    }

    /// The triangles of a scene, or its spheres if there is none.
    pub fn of(scene: &SceneDescription) -> Self {
        let (mut triangles, mut spheres) = (Triangles::default(), Vec::new());
        for geometry in &scene.geometry {
            if let Some(mesh) = geometry.downcast_ref() {
                triangles.add(mesh);
            }
            if let Some(some) = geometry.downcast_ref::<Spheres>() {
                let sphere = |i| some.sphere(i).map(|(center, radius)| center.extend(radius).to_array());
                spheres.extend((0..some.centers.len()).filter_map(sphere));
            }
        }
        for step in scene.particles.iter().filter_map(|particles| particles.read().next()) {
            spheres.extend(tiled(step).into_iter().flat_map(|step| {
                let radius = move |i: usize| step.radii.get(i).copied().unwrap_or(1.0);
                step.centers.clone().into_iter().enumerate().map(move |(i, [x, y, z])| [x, y, z, radius(i)])
            }));
        }
        if triangles.indices.is_empty() {
            return Self::Spheres(spheres);
        }
        triangles.positions.push([0.0; 3]);
        Self::Triangles(triangles)
    }
}

/// A step of particles in a periodic box whose sides are the least that hold all centres, 4 x 4 x 4 times.
fn tiled(step: &Arc<ParticleStep>) -> Option<ParticleStep> {
    let ends = |axis: usize| {
        let along = step.centers.iter().map(|center| center[axis]);
        along.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let side = |axis: usize| ends(axis)[1] - ends(axis)[0];
    let cell = [[side(0), 0.0, 0.0], [0.0, side(1), 0.0], [0.0, 0.0, side(2)]];
    ParticleStep { cell: Some(cell), ..ParticleStep::clone(step) }.tiled([4; 3]).ok()
}

/// Indexed triangles, without anything that a bench does not need.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    /// Corners; one more than there are, because Embree reads 16 bytes at each.
    pub positions: Vec<[f32; 3]>,
    /// Three corners each.
    pub indices: Vec<[u32; 3]>,
}

impl Triangles {
    /// The corners of triangle `i`.
    #[inline(always)]
    pub fn corners(&self, i: usize) -> [[f32; 3]; 3] {
        self.indices[i].map(|corner| self.positions[corner as usize])
    }

    fn add(&mut self, mesh: &Mesh) {
        let first = self.positions.len() as u32;
        self.positions.extend(&mesh.positions);
        self.indices.extend(mesh.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
    }
}

/// The scene of a generator, or in a file.
///
/// # Errors
/// Why it is not there.
pub fn scene(source: &str, data: &Path) -> Result<SceneDescription, String> {
    if source.starts_with(generate::PREFIX) {
        return generate::generate(source).ok_or_else(|| format!("no generator {source}"));
    }
    let file = data.join(source);
    if !file.exists() {
        return Err(format!("there is no {source} in the data folder (say where with --data)"));
    }
    // With facets, as peers have them, and so that records of different dates are of the same picture.
    let options = load::Options { smooth: Some(0.0), ..load::Options::default() };
    load::load_with(&file, &options).map(|loaded| loaded.scene).map_err(|error| error.to_string())
}

/// The scene of a view, with what is far away where the view has it.
///
/// # Errors
/// Why it is not there.
pub fn seen(view: &View, data: &Path) -> Result<SceneDescription, String> {
    let mut scene = scene(view.source, data)?;
    for geometry in &mut scene.geometry {
        let Some(mesh) = geometry.downcast_ref::<Mesh>() else { continue };
        match view.far {
            Far::Nothing => {}
            Far::Corner(corner) => *geometry = Arc::new(stray(mesh.clone(), corner)),
            Far::All(by) => *geometry = Arc::new(moved(mesh.clone(), by)),
        }
    }
    Ok(scene)
}

/// Moves a corner of one triangle, not those that it shared it with.
fn stray(mut mesh: Mesh, to: [f32; 3]) -> Mesh {
    let middle = mesh.triangles.len() / 2;
    mesh.triangles[middle][0] = mesh.positions.len() as u32;
    mesh.positions.push(to);
    mesh
}

fn moved(mut mesh: Mesh, by: [f32; 3]) -> Mesh {
    mesh.positions.iter_mut().for_each(|position| (0..3).for_each(|axis| position[axis] += by[axis]));
    mesh
}

/// What a view shows: spheres, or the triangles.
///
/// # Errors
/// Why it is not there.
pub fn primitives(view: &View, data: &Path) -> Result<Primitives, String> {
    seen(view, data).map(|scene| Primitives::of(&scene))
}
