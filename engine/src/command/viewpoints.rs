//! Viewpoints of `mobula render`: one, several around the scene, or two eyes; all in the same balanced stage. And where their
//! pictures go.

use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};

use mobula::app::{Chosen, Settings, State};
use mobula::display::{PictureError, PictureFile, STANDARD_OUTPUT, is_numbered, legend};
use mobula::pipeline::{Display, DisplayStage, Picture, Pipeline};
use mobula::traverse::TraverserKind;

use super::args::RenderOptions;
use super::failure::Failure;
use super::frames;
use super::say;

/// The eyes are as far apart as this part of the distance to what they look at.
const APART: f32 = 1.0 / 30.0;

/// Where the pictures of a run go.
pub(crate) struct Outputs {
    /// One a channel, or one for both eyes.
    files: Vec<PictureFile>,
    /// What shows the last frame of each channel after the run; where every frame is written, the pipeline does.
    last: Vec<Box<dyn Display>>,
}

/// Adds the channels to a pipeline with one channel, and displays for all frames if all are to be written.
pub(crate) fn add(
    pipeline: &mut Pipeline<State>,
    settings: &Settings,
    options: &RenderOptions,
    output: &Path,
) -> Result<Outputs, Failure> {
    check(options, output)?;
    pipeline.state().stack.layers = PictureFile::new(output).format().has_layers();
    let view = pipeline.state().chosen().view;
    let mut displays: Vec<Box<dyn Display>> = Vec::new();
    let mut coloured = pipeline.state().stack.scene.geometry.list().iter().filter_map(|one| one.downcast_ref());
    let legend = options.legend.then(|| coloured.find_map(legend)).flatten();
    if options.legend && legend.is_none() {
        say!("mobula: warning: --legend: there are no particles whose colours an attribute decides about");
    }
    let files = if let Some(stereo) = options.stereo {
        stereo.size(settings.size).map_err(|error| Failure::Output(error.to_string()))?;
        let [left, right] = view.eyes(options.eye_distance.unwrap_or(view.distance() * APART));
        let channel = pipeline.add_channel("right eye", settings.size);
        let state = pipeline.state();
        state.choose(Chosen { view: left, ..*state.chosen() });
        let Chosen { camera, lens, .. } = *state.chosen();
        state.stack.set_camera(channel, camera.build(right, lens));
        let file = PictureFile::new(output).with_sheet(legend);
        displays.extend(stereo.displays(file.clone()).map(|eye| Box::new(eye) as Box<dyn Display>));
        vec![file]
    } else {
        let count = usize::from(options.channels);
        for index in 1..count {
            let turn = std::f32::consts::TAU * index as f32 / count as f32;
            let channel = pipeline.add_channel(format!("viewpoint {index}"), settings.size);
            let state = pipeline.state();
            let Chosen { camera, lens, .. } = *state.chosen();
            state.stack.set_camera(channel, camera.build(view.orbit(turn, 0.0), lens));
        }
        if let Some(frames) = options.turntable {
            frames::turn(pipeline, frames, |view| vec![view]);
        }
        let display = |file| PictureFile::new(file).with_sheet(legend.clone());
        let files: Vec<_> = files(output, count).into_iter().map(display).collect();
        displays.extend(files.iter().map(|file| Box::new(file.clone()) as Box<dyn Display>));
        files
    };
    if !is_numbered(output) {
        return Ok(Outputs { files, last: displays });
    }
    let stage = DisplayStage::new();
    displays.into_iter().enumerate().for_each(|(channel, display)| stage.attach(channel, display));
    pipeline.add_stage(stage);
    Ok(Outputs { files, last: Vec::new() })
}

/// Refuses what does not go together.
fn check(options: &RenderOptions, output: &Path) -> Result<(), Failure> {
    let format = PictureFile::new(output).format();
    let no = |text: &str| Err(Failure::Usage(text.to_owned()));
    if options.output == Path::new(STANDARD_OUTPUT) {
        if options.json {
            return no("--json, -o -: both want standard output; name a file for the picture");
        }
        if options.channels > 1 || options.turntable.is_some() {
            return no("-o -: one picture goes to standard output; name a file for several");
        }
    }
    if format.has_layers() {
        if options.stereo.is_some() {
            return no("--stereo: EXR files have layers of one view; render both with --eye, or name a PNG file");
        }
        if options.legend {
            say!("mobula: warning: --legend: EXR files hold light, which nothing is drawn over");
        }
    }
    let film = options.turntable.is_some() || options.fps.is_some();
    if film && options.scene.traverser != TraverserKind::Tiled {
        return no("--turntable, --fps: frames that differ are not refined one by the next; leave out --traverser");
    }
    Ok(())
}

impl Outputs {
    /// How many channels are rendered.
    pub(crate) fn channels(&self) -> u64 {
        self.files.len().max(self.last.len()) as u64
    }

    /// Writes what is not written yet, after so many frames; returns all files that were written.
    pub(crate) fn finish(mut self, pipeline: &mut Pipeline<State>, frames: u64) -> Result<Vec<PathBuf>, Failure> {
        for (channel, display) in self.last.iter_mut().enumerate() {
            let Some((frame, buffer)) = pipeline.picture(channel) else { continue };
            let picture = Picture { frame, channel, name: "", size: buffer.size(), buffer };
            display.show(&picture).map_err(|error| failure(&*error))?;
        }
        let numbers = if self.last.is_empty() { 0..frames } else { 0..1 };
        Ok(self.files.iter().flat_map(|file| numbers.clone().map(|frame| file.file(frame))).collect())
    }
}

/// What could not be written. That nobody reads standard output to its end is no news.
fn failure(error: &(dyn Error + 'static)) -> Failure {
    match error.downcast_ref::<PictureError>() {
        Some(PictureError { file, problem })
            if file == Path::new(STANDARD_OUTPUT) && problem.kind() == io::ErrorKind::BrokenPipe =>
        {
            Failure::NobodyReads
        }
        _ => Failure::Output(error.to_string()),
    }
}

/// The file of each of so many channels: with more than one, its number comes before the extension.
fn files(output: &Path, count: usize) -> Vec<PathBuf> {
    if count == 1 {
        return vec![output.to_owned()];
    }
    let numbered = |index: usize| {
        let mut name = output.file_stem().unwrap_or_default().to_owned();
        name.push(format!("-{index}."));
        name.push(output.extension().unwrap_or("png".as_ref()));
        output.with_file_name(name)
    };
    (0..count).map(numbered).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_have_files_of_their_own() {
        assert_eq!(files("a/b.png".as_ref(), 1), [PathBuf::from("a/b.png")]);
        assert_eq!(files("a/b.c.PNG".as_ref(), 2), ["a/b.c-0.PNG", "a/b.c-1.PNG"].map(PathBuf::from));
    }
}
