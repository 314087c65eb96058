//! How a scene is to be rendered, as far as it says so: whoever renders it may choose otherwise.

use glam::Vec3;

use crate::camera::CameraKind;
use crate::image::Size;
use crate::renderer::RendererKind;
use crate::sampler::SamplerKind;
use crate::tone::Curve;
use crate::view::View;

/// How a scene is to be rendered. What is `None` is left to whoever renders it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rendering {
    /// Size of the picture.
    pub size: Option<Size>,
    /// The camera.
    pub camera: Option<CameraKind>,
    /// The radius of its lens.
    pub aperture: Option<f32>,
    /// The distance of what is in focus.
    pub focus: Option<f32>,
    /// Where the eye is.
    pub eye: Option<Vec3>,
    /// What it looks at.
    pub at: Option<Vec3>,
    /// Which way is up in the picture.
    pub up: Option<Vec3>,
    /// Vertical field of view, degrees.
    pub fov: Option<f32>,
    /// The renderer.
    pub renderer: Option<RendererKind>,
    /// The pixel sampler.
    pub sampler: Option<SamplerKind>,
    /// Are there shadows?
    pub shadows: Option<bool>,
    /// How far is it looked for what keeps ambient light away? 0: it is not.
    pub occlusion: Option<f32>,
    /// What becomes of light that is brighter than a screen.
    pub tone: Option<Curve>,
    /// What light is multiplied with before, as a power of 2.
    pub exposure: Option<f32>,
    /// How time goes on.
    pub time: Option<Time>,
}

/// How time goes on, for scenes with several steps of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Time {
    /// Seconds from one step to the next, where it was said.
    pub step: Option<f64>,
    /// Does the first step follow the last? Else time ends there.
    pub repeat: bool,
    /// The step that is shown first, from 0.
    pub shown: usize,
}

impl Rendering {
    /// Where to look from, with what is not said as in `usual`.
    pub fn view(&self, usual: View) -> View {
        View {
            eye: self.eye.unwrap_or(usual.eye),
            at: self.at.unwrap_or(usual.at),
            up: self.up.unwrap_or(usual.up),
            fov: self.fov.unwrap_or(usual.fov),
        }
    }

    /// Takes from `other` what this does not say.
    pub(super) fn merge(&mut self, other: Self) {
        let Self {
            size,
            camera,
            aperture,
            focus,
            eye,
            at,
            up,
            fov,
            renderer,
            sampler,
            shadows,
            occlusion,
            tone,
            exposure,
            time,
        } = other;
        self.size = self.size.or(size);
        self.camera = self.camera.or(camera);
        self.aperture = self.aperture.or(aperture);
        self.focus = self.focus.or(focus);
        self.eye = self.eye.or(eye);
        self.at = self.at.or(at);
        self.up = self.up.or(up);
        self.fov = self.fov.or(fov);
        self.renderer = self.renderer.or(renderer);
        self.sampler = self.sampler.or(sampler);
        self.shadows = self.shadows.or(shadows);
        self.occlusion = self.occlusion.or(occlusion);
        self.tone = self.tone.or(tone);
        self.exposure = self.exposure.or(exposure);
        self.time = self.time.or(time);
    }
}
