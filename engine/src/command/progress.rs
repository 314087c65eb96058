//! A line on terminals that says how far work has come, for what takes longer than people like to wait without.

use std::io::{self, IsTerminal};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::sync::{Mutex, PoisonError};
use std::thread::{self, Builder};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use mobula::progress::Progress;

use super::quiet;

/// Nothing is shown of what is done within this.
const PATIENCE: Duration = Duration::from_millis(400);
const INTERVAL: Duration = Duration::from_millis(100);

/// What is being done, for windows.
static WATCHED: Mutex<Option<(String, Progress)>> = Mutex::new(None);

/// What is being done, and which part of it is done, if anybody knows.
#[cfg(feature = "window")]
pub(crate) fn watched() -> Option<(String, Option<f64>)> {
    let watched = WATCHED.lock().unwrap_or_else(PoisonError::into_inner);
    watched.as_ref().map(|(what, progress)| (what.clone(), progress.share()))
}

/// Does some work; meanwhile terminals show what it is, the part that is done and how long the rest will take.
pub(crate) fn watch<R>(what: &str, progress: &Progress, work: impl FnOnce() -> R) -> R {
    *WATCHED.lock().unwrap_or_else(PoisonError::into_inner) = Some((what.to_owned(), progress.clone()));
    let result = watch_on_terminal(what, progress, work);
    *WATCHED.lock().unwrap_or_else(PoisonError::into_inner) = None;
    result
}

fn watch_on_terminal<R>(what: &str, progress: &Progress, work: impl FnOnce() -> R) -> R {
    if quiet() || !io::stderr().is_terminal() {
        return work();
    }
    let (done, wait) = channel::<()>();
    thread::scope(|scope| {
        // Where no thread is to be had the work is done all the same.
        let watcher = Builder::new().spawn_scoped(scope, move || {
            if wait.recv_timeout(PATIENCE) == Err(RecvTimeoutError::Timeout) {
                let begun = Instant::now() - PATIENCE;
                let bar = ProgressBar::new(1000).with_prefix(what.to_owned());
                while wait.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                    show(&bar, progress.share(), begun.elapsed());
                }
                bar.finish_and_clear();
            }
        });
        let result = work();
        drop(done);
        if let Ok(watcher) = watcher {
            let _ = watcher.join();
        }
        result
    })
}

fn show(bar: &ProgressBar, share: Option<f64>, elapsed: Duration) {
    match share {
        Some(share) => {
            // At the very beginning nobody can tell.
            let left =
                if share > 0.02 { duration(elapsed.as_secs_f64() * (1.0 / share - 1.0)) } else { "?".to_owned() };
            let style = ProgressStyle::with_template("{prefix} {bar:32} {percent:>3} %, {msg} left");
            bar.set_style(style.expect("a valid template"));
            bar.set_message(left);
            bar.set_position((share * 1000.0) as u64);
        }
        None => {
            bar.set_style(ProgressStyle::with_template("{prefix}, {msg}").expect("a valid template"));
            bar.set_message(duration(elapsed.as_secs_f64()));
            bar.tick();
        }
    }
}

/// A time in whole seconds, as people say it.
fn duration(seconds: f64) -> String {
    let seconds = seconds.min(1e9).ceil() as u64;
    match (seconds / 3600, seconds / 60 % 60, seconds % 60) {
        (0, 0, seconds) => format!("{seconds} s"),
        (0, minutes, seconds) => format!("{minutes} min {seconds} s"),
        (hours, minutes, _) => format!("{hours} h {minutes} min"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_told_in_words() {
        let words = [0.0, 0.2, 61.0, 7300.0, f64::INFINITY].map(duration);
        assert_eq!(words[..4], ["0 s", "1 s", "1 min 1 s", "2 h 1 min"]);
    }

    #[test]
    fn work_is_done_whoever_watches() {
        assert_eq!(watch("testing", &Progress::default(), || 7), 7);
    }
}
