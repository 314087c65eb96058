//! How a scene is rendered, and a pipeline that does.

use mobula_core::simd::AnyToken;

use super::{Chosen, Components, RenderFrames, State};
use crate::accel::AccelerationKind;
use crate::balance::BalancerKind;
use crate::camera::{CameraKind, Lens, View};
use crate::image::Size;
use crate::packet::PacketWidth;
use crate::pipeline::{Config, Pipeline, ThreadCountError};
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::scene::{self, Geometries, SceneDescription, SceneError};
use crate::tone::Tone;
use crate::traverse::{TileSize, TraverserKind};

/// How a scene is rendered.
#[derive(Clone, Debug)]
pub struct Settings {
    /// The level whose kernels run.
    pub token: AnyToken,
    /// Rays in a packet.
    pub packet: PacketWidth,
    /// Render threads.
    pub threads: usize,
    /// Size of the picture.
    pub size: Size,
    /// Where to look from; `None`: as the scene says.
    pub view: Option<View>,
    /// The camera.
    pub camera: CameraKind,
    /// Its lens, if it has one.
    pub lens: Lens,
    /// The renderer.
    pub renderer: RendererKind,
    /// The pixel sampler.
    pub sampler: SamplerKind,
    /// The image traverser.
    pub traverser: TraverserKind,
    /// The load balancer.
    pub balancer: BalancerKind,
    /// The acceleration structure.
    pub acceleration: AccelerationKind,
    /// Are there shadows?
    pub shadows: bool,
    /// How far is it looked for what keeps ambient light away; `None`: nothing does.
    pub occlusion: Option<f32>,
    /// How what arrives is shown.
    pub tone: Tone,
    /// Render only when something changed?
    pub on_demand: bool,
}

impl Default for Settings {
    fn default() -> Self {
        let token = AnyToken::detect();
        Self {
            token,
            packet: PacketWidth::best(token.level()),
            threads: Config::default().threads,
            size: Size::new(1024, 768).expect("a valid size"),
            view: None,
            camera: CameraKind::Pinhole,
            lens: Lens::default(),
            renderer: RendererKind::Raytracer,
            sampler: SamplerKind::default(),
            traverser: TraverserKind::default(),
            balancer: BalancerKind::default(),
            acceleration: AccelerationKind::Bvh,
            shadows: true,
            occlusion: None,
            tone: Tone::default(),
            on_demand: false,
        }
    }
}

/// A pipeline that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum AppError {
    /// The scene cannot be built.
    #[error("{0}")]
    Scene(#[from] SceneError),
    /// There cannot be so many threads.
    #[error(transparent)]
    Threads(#[from] ThreadCountError),
}

/// Builds a scene and a pipeline that renders it in one channel, without a display: add a
/// [`DisplayStage`](crate::pipeline::DisplayStage).
///
/// # Errors
/// If a geometry of the scene has more primitives than there are numbers, or the settings more threads than there may be.
pub fn pipeline(scene: &SceneDescription, settings: &Settings) -> Result<Pipeline<State>, AppError> {
    let geometry = Geometries::build(scene.geometry.clone(), &settings.acceleration.into())?;
    pipeline_with_geometry(scene, geometry, settings)
}

/// As [`pipeline`], with the geometry of the same scene.
///
/// # Errors
/// If the settings have more threads than there may be.
pub fn pipeline_with_geometry(
    scene: &SceneDescription,
    geometry: Geometries,
    settings: &Settings,
) -> Result<Pipeline<State>, AppError> {
    let size = settings.size;
    let aspect = size.width() as f32 / size.height() as f32;
    let mut stack = Components::new(settings.token, scene::with_geometry(scene, geometry), aspect);
    stack.width = settings.packet;
    let chosen = Chosen {
        view: settings.view.unwrap_or_else(|| stack.scene.view(aspect)),
        camera: settings.camera,
        lens: settings.lens,
        renderer: settings.renderer,
        sampler: settings.sampler,
        shadows: settings.shadows,
        occlusion: settings.occlusion,
        tone: settings.tone,
    };
    let traverser = settings.traverser.build(TileSize::default(), settings.balancer);
    let state = State::new(stack, traverser, chosen);
    let config = Config { on_demand: settings.on_demand, ..Config::with_threads(settings.threads) };
    let mut pipeline = Pipeline::new(state, config)?;
    pipeline.add_channel("main", size);
    pipeline.add_stage(RenderFrames);
    Ok(pipeline)
}
