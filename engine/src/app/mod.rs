//! From a scene description to a pipeline that renders it: what the command uses, and programs that embed Mobula.
//!
//! The packet width is a constant below the pixel sampler and a number above it; [`Stack`] is the border.
//!
//! ```
//! use mobula::app::{self, Settings};
//! use mobula::image::Size;
//! use mobula::pipeline::{Display, DisplayStage, Picture, Shown};
//!
//! struct Brightest;
//!
//! impl Display for Brightest {
//!     fn name(&self) -> &str {
//!         "brightest pixel"
//!     }
//!     fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn std::error::Error + Send + Sync>> {
//!         println!("frame {}: {:?}", picture.frame, picture.buffer.pixels().max());
//!         Ok(Shown::Continue)
//!     }
//! }
//!
//! let scene = mobula::generate::generate("gen:terr20k").unwrap();
//! let settings = Settings { size: Size::new(32, 24)?, threads: 2, ..Settings::default() };
//! let mut pipeline = app::pipeline(&scene, &settings)?;
//! pipeline.add_stage(DisplayStage::new().with(0, Brightest));
//!
//! // Any thread may change the state at any time; it happens between two frames.
//! pipeline.handle().send("no shadows", |state: &mut app::State| {
//!     let chosen = app::Chosen { shadows: false, ..*state.chosen() };
//!     state.choose(chosen);
//! });
//! let report = pipeline.run(3)?;
//! assert_eq!(report.frames, 3);
//! assert_eq!(pipeline.state().rays().primary, 3 * 32 * 24);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod components;
mod state;
mod width;

pub use components::{Components, Stack};
pub use state::{Chosen, RayCounts, RenderFrames, State};
pub use width::{PacketWidth, UnknownWidth};

use std::sync::Arc;

use mobula_simd::AnyToken;

use crate::accel::AccelerationKind;
use crate::balance::BalancerKind;
use crate::camera::View;
use crate::image::Size;
use crate::pipeline::{Config, Pipeline, ThreadCountError};
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::scene::{Geometry, Scene, SceneDescription, SceneError};
use crate::traverse::{TileSize, TraverserKind};
use crate::with_packet_width;

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
            renderer: RendererKind::Raytracer,
            sampler: SamplerKind::default(),
            traverser: TraverserKind::default(),
            balancer: BalancerKind::default(),
            acceleration: AccelerationKind::Bvh,
            shadows: true,
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
/// If the scene has more primitives than there are ids, or the settings more threads than there may be.
pub fn pipeline(scene: &SceneDescription, settings: &Settings) -> Result<Pipeline<State>, AppError> {
    let geometry = Arc::new(Geometry::new(&scene.objects)?);
    pipeline_with_geometry(scene, geometry, settings)
}

/// As [`pipeline`], with the geometry of the same scene.
///
/// # Errors
/// If the settings have more threads than there may be.
pub fn pipeline_with_geometry(
    scene: &SceneDescription,
    geometry: Arc<Geometry>,
    settings: &Settings,
) -> Result<Pipeline<State>, AppError> {
    let size = settings.size;
    let aspect = size.width() as f32 / size.height() as f32;
    let stack: Box<dyn Stack> = with_packet_width!(settings.packet, N => {
        let scene = Scene::<N>::with_geometry(scene, geometry, settings.acceleration);
        Box::new(Components::new(settings.token, scene, aspect))
    });
    let chosen = Chosen {
        view: settings.view.unwrap_or_else(|| stack.default_view(aspect)),
        renderer: settings.renderer,
        sampler: settings.sampler,
        shadows: settings.shadows,
    };
    let traverser = settings.traverser.build(TileSize::default(), settings.balancer);
    let state = State::new(stack, traverser, chosen);
    let config = Config { on_demand: settings.on_demand, ..Config::with_threads(settings.threads) };
    let mut pipeline = Pipeline::new(state, config)?;
    pipeline.add_channel("main", size);
    pipeline.add_stage(RenderFrames);
    Ok(pipeline)
}
