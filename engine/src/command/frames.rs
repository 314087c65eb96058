//! What changes from frame to frame of `mobula render`: the view goes around the scene, time goes on.

use std::path::{Path, PathBuf};

use mobula::app::{Chosen, State};
use mobula::camera::View;
use mobula::display::is_numbered;
use mobula::geometry::Particles;
use mobula::pipeline::Pipeline;
use mobula::scene::Time;

use super::say;

/// Digits of the numbers of frames in files' names.
const DIGITS: &str = "-####";

/// The name of the files of several frames: with a place for the numbers of frames, before the end.
pub(crate) fn numbered(output: &Path) -> PathBuf {
    if is_numbered(output) {
        return output.to_owned();
    }
    let mut name = output.file_stem().unwrap_or_default().to_owned();
    name.push(DIGITS);
    if let Some(end) = output.extension() {
        name.push(".");
        name.push(end);
    }
    output.with_file_name(name)
}

/// Goes once around what is looked at in so many frames, from the present view on. `eyes` are the views of all channels for one view.
pub(crate) fn turn(pipeline: &mut Pipeline<State>, frames: u64, eyes: impl Fn(View) -> Vec<View> + Send + 'static) {
    let Chosen { view, .. } = *pipeline.state().chosen();
    pipeline.callbacks().serial_animation("turntable", move |point| {
        let turn = std::f32::consts::TAU * (point.frame % frames) as f32 / frames as f32;
        // The first picture is the view itself, to the bit.
        let view = if point.frame % frames == 0 { view } else { view.orbit(turn, 0.0) };
        look(point.state, &eyes(view));
    });
}

/// Gives the channels their views.
pub(crate) fn look(state: &mut State, views: &[View]) {
    let Chosen { camera, lens, .. } = *state.chosen();
    for (channel, &view) in views.iter().enumerate() {
        if channel == 0 {
            state.choose(Chosen { view, ..*state.chosen() });
        } else {
            state.stack.set_camera(channel, camera.build(view, lens));
        }
    }
}

/// Shows steps of time with so many frames a second. A step lasts as long as the scene says, else a frame. Steps that are not in memory are
/// read before their frames.
pub(crate) fn go_on(pipeline: &mut Pipeline<State>, fps: f64, time: Option<Time>) {
    let shown = pipeline.state().volumes();
    let lasts = time.and_then(|time| time.step).unwrap_or(1.0 / fps);
    let repeats = time.is_none_or(|time| time.repeat);
    if shown.steps < 2 {
        say!("mobula: warning: --fps: there are no steps of time");
        return;
    }
    let mut now = shown.step;
    pipeline.callbacks().serial_animation("time", move |point| {
        // A little more than nothing: the quotient of two times may be less than the whole number that it is.
        let passed = (point.frame as f64 / fps / lasts + 1e-9) as u64;
        let step = shown.step.saturating_add(usize::try_from(passed).unwrap_or(usize::MAX));
        let step = if repeats { step % shown.steps } else { step.min(shown.steps - 1) };
        if step != now {
            now = step;
            read(point.state, step);
            point.state.set_step(step);
        }
    });
}

/// Reads a step of particles that is not in memory.
fn read(state: &State, step: usize) {
    let all = state.stack.scene.geometry.list().iter().filter_map(|one| one.downcast_ref::<Particles>());
    for series in all.map(Particles::series).filter(|series| series.makes_steps() && series.get(step).is_none()) {
        series.make_room(step, 0);
        if let Err(problem) = series.make(step) {
            say!("mobula: warning: {problem}");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_get_a_place_for_numbers() {
        let names = ["a/b.png", "b.c.exr", "b-##.jpg", "b"].map(|name| numbered(name.as_ref()));
        assert_eq!(names, ["a/b-####.png", "b.c-####.exr", "b-##.jpg", "b-####"].map(PathBuf::from));
    }
}
