//! What Ctrl-C and other signals that end the process do: no file is left half written.

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

/// From now on the end of memory, of which the system has told by then, is a failure as others are, not an abort that dumps core.
pub(crate) fn fail_on_abort() {
    #[cfg(unix)]
    {
        use std::sync::Arc;
        let always = Arc::new(AtomicBool::new(true));
        let _ = signal_hook::flag::register_conditional_shutdown(signal_hook::consts::SIGABRT, 1, always);
    }
}

/// From now on signals that end the process remove unfinished files first.
pub(crate) fn listen() {
    static LISTENING: Once = Once::new();
    LISTENING.call_once(start);
}

/// Does something that Ctrl-C ends between two tiles, and a second Ctrl-C, or SIGTERM, at once; returns whether it did.
pub(crate) fn stopping<R>(handle: Handle<State>, work: impl FnOnce() -> R) -> (R, bool) {
    *running() = Some(handle);
    listen();
    let result = work();
    running().take();
    // Relaxed: only this flag is shared.
    (result, INTERRUPTED.load(Ordering::Relaxed))
}

fn running() -> MutexGuard<'static, Option<Handle<State>>> {
    RUNNING.lock().unwrap_or_else(PoisonError::into_inner)
}

fn act(signal: i32) {
    match running().as_ref() {
        // Relaxed: only this flag is shared.
        Some(handle) if signal == INTERRUPT && !INTERRUPTED.swap(true, Ordering::Relaxed) => handle.halt(),
        _ => output::exit(128 + signal),
    }
}

/// Where no thread is to be had, signals do what they do without us.
#[cfg(unix)]
fn start() {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGXFSZ};
    use signal_hook::iterator::Signals;
    // A file that may grow no further is an error of the one who writes it, not the end of the process.
    let _ = signal_hook::flag::register(SIGXFSZ, std::sync::Arc::default());
    let hang_up = if ignores(SIGHUP) { None } else { Some(SIGHUP) };
    let heeded = [SIGINT, SIGTERM, SIGQUIT].into_iter().chain(hang_up);
    let wait = || {
        if let Ok(mut signals) = Signals::new(heeded) {
            signals.forever().for_each(act);
        }
    };
    let _ = std::thread::Builder::new().name("signals".to_owned()).spawn(wait);
}

/// Whether whoever started us wants a signal to be ignored, as `nohup` does; true where the system does not tell.
#[cfg(unix)]
fn ignores(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_none_or(|mask| mask >> (signal - 1) & 1 != 0)
}

#[cfg(not(unix))]
fn start() {
    // It may be refused where another handler is installed; then there is that one.
    let _ = ctrlc::set_handler(|| act(INTERRUPT));
}
