//! How a viewer changes what volumes are shown as: iso values, level and width, transfer functions, time.

use std::time::{Duration, Instant};

use super::news::{Titles, tell};
use crate::app::{State, Streamer, Volumes};
use crate::load::Changes;
use crate::medium::Volume;
use crate::pipeline::Handle;
use crate::volume::Preset;

/// Steps of time a second, at first.
const SPEED: f64 = 8.0;

/// What was asked for, which the state has or is about to have.
pub(super) struct VolumeControls {
    shown: Volumes,
    first_window: Option<[f64; 2]>,
    /// The transfer functions as the command line names them.
    transfer: Vec<String>,
    /// Whether they are lit, if the command line said so.
    shading: Option<String>,
    first_iso: Option<Vec<f64>>,
    /// Has another transfer function been chosen?
    other_transfer: bool,
    /// Does time begin anew behind its end?
    repeats: bool,
    per_second: f64,
    /// When the next step is due, while time goes on.
    due: Option<Instant>,
    /// Shows steps that are not all in memory.
    streamer: Option<Streamer>,
}

impl VolumeControls {
    /// For the volumes and particles of a state.
    pub(super) fn new(state: &State, titles: &Titles, handle: &Handle<State>) -> Self {
        let problem = |problem: &str| tell(format_args!("mobula: warning: {problem}"));
        let streamer = Streamer::start(state, handle.clone(), problem).unwrap_or_else(|error| {
            problem(&format!("steps of time that are not in memory cannot be shown: {error}"));
            None
        });
        let shown = state.volumes();
        let media = state.stack.scene.media.iter().filter_map(|medium| medium.downcast_ref::<Volume>());
        let named = media.map(|volume| volume.function().name.clone());
        Self {
            first_window: shown.window.map(|(window, _)| window),
            first_iso: shown.iso.as_ref().map(|(values, _)| values.clone()),
            shown,
            transfer: if titles.of_file { named.collect() } else { titles.transfer.clone() },
            shading: titles.shading.clone(),
            other_transfer: false,
            repeats: titles.time.is_none_or(|time| time.repeat),
            per_second: titles
                .time
                .and_then(|time| time.step)
                .map_or(SPEED, |seconds| (1.0 / seconds).clamp(1e-3, 1e3)),
            due: None,
            streamer,
        }
    }

    /// Moves iso-surfaces by so many steps, each a 128th of the range of the values.
    pub(super) fn move_iso(&mut self, steps: f64, handle: &Handle<State>) {
        let Some((values, [low, high])) = &mut self.shown.iso else { return };
        let step = (*high - *low) / 128.0;
        for value in values.iter_mut() {
            *value = rounded(*value + steps * step, step / 100.0).clamp(*low, *high);
        }
        let values = values.clone();
        handle.send("iso values", move |state| state.set_iso_values(&values));
    }

    /// Are there media whose level and width can be moved?
    pub(super) fn has_window(&self) -> bool {
        self.shown.window.is_some()
    }

    /// Moves level and width of media by so many steps, each a 64th: of the range, and of the width. Says whether there are any.
    pub(super) fn move_window(&mut self, [level_by, width_by]: [f64; 2], handle: &Handle<State>) -> bool {
        let Some(([level, width], [low, high])) = &mut self.shown.window else { return false };
        let range = if *high > *low { *high - *low } else { 1.0 };
        let precise = range / 10_000.0;
        *level = rounded(*level + level_by * range / 64.0, precise).clamp(*low - range, *high + range);
        *width = rounded(*width * (1.0 + 1.0 / 64.0_f64).powf(width_by * 2.0), precise).clamp(precise, 8.0 * range);
        let window = [*level, *width];
        handle.send("window", move |state| state.set_window(window));
        true
    }

    /// The next transfer function by name.
    pub(super) fn next_transfer(&mut self, handle: &Handle<State>) {
        let Some((window, range)) = &mut self.shown.window else { return };
        let all = Preset::ALL;
        let at = all.iter().position(|preset| self.transfer == [preset.name()]);
        let preset = all[at.map_or(0, |at| (at + 1) % all.len())];
        self.transfer = vec![preset.name().to_owned()];
        *window = preset.function(*range).span(*range);
        self.first_window = Some(*window);
        self.shading = None;
        self.other_transfer = true;
        handle.send("transfer function", move |state| {
            state.set_transfer(|range| preset.function(range), preset.is_lit());
        });
    }

    /// Goes to another step of time.
    pub(super) fn move_step(&mut self, by: isize, handle: &Handle<State>) {
        let Volumes { step, steps, .. } = &mut self.shown;
        if *steps > 1 {
            *step = (*step as isize + by).rem_euclid(*steps as isize) as usize;
            let step = *step;
            match &self.streamer {
                Some(streamer) => streamer.show(step),
                None => drop(handle.send("step", move |state| state.set_step(step))),
            }
        }
    }

    /// Lets time go on, or stops it.
    pub(super) fn play_or_pause(&mut self) {
        self.due = match self.due {
            None if self.shown.steps > 1 => Some(Instant::now()),
            _ => None,
        };
    }

    /// Makes time go faster by a factor.
    pub(super) fn speed(&mut self, factor: f64) {
        self.per_second = (self.per_second * factor).clamp(1.0 / 16.0, 64.0);
    }

    /// Goes on to the next step if it is due. Returns when the next will be.
    pub(super) fn tick(&mut self, handle: &Handle<State>) -> Option<Instant> {
        let due = self.due?;
        // A picture of the step follows; then it is looked again.
        if self.waits() {
            return None;
        }
        let now = Instant::now();
        if now >= due {
            if !self.repeats && self.shown.step + 1 >= self.shown.steps {
                self.due = None;
                return None;
            }
            self.move_step(1, handle);
            // What could not be shown in time is not made up for.
            self.due = Some((due + Duration::from_secs_f64(1.0 / self.per_second)).max(now));
        }
        self.due
    }

    /// Is a step read that was asked for?
    fn waits(&self) -> bool {
        self.streamer.as_ref().is_some_and(Streamer::waits)
    }

    /// What the title says.
    pub(super) fn title(&self) -> String {
        let mut text = String::new();
        if let Some((values, _)) = &self.shown.iso {
            text += &format!(", iso {}", joined(values, ", "));
        }
        if let Some(([level, width], _)) = &self.shown.window {
            let [level, width] = [level, width].map(|value| rounded(*value, width / 1000.0));
            text += &format!(", {}, level {level}, width {width}", self.transfer.join(", "));
        }
        if self.shown.steps > 1 {
            text += &format!(", step {} of {}", self.shown.step, self.shown.steps);
            if self.waits() {
                text += " (being read)";
            }
            if self.due.is_some() {
                text += &format!(", {} a second", rounded(self.per_second, 0.01));
            }
        }
        text
    }

    /// What is not as at first.
    pub(super) fn changes(&self) -> Changes {
        let iso = self.shown.iso.as_ref().map(|(values, _)| values.clone());
        Changes {
            iso: iso.filter(|values| self.first_iso.as_ref() != Some(values)),
            transfer: self.other_transfer.then(|| self.transfer.join(" ")),
            window: self.shown.window.map(|(window, _)| window).filter(|window| self.first_window != Some(*window)),
            ..Changes::default()
        }
    }

    /// The step of time that is shown, where there are several.
    pub(super) fn step(&self) -> Option<usize> {
        (self.shown.steps > 1).then_some(self.shown.step)
    }

    /// What makes the same on the command line.
    pub(super) fn options(&self, quoted: impl Fn(&str) -> String) -> String {
        let mut text = String::new();
        if let Some((values, _)) = &self.shown.iso {
            text += &format!(" --iso {}", joined(values, ","));
        }
        for transfer in &self.transfer {
            text += &format!(" --transfer {}", quoted(transfer));
        }
        if let Some(shading) = &self.shading {
            text += &format!(" --shading {shading}");
        }
        if let Some((window, _)) = self.shown.window
            && self.first_window != Some(window)
        {
            text += &format!(" --window {}", joined(&window, ","));
        }
        if self.shown.step > 0 {
            text += &format!(" --step {}", self.shown.step);
        }
        text
    }
}

fn joined(values: &[f64], between: &str) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(between)
}

/// A value with no more digits than make sense if so much of it matters.
pub(super) fn rounded(value: f64, matters: f64) -> f64 {
    let digits = 10_f64.powf(matters.abs().max(1e-300).log10().ceil());
    let rounded = (value / digits).round() * digits;
    format!("{rounded:.9e}").parse().unwrap_or(rounded)
}
