//! The components of the rendering stack, from the pixel sampler down.

use std::sync::Arc;

use glam::Vec3;
use mobula_core::simd::AnyToken;

use crate::accel::AccelerationKind;
use crate::balance::BalancerKind;
use crate::camera::{Camera, Pinhole, View};
use crate::image::{FrameBuffer, Size, SizeError};
use crate::packet::{Packet, PacketWidth};
use crate::pipeline::fault::{fail, scope};
use crate::pipeline::{Config, Frame, Pipeline, ThreadCountError};
use crate::renderer::{Renderer, RendererKind};
use crate::sampler::{PixelSampler, SamplerKind, look};
use crate::scene::{self, Scene, SceneDescription, SceneError};
use crate::stack::{Context, Fragment, Statistics};
use crate::tone::Tone;
use crate::traverse::{RenderStage, TileSize, TraverserKind};

/// All components of the rendering stack from the pixel sampler down. Replace any of them between frames.
pub struct Components {
    /// The level whose kernels run.
    pub token: AnyToken,
    /// Rays in a packet.
    pub width: PacketWidth,
    /// What is rendered.
    pub scene: Scene,
    /// One camera for each channel; further channels use the last one.
    pub cameras: Vec<Arc<dyn Camera>>,
    /// Turns pixels into rays.
    pub sampler: Arc<dyn PixelSampler>,
    /// Traces them.
    pub renderer: Arc<dyn Renderer>,
    /// How what arrives is shown.
    pub tone: Tone,
    /// Of how many frames samplers go on with the samples; 0: with none.
    pub frame: u32,
    /// Do pictures get [`Layers`](crate::layers::Layers), for displays that show them?
    pub layers: bool,
}

impl Components {
    /// A scene as its description says, with the default components, at the best level of this machine.
    ///
    /// # Errors
    /// If a geometry has more primitives than there are numbers.
    pub fn build(description: &SceneDescription, size: Size) -> Result<Self, SceneError> {
        let scene = scene::build(description, AccelerationKind::Bvh)?;
        Ok(Self::new(AnyToken::detect(), scene, size.width() as f32 / size.height() as f32))
    }

    /// A scene with the default components, seen as the scene says in a picture of this aspect.
    pub fn new(token: AnyToken, scene: Scene, aspect: f32) -> Self {
        let camera = Arc::new(Pinhole::new(scene.view(aspect)));
        Self {
            token,
            width: PacketWidth::best(token.level()),
            scene,
            cameras: vec![camera],
            sampler: SamplerKind::default().build(),
            renderer: RendererKind::Raytracer.build(),
            tone: Tone::default(),
            frame: 0,
            layers: false,
        }
    }

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

    /// Gives a channel a camera.
    pub fn set_camera(&mut self, channel: usize, camera: Arc<dyn Camera>) {
        let last = self.cameras.last().cloned();
        if let Some(last) = last.filter(|_| channel >= self.cameras.len()) {
            self.cameras.resize(channel + 1, last);
        }
        match self.cameras.get_mut(channel) {
            Some(place) => *place = camera,
            None => self.cameras.push(camera),
        }
    }

    /// Gives a channel a pinhole camera.
    pub fn set_view(&mut self, channel: usize, view: View) {
        self.set_camera(channel, Arc::new(Pinhole::new(view)));
    }

    /// Renders a fragment, counting its rays.
    pub fn render(&self, fragment: Fragment, out: &FrameBuffer, statistics: &Statistics) {
        self.render_with(&*self.sampler, fragment, out, statistics);
    }

    /// As [`render`](Self::render), with a pixel sampler that is not that of the stack.
    pub(super) fn render_with(
        &self,
        sampler: &dyn PixelSampler,
        fragment: Fragment,
        out: &FrameBuffer,
        statistics: &Statistics,
    ) {
        let Some(camera) = self.cameras.get(fragment.channel).or(self.cameras.last()) else { return };
        let renderer = &Named(&*self.renderer);
        let &Self { token, width, ref scene, tone, frame, .. } = self;
        let eye = camera.eye();
        let context = Context { token, width: width.rays(), scene, renderer, statistics, tone, eye, frame };
        let camera = &Named(&**camera);
        if !self.layers {
            return scope("pixel sampler", || sampler.render_fragment(&context, camera, fragment, out));
        }
        let size = out.size();
        let Some(layers) = out.with_layers() else {
            fail(SizeError::NoMemory { width: size.width(), height: size.height() })
        };
        scope("pixel sampler", || {
            sampler.render_fragment(&context, camera, fragment, out);
            // Of rays for a pixel only those of its colour are counted.
            let statistics = &Statistics::default();
            let size = [size.width() as u32, size.height() as u32];
            look(&Context { statistics, ..context }, camera, fragment, size, layers);
        });
    }
}

impl std::fmt::Debug for Components {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Components").field("width", &self.width).field("scene", &self.scene).finish_non_exhaustive()
    }
}

/// A component that runs under its name, so that a fault in it is told by that name.
struct Named<T>(T);

impl Renderer for Named<&dyn Renderer> {
    fn trace(&self, context: &Context<'_>, packet: &mut Packet) {
        scope("renderer", || self.0.trace(context, packet));
    }
}

impl Camera for Named<&dyn Camera> {
    fn make_rays(&self, context: &Context<'_>, size: [u32; 2], packet: &mut Packet) {
        scope("camera", || self.0.make_rays(context, size, packet));
    }

    fn eye(&self) -> Option<Vec3> {
        self.0.eye()
    }
}
