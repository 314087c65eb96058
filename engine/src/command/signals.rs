//! What Ctrl-C and SIGTERM do: no file is left half written.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

use mobula::app::State;
use mobula::output;
use mobula::pipeline::Handle;

/// Ctrl-C's number.
const INTERRUPT: i32 = 2;

/// The run that Ctrl-C stops; before and after it, Ctrl-C ends the process.
static RUNNING: Mutex<Option<Handle<State>>> = Mutex::new(None);
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// From now on signals that end the process remove unfinished files first.
pub(crate) fn listen() {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(start);
}

/// Does something that Ctrl-C ends after the present frame, and a second Ctrl-C, or SIGTERM, at once.
pub(crate) fn stopping<R>(handle: Handle<State>, work: impl FnOnce() -> R) -> R {
    *running() = Some(handle);
    listen();
    let result = work();
    running().take();
    result
}

fn running() -> MutexGuard<'static, Option<Handle<State>>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

fn act(signal: i32) {
    match running().as_ref() {
        // Relaxed: only this flag is shared.
        Some(handle) if signal == INTERRUPT && !INTERRUPTED.swap(true, Ordering::Relaxed) => drop(handle.stop()),
        _ => output::exit(128 + signal),
    }
}

/// Where no thread is to be had, signals do what they do without us.
#[cfg(unix)]
fn start() {
    use signal_hook::consts::{SIGINT, SIGTERM};
    use signal_hook::iterator::Signals;
    let wait = || {
        if let Ok(mut signals) = Signals::new([SIGINT, SIGTERM]) {
            signals.forever().for_each(act);
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(wait);
}

#[cfg(not(unix))]
fn start() {
    // It may be refused where another handler is installed; then there is that one.
    let _ = ctrlc::set_handler(|| act(INTERRUPT));
}
