//! Building and refitting with one and two threads: bare trees, and scenes as the engine makes them ready.

use std::sync::Arc;

use mobula::accel::AccelerationKind;
use mobula::scene::{self, Mesh, SceneDescription};
use mobula_benches::clock;
use mobula_benches::embree::{Device, Quality, Scene};
use mobula_benches::packets::Threads;
use mobula_benches::report::Build;
use mobula_benches::scenes::{Primitives, Triangles};
use mobula_core::bvh::{self, Bvh};
use mobula_core::cloud::Cloud;
use mobula_core::leaf::TriangleBlock;
use mobula_core::simd::Level;

use crate::isa;

/// Both qualities of Mobula's trees, by the names of their builders.
const BUILDERS: [(&str, bvh::Quality); 2] = [("Mobula fast", bvh::Quality::Fast), ("Mobula", bvh::Quality::Good)];

/// Both structures of the engine, by the names of their rows.
const ENGINE: [(&str, AccelerationKind); 2] =
    [("engine fast", AccelerationKind::Fast), ("engine", AccelerationKind::Bvh)];

/// Measures Mobula and Embree, turn by turn.
pub(crate) fn builds(
    scene: &'static str,
    primitives: &Primitives,
    level: Level,
    repeat: usize,
) -> Result<Vec<Build>, String> {
    let count = primitives.len();
    let turns = if count > 5_000_000 { 1 } else { repeat.clamp(1, 5) };
    let mut table = Builders { scene, primitives: count, shape: primitives.shape(), rows: Vec::new() };
    for _ in 0..turns {
        for threads in [1, 2] {
            table.least("compute loop", threads, || spin(threads));
            match primitives {
                Primitives::Triangles(triangles) => {
                    table.meshes(triangles, threads)?;
                    table.scenes(triangles, threads)?;
                }
                Primitives::Spheres(spheres) => table.clouds(spheres, threads)?,
            }
            table.embree(primitives, level, threads)?;
        }
    }
    for row in &table.rows {
        eprintln!("{scene:<11} build {:<14} {:.4} s, two threads {:.4} s", row.builder, row.one_wall, row.two_wall);
    }
    Ok(table.rows)
}

/// Rows of the table of builds: the least of all turns.
struct Builders {
    scene: &'static str,
    primitives: usize,
    shape: &'static str,
    rows: Vec<Build>,
}

impl Builders {
    /// Builds trees of triangles, and refits one.
    fn meshes(&mut self, triangles: &Triangles, threads: usize) -> Result<(), String> {
        let (count, join) = (self.primitives, Threads::new(threads));
        let corners = |i: usize| triangles.corners(i);
        for (name, quality) in BUILDERS {
            let mut tree = None;
            let build = || tree = Some(join.enter(|| Bvh::<TriangleBlock>::build(count, 0, quality, &join, corners)));
            self.least(name, threads, build);
            let mut tree = tree.ok_or("no tree")?;
            self.bytes(name, tree.bytes());
            if quality == bvh::Quality::Good {
                let bounds = tree.bounds();
                self.least("Mobula refit", threads, || join.enter(|| tree.refit(&join, corners)));
                self.bytes("Mobula refit", tree.bytes());
                if tree.bounds().low[..3] != bounds.low[..3] || tree.bounds().high[..3] != bounds.high[..3] {
                    return Err(format!("{}: a refit changes bounds", self.scene));
                }
            }
        }
        Ok(())
    }

    /// Builds scenes from their description, with all that the engine does until rays can be traced, and refits one.
    fn scenes(&mut self, triangles: &Triangles, threads: usize) -> Result<(), String> {
        let join = Threads::new(threads);
        let corners = triangles.positions.len() - 1;
        let positions = triangles.positions[..corners].to_vec();
        let mesh = Mesh { positions, triangles: triangles.indices.clone(), ..Mesh::default() };
        let again = Arc::new(mesh.clone());
        let description = SceneDescription { geometry: vec![Arc::new(mesh)], ..SceneDescription::default() };
        for (name, kind) in ENGINE {
            let mut scene = None;
            self.least(name, threads, || scene = Some(join.enter(|| scene::build(&description, kind))));
            let geometry = &mut scene.ok_or("no scene")?.map_err(|error| error.to_string())?.geometry;
            self.bytes(name, geometry.bytes());
            if geometry.census().count("triangles") != self.primitives as u64 || geometry.census().left_out() > 0 {
                return Err(format!("{}: the engine leaves triangles out", self.scene));
            }
            if kind == AccelerationKind::Bvh {
                let mut refitted = Ok(());
                self.least("engine refit", threads, || {
                    refitted = join.enter(|| geometry.refit(vec![again.clone()]));
                });
                refitted.map_err(|error| error.to_string())?;
                self.bytes("engine refit", geometry.bytes());
            }
        }
        Ok(())
    }

    /// Builds clouds of spheres, without attributes.
    fn clouds(&mut self, spheres: &[[f32; 4]], threads: usize) -> Result<(), String> {
        let (count, join) = (self.primitives, Threads::new(threads));
        for (name, quality) in BUILDERS {
            let mut cloud = None;
            let build = || cloud = Some(join.enter(|| Cloud::build(count, quality, &join, |i| spheres[i], Vec::new())));
            self.least(name, threads, build);
            let cloud = cloud.ok_or("no cloud")?;
            if cloud.len() != count {
                return Err(format!("{}: a cloud of {} spheres", self.scene, cloud.len()));
            }
            self.bytes(name, cloud.bytes());
        }
        Ok(())
    }

    /// Lets Embree build; what we refit, it refits.
    fn embree(&mut self, primitives: &Primitives, level: Level, threads: usize) -> Result<(), String> {
        // One device at a time: they share their threads, and the later one decides how many.
        let device = Device::new(isa(level), threads)?;
        for quality in [Quality::Low, Quality::Medium, Quality::High, Quality::Refit] {
            let too_long = quality == Quality::High && self.primitives > 2_000_000;
            let alone = quality == Quality::Refit && matches!(primitives, Primitives::Spheres(_));
            if too_long || alone {
                continue;
            }
            let name = format!("Embree {}", quality.name());
            let mut scene = None;
            let mut build = || scene = Some(Scene::new(&device, primitives, quality));
            if quality == Quality::Refit {
                build();
                let mut scene = scene.ok_or("no scene")??;
                scene.refit();
                self.least(&name, threads, || scene.refit());
                self.bytes(&name, scene.bytes());
            } else {
                self.least(&name, threads, build);
                self.bytes(&name, scene.ok_or("no scene")??.bytes());
            }
        }
        Ok(())
    }

    fn row(&mut self, builder: &str) -> &mut Build {
        let at = self.rows.iter().position(|row| row.builder == builder).unwrap_or_else(|| {
            self.rows.push(Build {
                scene: self.scene.into(),
                primitives: self.primitives,
                shape: self.shape,
                builder: builder.into(),
                one: f64::INFINITY,
                one_wall: f64::INFINITY,
                two_wall: f64::INFINITY,
                bytes: 0,
            });
            self.rows.len() - 1
        });
        &mut self.rows[at]
    }

    fn least(&mut self, builder: &str, threads: usize, work: impl FnOnce()) {
        let ((), time) = clock::time(work);
        let row = self.row(builder);
        if threads == 1 {
            row.one = row.one.min(time.process);
            row.one_wall = row.one_wall.min(time.wall);
        } else {
            row.two_wall = row.two_wall.min(time.wall);
        }
    }

    fn bytes(&mut self, builder: &str, bytes: usize) {
        self.row(builder).bytes = bytes;
    }
}

/// The same work for one thread or two: what the machine itself gains from the second.
fn spin(threads: usize) {
    let run = |share: u64| {
        let mut x = [1.0f64, 2.0, 3.0, 4.0];
        for i in 0..share {
            x.iter_mut().for_each(|x| *x = *x * 0.999 + i as f64 * 1e-9);
        }
        std::hint::black_box(x);
    };
    let share = 8_000_000 / threads as u64;
    std::thread::scope(|scope| {
        (1..threads).for_each(|_| drop(scope.spawn(move || run(share))));
        run(share);
    });
}
