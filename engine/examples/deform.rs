//! A sea that moves: in place by parallel callbacks, which the hierarchy is refitted to, then by a copy that a transaction
//! swaps in.

use std::error::Error;
use std::sync::Mutex;

use glam::Vec3;
use mobula::accel::AccelerationKind;
use mobula::app::Components;
use mobula::balance::BalancerKind;
use mobula::camera::View;
use mobula::image::{FrameBuffer, Size};
use mobula::pipeline::{Config, Frame, Pipeline};
use mobula::scene::{self, Mesh, Scene, SceneDescription};
use mobula::stack::{Fragment, Statistics};
use mobula::traverse::{RenderStage, TileSize, TraverserKind};
use mobula_simd::AnyToken;

/// Points along each side of the sea.
const SIDE: usize = 40;

/// The state. The rows of points are what render threads change in place: each row has a lock, so no two threads share.
struct Sea {
    rows: Vec<Mutex<Vec<[f32; 3]>>>,
    components: Components,
}

fn row(z: usize, phase: f32) -> Vec<[f32; 3]> {
    (0..SIDE).map(|x| [x as f32, (x as f32 * 0.5 + z as f32 * 0.2 + phase).sin(), z as f32]).collect()
}

/// The sea through these rows of points.
fn sea(rows: impl Iterator<Item = Vec<[f32; 3]>>) -> SceneDescription {
    let at = |x: usize, z: usize| (z * SIDE + x) as u32;
    let cells = (0..SIDE - 1).flat_map(|z| (0..SIDE - 1).map(move |x| (x, z)));
    let triangles = cells.flat_map(|(x, z)| {
        let [a, b, c, d] = [at(x, z), at(x, z + 1), at(x + 1, z + 1), at(x + 1, z)];
        [[a, b, c], [a, c, d]]
    });
    let mesh = Mesh { positions: rows.flatten().collect(), triangles: triangles.collect(), ..Mesh::default() };
    let middle = SIDE as f32 / 2.0;
    let view =
        View { eye: Vec3::new(middle, 15.0, 2.5 * middle), at: Vec3::new(middle, 0.0, middle), up: Vec3::Y, fov: 60.0 };
    let mut scene = SceneDescription { view: Some(view), ..SceneDescription::default() };
    scene.add(mesh);
    scene
}

/// Compiles it, hierarchy and all.
fn build(rows: impl Iterator<Item = Vec<[f32; 3]>>) -> Scene {
    scene::build(&sea(rows), AccelerationKind::Bvh).expect("few triangles")
}

fn main() -> Result<(), Box<dyn Error>> {
    let components = Components::new(AnyToken::detect(), build((0..SIDE).map(|z| row(z, 0.0))), 1.5);
    let rows = (0..SIDE).map(|z| Mutex::new(row(z, 0.0))).collect();
    let mut pipeline = Pipeline::new(Sea { rows, components }, Config::with_threads(2))?;
    pipeline.add_channel("main", Size::new(96, 64)?);
    let traverser = TraverserKind::Tiled.build(TileSize::default(), BalancerKind::default());
    let render = |frame: &Frame<'_, Sea>, fragment: &Fragment, out: &FrameBuffer| {
        frame.state.components.render(*fragment, out, &Statistics::default());
    };
    pipeline.add_stage(RenderStage::new(traverser, render));

    // In place: all threads move their rows, then the hierarchy follows, before the frame.
    let waves = pipeline.callbacks().parallel_animation("waves", |worker| {
        for z in worker.share(SIDE) {
            *worker.state.rows[z].lock().expect("nobody panics") = row(z, worker.frame as f32 * 0.3);
        }
    });
    let refit = pipeline.callbacks().serial_pre_render("refit", |point| {
        let Sea { rows, components } = &mut *point.state;
        let moved = sea(rows.iter().map(|row| row.lock().expect("nobody panics").clone()));
        components.scene.geometry.refit(moved.geometry).expect("the same triangles");
    });
    let mut pictures = Vec::new();
    for _ in 0..4 {
        pipeline.run(1)?;
        pictures.push(pipeline.picture(0).expect("a picture").1.to_rgba8());
    }
    assert!(pictures.windows(2).all(|pair| pair[0] != pair[1]), "the sea moves");

    // A hierarchy that followed shows what one that is built anew shows.
    pipeline.callbacks().remove(waves);
    pipeline.callbacks().remove(refit);
    pipeline.state().components.scene = build((0..SIDE).map(|z| row(z, 3.0 * 0.3)));
    pipeline.run(1)?;
    assert!(pipeline.picture(0).expect("a picture").1.to_rgba8() == pictures[3], "refitted and built anew are alike");

    // A copy: another thread builds it while frames go on with the old one, and sends it when it is ready.
    let handle = pipeline.handle();
    let builder = std::thread::spawn(move || {
        let calm = build((0..SIDE).map(|z| (0..SIDE).map(|x| [x as f32, 0.0, z as f32]).collect()));
        while handle.is_stopped() {
            std::thread::yield_now(); // between two runs changes are refused
        }
        let shown = handle.send("calm", |sea| sea.components.scene = calm).wait();
        handle.stop();
        shown
    });
    pipeline.run_until_stopped()?;
    let calm_since = builder.join().expect("it does not panic")?;
    pipeline.run(1)?;
    let (frame, picture) = pipeline.picture(0).expect("a picture");
    assert!(frame >= calm_since && pictures.iter().all(|stormy| *stormy != picture.to_rgba8()), "the sea is calm");
    println!("{} stormy frames; calm since frame {calm_since}", pictures.len());
    Ok(())
}
