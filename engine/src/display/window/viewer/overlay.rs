//! What the window says of what it shows: the title, and sheets over the picture: help, status, messages, how far loading has come.

use std::time::{Duration, Instant};

use super::Viewer;
use crate::app::Chosen;
use crate::display::Sheet;
use crate::display::sheet::Corner;
use crate::display::window::help;
use crate::display::window::keys;
use crate::display::window::news::tell;

/// The title and the status change no more often.
const INTERVAL: Duration = Duration::from_millis(200);
/// How long a message is shown.
const MESSAGE: Duration = Duration::from_secs(8);
/// What is loaded in place of another scene is not talked about within this.
const PATIENCE: Duration = Duration::from_millis(400);

impl Viewer {
    pub(super) fn next_help(&mut self) {
        let next = self.overlay.help.map_or(0, |page| page + 1);
        self.overlay.help = help::page(self.window_size(), next).map(|_| next);
        if self.overlay.help == Some(0) {
            tell(format_args!("{}", keys::help()));
        }
        self.lay_out();
    }

    pub(super) fn show_or_hide_status(&mut self) {
        self.overlay.status ^= true;
        self.lay_out();
    }

    /// Shows a message for a while.
    pub(super) fn say(&mut self, text: &str) {
        self.overlay.message = Some((text.to_owned(), Instant::now() + MESSAGE));
        self.lay_out();
    }

    /// The same for what went wrong, which is told on standard error too.
    pub(super) fn warn(&mut self, problem: &str) {
        tell(format_args!("mobula: warning: {problem}"));
        self.say(problem);
    }

    fn window_size(&self) -> [usize; 2] {
        let size = self.open.as_ref().map(|open| open.size);
        size.map_or([self.size.width(), self.size.height()], |size| [size.width as usize, size.height as usize])
    }

    /// Makes all sheets anew.
    pub(super) fn lay_out(&mut self) {
        let window = self.window_size();
        let mut sheets = Vec::new();
        if self.overlay.status && self.overlay.help.is_none() {
            sheets.push(Sheet::fitted(&self.status(), window, Corner::UpperRight));
        }
        if let Some(page) = self.overlay.help {
            // A larger window has fewer pages.
            sheets.extend(help::page(window, page).or_else(|| help::page(window, 0)));
        }
        if let Some((text, _)) = &self.overlay.message {
            sheets.push(Sheet::fitted(&wrapped(text, window[0]), window, Corner::Below));
        }
        let patience = if self.engine.is_some() { PATIENCE } else { Duration::ZERO };
        if let Some((text, share)) = self.loading.progress(patience) {
            sheets.push(Sheet::of_progress(&wrapped(&format!("{text}\nEsc: cancel"), window[0]), share, window));
        }
        self.screen.lock().sheets = sheets;
        self.overlay.laid_out = Some(Instant::now());
        self.redraw();
    }

    /// What is rendered and how fast.
    fn status(&self) -> String {
        let Some(engine) = &self.engine else { return "nothing is loaded yet".to_owned() };
        let [speed, samples] = self.speed();
        let Chosen { renderer, camera, sampler, tone, .. } = engine.chosen;
        let threads = engine.threads;
        let mut lines = vec![
            engine.titles.name.clone(),
            speed,
            format!("{samples} of {} samples", sampler.samples()),
            self.size.to_string(),
            format!("{}, {threads} thread{}", engine.kernels, if threads == 1 { "" } else { "s" }),
            engine.contents.clone(),
            format!("{renderer}, {camera}, {} {:+.2}", tone.curve, tone.exposure),
        ];
        lines.extend(self.travel.describe());
        lines.join("\n")
    }

    /// Frames and rays a second, and how many samples the picture has.
    fn speed(&self) -> [String; 2] {
        let Some(engine) = &self.engine else { return Default::default() };
        let shared = self.screen.lock();
        let (rays, samples) = (shared.rays_per_frame, shared.samples);
        drop(shared);
        let seconds = engine.handle.progress().frame_seconds.max(1e-9);
        // Those of the first frame are known when the second begins.
        let rays = match rays {
            0 => String::new(),
            rays => format!(", {:.1} Mrays/s", rays as f64 / seconds * 1e-6),
        };
        let samples = samples.clamp(1, engine.chosen.sampler.samples());
        [format!("{:.1} frames/s{rays}", 1.0 / seconds), samples.to_string()]
    }

    /// Sets the title when enough time has passed since the last time.
    pub(super) fn title_soon(&mut self) {
        let due = self.overlay.set.map_or_else(Instant::now, |set| set + INTERVAL);
        self.overlay.due.get_or_insert(due);
    }

    fn set_title(&mut self) {
        (self.overlay.set, self.overlay.due) = (Some(Instant::now()), None);
        let (Some(open), Some(engine)) = (&self.open, &self.engine) else { return };
        let samples = self.screen.lock().samples;
        let [speed, _] = self.speed();
        let Chosen { renderer, sampler, shadows, .. } = engine.chosen;
        let sampler = sampler.after(samples);
        let shadows = if shadows { "shadows" } else { "no shadows" };
        let volumes = engine.volumes.title() + &engine.particles.title();
        open.window.set_title(&format!(
            "mobula: {} | {} | {speed} | {}, {} thread{} | {renderer}, {sampler}, {shadows}{volumes} | h: help",
            engine.titles.name,
            self.size,
            engine.kernels,
            engine.threads,
            if engine.threads == 1 { "" } else { "s" },
        ));
        if self.overlay.status {
            self.lay_out();
        }
    }

    /// Sets the title, ends messages, and shows how far loading has come, when it is time. Returns when to look again.
    pub(super) fn look_after_overlay(&mut self) -> Option<Instant> {
        let now = Instant::now();
        if self.overlay.due.is_some_and(|due| now >= due) {
            self.set_title();
        }
        // Each time it is drawn this is asked again: not without end.
        let moves = self.loading.is_underway() && self.overlay.laid_out.is_none_or(|then| now >= then + INTERVAL / 2);
        if self.overlay.message.take_if(|(_, end)| now >= *end).is_some() || moves {
            self.lay_out();
        }
        [self.overlay.due, self.overlay.message.as_ref().map(|(_, end)| *end)].into_iter().flatten().min()
    }
}

/// Text in lines that fit into a window of a width, in the largest font.
fn wrapped(text: &str, width: usize) -> String {
    let most = Sheet::most_characters(width).max(20);
    let mut lines = Vec::new();
    for line in text.lines() {
        let mut rest = String::new();
        for word in line.split(' ') {
            let fits = rest.is_empty() || rest.chars().count() + 1 + word.chars().count() <= most;
            if !fits {
                lines.push(std::mem::take(&mut rest));
            }
            if !rest.is_empty() {
                rest.push(' ');
            }
            rest.push_str(word);
        }
        lines.push(rest);
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_lines_are_broken_between_words() {
        let text = "mesh.obj: line 17: a face names vertex 99, but there are 8\nEsc: cancel";
        let lines = wrapped(text, 200);
        assert!(lines.lines().all(|line| line.len() <= 26), "{lines}");
        assert_eq!(lines.replace('\n', " "), text.replace('\n', " "));
        assert_eq!(wrapped(text, 2000), text);
    }
}
