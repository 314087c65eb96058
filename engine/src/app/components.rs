//! The rendering stack with its packet width hidden: one virtual call a fragment.

use std::sync::Arc;

use mobula_simd::AnyToken;

use crate::accel::AccelerationKind;
use crate::balance::BalancerKind;
use crate::camera::{Pinhole, View};
use crate::image::{FrameBuffer, Size};
use crate::pipeline::fault::scope;
use crate::pipeline::{Config, Frame, Pipeline, ThreadCountError};
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::scene::{Scene, SceneDescription, SceneError};
use crate::stack::{Camera, Context, Fragment, PixelSampler, Renderer, Statistics};
use crate::traverse::{RenderStage, TileSize, TraverserKind};
use mobula_core::RayPacket;

/// All components of the rendering stack, for one packet width. Replace any of them between frames.
pub struct Components<const N: usize> {
    /// The level whose kernels run.
    pub token: AnyToken,
    /// What is rendered.
    pub scene: Scene<N>,
    /// One camera for each channel; further channels use the last one.
    pub cameras: Vec<Arc<dyn Camera<N>>>,
    /// Turns pixels into rays.
    pub sampler: Arc<dyn PixelSampler<N>>,
    /// Traces them.
    pub renderer: Arc<dyn Renderer<N>>,
}

impl<const N: usize> Components<N> {
    /// A scene as its description says, with the default components, at the best level of this machine.
    ///
    /// # Errors
    /// If there are more primitives than ids.
    pub fn build(scene: &SceneDescription, size: Size) -> Result<Self, SceneError> {
        let scene = Scene::build(scene, AccelerationKind::Bvh)?;
        Ok(Self::new(AnyToken::detect(), scene, size.width() as f32 / size.height() as f32))
    }

    /// A scene with the default components, seen as the scene says in a picture of this aspect.
    pub fn new(token: AnyToken, scene: Scene<N>, aspect: f32) -> Self {
        let camera = Arc::new(Pinhole::new(scene.view(aspect)));
        Self {
            token,
            scene,
            cameras: vec![camera],
            sampler: SamplerKind::default().build(),
            renderer: RendererKind::Raytracer.build(),
        }
    }
}

impl<const N: usize> Components<N> {
    /// A pipeline that renders these components in one channel, tile by tile: they are its state, and any of them may be
    /// exchanged by transaction. It has no display: add a [`DisplayStage`](crate::pipeline::DisplayStage).
    ///
    /// # Errors
    /// If there cannot be so many threads.
    pub fn pipeline(self, size: Size, config: Config) -> Result<Pipeline<Self>, ThreadCountError> {
        let mut pipeline = Pipeline::new(self, config)?;
        pipeline.add_channel("main", size);
        let traverser = TraverserKind::default().build(TileSize::default(), BalancerKind::default());
        let render = |frame: &Frame<'_, Self>, fragment: &Fragment, out: &FrameBuffer| {
            frame.state.render(*fragment, out, &Statistics::default());
        };
        pipeline.add_stage(RenderStage::new(traverser, render));
        Ok(pipeline)
    }
}

/// What the pipeline needs of a rendering stack, whatever its packet width.
pub trait Stack: Send + Sync {
    /// Rays in a packet.
    fn packet_width(&self) -> usize;

    /// The level whose kernels run.
    fn token(&self) -> AnyToken;

    /// Renders a fragment, counting its rays.
    fn render(&self, fragment: Fragment, out: &FrameBuffer, statistics: &Statistics);

    /// Gives a channel a pinhole camera.
    fn set_view(&mut self, channel: usize, view: View);

    /// Where to look from, as the scene says, for a picture of this aspect.
    fn default_view(&self, aspect: f32) -> View;

    /// Exchanges the renderer.
    fn set_renderer(&mut self, renderer: RendererKind);

    /// Exchanges the pixel sampler.
    fn set_sampler(&mut self, sampler: SamplerKind);

    /// Switches shadows.
    fn set_shadows(&mut self, shadows: bool);
}

impl<const N: usize> Stack for Components<N> {
    fn packet_width(&self) -> usize {
        N
    }

    fn token(&self) -> AnyToken {
        self.token
    }

    fn render(&self, fragment: Fragment, out: &FrameBuffer, statistics: &Statistics) {
        let Some(camera) = self.cameras.get(fragment.channel).or(self.cameras.last()) else { return };
        let renderer = Named(&*self.renderer);
        let context = Context { token: self.token, scene: &self.scene, renderer: &renderer, statistics, frame: 0 };
        scope("pixel sampler", || self.sampler.render_fragment(&context, &Named(&**camera), fragment, out));
    }

    fn set_view(&mut self, channel: usize, view: View) {
        let last = self.cameras.last().cloned();
        if let Some(last) = last.filter(|_| channel >= self.cameras.len()) {
            self.cameras.resize(channel + 1, last);
        }
        match self.cameras.get_mut(channel) {
            Some(camera) => *camera = Arc::new(Pinhole::new(view)),
            None => self.cameras.push(Arc::new(Pinhole::new(view))),
        }
    }

    fn default_view(&self, aspect: f32) -> View {
        self.scene.view(aspect)
    }

    fn set_renderer(&mut self, renderer: RendererKind) {
        self.renderer = renderer.build();
    }

    fn set_sampler(&mut self, sampler: SamplerKind) {
        self.sampler = sampler.build();
    }

    fn set_shadows(&mut self, shadows: bool) {
        self.scene.shadows = shadows;
    }
}

impl<const N: usize> std::fmt::Debug for Components<N> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Components").field("N", &N).field("scene", &self.scene).finish_non_exhaustive()
    }
}

/// A component that runs under its name, so that a fault in it is told by that name.
struct Named<T>(T);

impl<const N: usize> Renderer<N> for Named<&dyn Renderer<N>> {
    fn trace(&self, context: &Context<'_, N>, packet: &mut RayPacket<N>) {
        scope("renderer", || self.0.trace(context, packet));
    }
}

impl<const N: usize> Camera<N> for Named<&dyn Camera<N>> {
    fn make_rays(&self, context: &Context<'_, N>, size: [u32; 2], packet: &mut RayPacket<N>) {
        scope("camera", || self.0.make_rays(context, size, packet));
    }
}
