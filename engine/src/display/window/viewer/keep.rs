//! What is shown, kept: as a picture, as a scene file, and as the options that make the same picture again.

use std::io::Write;
use std::path::PathBuf;

use glam::Vec3;

use super::Viewer;
use crate::app::Chosen;
use crate::camera::View;
use crate::display::window::engine::Engine;
use crate::display::window::news::{Titles, tell};
use crate::display::window::screen::{Same, Screenshot};
use crate::image::Size;
use crate::load::Changes;
use crate::output;
use crate::scene::{Rendering, Time};
use crate::tone::Tone;

impl Viewer {
    /// Writes what is shown as a scene file.
    pub(super) fn save(&mut self) {
        let Some(engine) = &self.engine else { return };
        let Some(text) = engine.saved(self.size, self.screen.lock().samples) else {
            self.warn(
                "no scene file can say what is shown: it comes from standard input, or from a scene file and others",
            );
            return;
        };
        let number = (1_u32..).find(|number| !saved_name(*number).exists()).unwrap_or(0);
        let file = saved_name(number);
        match output::write(&file, |mut handle| handle.write_all(text.as_bytes())) {
            Ok(()) => {
                let file = file.display();
                tell(format_args!("mobula: wrote {file}; the same picture: mobula render {file}"));
                self.say(&format!("wrote {file}"));
            }
            Err(error) => self.warn(&format!("{}: cannot be written: {error}", file.display())),
        }
    }

    /// Writes the next picture: earlier input may still be on its way.
    pub(super) fn take_screenshot(&mut self) {
        let Some(engine) = &self.engine else { return };
        let file = loop {
            self.screenshots += 1;
            let file = PathBuf::from(format!("mobula-{:04}.png", self.screenshots));
            if !file.exists() {
                break file;
            }
        };
        let (screen, same) = (self.screen.clone(), engine.same(self.size));
        engine.handle.at_barrier("screenshot", move |point| {
            point.request_frame();
            screen.want(Screenshot { frame: point.frame, file, same });
        });
    }
}

impl Engine {
    /// What is shown as a scene file, with so many samples; `None` if there can be none.
    fn saved(&self, size: Size, samples: u32) -> Option<String> {
        let saved = self.titles.saved.as_ref()?;
        let Chosen { view: View { eye, at, up, fov }, camera, lens, renderer, sampler, shadows, occlusion, tone } =
            self.chosen;
        let time = self.volumes.step().map(|shown| Time { step: None, repeat: true, shown });
        let rendering = Rendering {
            size: Some(size),
            camera: Some(camera),
            aperture: lens.aperture,
            focus: lens.focus,
            eye: Some(eye),
            at: Some(at),
            up: Some(up),
            fov: Some(fov),
            renderer: Some(renderer),
            sampler: Some(sampler.after(samples)),
            shadows: Some(shadows),
            tone: Some(tone.curve),
            exposure: Some(tone.exposure),
            occlusion: Some(occlusion.unwrap_or(0.0)),
            time,
        };
        Some(saved.text(&rendering, self.axis, &self.changes()))
    }

    /// What was changed of how volumes and particles are shown.
    fn changes(&self) -> Changes {
        let mut changes = self.volumes.changes();
        self.particles.tell(&mut changes);
        changes
    }

    /// What makes the picture that was asked for last, for people.
    fn same(&self, size: Size) -> Same {
        // Options do not change what a scene file says volumes and particles are shown as.
        if self.titles.of_file && self.changes() != Changes::default() {
            let before = "for a scene file that makes the same, press v".to_owned();
            return Same { before, sampler: None, behind: String::new() };
        }
        self.options(size)
    }

    /// The scene and the options with which `mobula render` makes it.
    fn options(&self, size: Size) -> Same {
        let Chosen { view: View { eye, at, fov, .. }, camera, lens, renderer, sampler, shadows, occlusion, tone } =
            self.chosen;
        let shadows = if shadows { "" } else { " --no-shadows" };
        let Titles { scene, place, .. } = &self.titles;
        let occlusion = match occlusion {
            Some(reach) => format!(" --ao={}", f64::from(reach) / place.scale),
            // What the file says is not meant any more.
            None if self.titles.of_file => " --ao=0".to_owned(),
            None => String::new(),
        };
        let gap = if scene.is_empty() { "" } else { " " };
        let tone = match (tone, Tone::default()) {
            (same, usual) if same == usual && !self.titles.of_file => String::new(),
            (Tone { curve, exposure }, _) => format!(" --tone {curve} --exposure {exposure}"),
        };
        // A scene file says what volumes are shown as: what was changed of that is written with it.
        let volumes = match self.titles.of_file {
            true => self.volumes.step().map(|step| format!(" --step {step}")).unwrap_or_default(),
            false => self.particles.options(self.titles.quoted) + &self.volumes.options(self.titles.quoted),
        };
        let point = |point: Vec3| place.back(point.into()).map(|x| x.to_string()).join(",");
        let (eye, at) = (point(eye), point(at));
        let length = |name: &str, length: Option<f32>| {
            length.map_or_else(String::new, |length| format!(" --{name} {}", f64::from(length) / place.scale))
        };
        let lens = length("aperture", lens.aperture) + &length("focus", lens.focus);
        let before = format!(
            "the same picture: mobula render {scene}{gap}--size {size} --eye {eye} --at {at} --fov {fov} --camera {camera}{lens} --renderer {renderer} --sampler "
        );
        Same { before, sampler: Some(sampler), behind: format!("{shadows}{occlusion}{tone}{volumes}") }
    }
}

/// What a scene file with a number is called.
fn saved_name(number: u32) -> PathBuf {
    PathBuf::from(format!("mobula-{number:04}.toml"))
}
