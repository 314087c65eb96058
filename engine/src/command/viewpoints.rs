//! Viewpoints of `mobula render`: one, several around the scene, or two eyes; all in the same balanced stage.

use std::path::{Path, PathBuf};

use mobula::app::{Settings, State};
use mobula::display::png::PngDisplay;
use mobula::pipeline::{DisplayStage, Pipeline};

use super::args::RenderOptions;
use super::failure::Failure;

/// The eyes are as far apart as this part of the distance to what they look at.
const APART: f32 = 1.0 / 30.0;

/// Adds the channels and their displays to a pipeline with one channel; returns the files to be written.
pub(crate) fn add(
    pipeline: &mut Pipeline<State>,
    settings: &Settings,
    options: &RenderOptions,
) -> Result<Vec<PathBuf>, Failure> {
    let view = pipeline.state().chosen().view;
    let png = |file: &Path| PngDisplay::new(file).only(options.frames - 1);
    let mut stage = DisplayStage::new();
    let files = if let Some(stereo) = options.stereo {
        stereo.size(settings.size).map_err(|error| Failure::Output(error.to_string()))?;
        let [left, right] = view.eyes(options.eye_distance.unwrap_or(view.distance() * APART));
        let channel = pipeline.add_channel("right eye", settings.size);
        let state = pipeline.state();
        state.choose(mobula::app::Chosen { view: left, ..*state.chosen() });
        state.stack.set_view(channel, right);
        let [left, right] = stereo.displays(png(&options.output));
        stage = stage.with(0, left).with(channel, right);
        vec![options.output.clone()]
    } else {
        let count = usize::from(options.channels);
        let files = files(&options.output, count);
        for (index, file) in files.iter().enumerate() {
            if index > 0 {
                let turn = std::f32::consts::TAU * index as f32 / count as f32;
                let channel = pipeline.add_channel(format!("viewpoint {index}"), settings.size);
                pipeline.state().stack.set_view(channel, view.orbit(turn, 0.0));
            }
            stage = stage.with(index, png(file));
        }
        files
    };
    pipeline.add_stage(stage);
    Ok(files)
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
