//! Faults: a panic in any component becomes an error that names the component.
//!
//! A component runs inside [`scope`], which costs nothing until something panics: the guard's only work is done while
//! the stack unwinds, where the innermost scope writes down its name. The pipeline catches the panic at the edge of each
//! stage, callback and transaction with [`catch`] and reads that name.
//!
//! Quiet panics: the first pipeline of a process wraps the panic hook once. While a thread is inside [`catch`], the
//! wrapper notes the panic's place and prints nothing, since the fault is reported as a value; a panic of any other
//! thread goes to the hook that was there before. With `RUST_BACKTRACE` set, every panic goes there.

use std::any::Any;
use std::cell::{Cell, RefCell};
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Once;

/// Why a run ended early: one component failed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{component} failed on thread {thread} in frame {frame}: {message}{}", place(.location))]
pub struct Fault {
    /// The innermost component that was running, by the name it gave to [`scope`].
    pub component: String,
    /// Index of the render thread.
    pub thread: usize,
    /// Number of the frame that was being worked on.
    pub frame: u64,
    /// What the panic said.
    pub message: String,
    /// File, line and column of the panic, where known.
    pub location: Option<String>,
}

fn place(location: &Option<String>) -> String {
    location.as_ref().map(|at| format!(" ({at})")).unwrap_or_default()
}

/// A panic that was caught: what failed and what it said.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Caught {
    /// The innermost component.
    pub component: String,
    /// What the panic said.
    pub message: String,
    /// File, line and column of the panic, where known.
    pub location: Option<String>,
}

impl Caught {
    /// Says where it happened.
    pub fn at(self, thread: usize, frame: u64) -> Fault {
        let Self { component, message, location } = self;
        Fault { component, thread, frame, message, location }
    }
}

/// The payload of [`fail`].
struct Failure(String);

thread_local! {
    static FAILED: RefCell<Option<String>> = const { RefCell::new(None) };
    static LOCATION: RefCell<Option<String>> = const { RefCell::new(None) };
    static CATCHING: Cell<bool> = const { Cell::new(false) };
}

/// Runs a component under its name. If it panics, the innermost name is the one that the [`Fault`] carries.
#[inline(always)]
pub fn scope<R>(component: &str, body: impl FnOnce() -> R) -> R {
    let guard = Scope(component);
    let result = body();
    std::mem::forget(guard);
    result
}

/// Ends the component that is running, and with it the run, with a message: for errors that are not bugs (a full disk).
/// Prints nothing.
pub fn fail(message: impl std::fmt::Display) -> ! {
    resume_unwind(Box::new(Failure(message.to_string())))
}

/// Runs `body` and turns a panic into a value. `component` is the name if no inner [`scope`] gave one.
///
/// A component that means to survive its own panics uses this too, rather than `catch_unwind`, or the name of the
/// survivor would be given to the next fault of the thread.
pub fn catch<R>(component: impl std::fmt::Display, body: impl FnOnce() -> R) -> Result<R, Caught> {
    let outer = CATCHING.replace(true);
    FAILED.take();
    LOCATION.take();
    let result = catch_unwind(AssertUnwindSafe(body));
    CATCHING.set(outer);
    result.map_err(|payload| Caught {
        component: FAILED.take().unwrap_or_else(|| component.to_string()),
        message: message_of(payload),
        location: LOCATION.take(),
    })
}

/// Wraps the panic hook, once in a process, as the module documentation says.
pub fn install_quiet_hook() {
    static INSTALLED: Once = Once::new();
    if std::thread::panicking() {
        return;
    }
    INSTALLED.call_once(|| {
        let loud = std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0");
        let previous = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |panic| {
            let caught = CATCHING.try_with(Cell::get).unwrap_or(false);
            if caught {
                let location = panic.location().map(ToString::to_string);
                let _ = LOCATION.try_with(|cell| cell.replace(location));
            }
            if loud || !caught {
                previous(panic);
            }
        }));
    });
}

struct Scope<'a>(&'a str);

impl Drop for Scope<'_> {
    // Reached only while unwinding: the normal way out forgets the guard.
    #[cold]
    fn drop(&mut self) {
        let _ = FAILED.try_with(|failed| {
            failed.borrow_mut().get_or_insert_with(|| self.0.to_owned());
        });
    }
}

fn message_of(payload: Box<dyn Any + Send>) -> String {
    let message = if let Some(text) = payload.downcast_ref::<&str>() {
        (*text).to_owned()
    } else if let Some(text) = payload.downcast_ref::<String>() {
        text.clone()
    } else if let Some(Failure(text)) = payload.downcast_ref() {
        text.clone()
    } else {
        "a panic without a message".to_owned()
    };
    // A payload may panic when it is dropped; then let it leak.
    if let Err(second) = catch_unwind(AssertUnwindSafe(|| drop(payload))) {
        std::mem::forget(second);
    }
    message
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_innermost_scope_is_named() {
        install_quiet_hook();
        let caught = catch("stage", || scope("renderer", || scope("material", || panic!("no {}", "colour"))));
        let caught = caught.unwrap_err();
        assert_eq!((caught.component.as_str(), caught.message.as_str()), ("material", "no colour"));
        assert!(caught.location.unwrap().contains("fault.rs"));
    }

    #[test]
    fn a_scope_that_ended_is_not_named() {
        install_quiet_hook();
        let caught = catch("stage", || {
            scope("sampler", || ());
            fail("disk full");
        });
        let caught = caught.unwrap_err();
        assert_eq!((caught.component.as_str(), caught.message.as_str()), ("stage", "disk full"));
    }

    #[test]
    fn a_survived_panic_leaves_no_name() {
        install_quiet_hook();
        let caught = catch("stage", || {
            assert!(catch("inner", || scope("survivor", || panic!("once"))).is_err());
            panic!("twice");
        });
        assert_eq!(caught.unwrap_err().component, "stage");
    }

    #[test]
    fn a_payload_that_panics_in_drop_is_survived() {
        struct Bomb;
        impl Drop for Bomb {
            fn drop(&mut self) {
                fail("boom");
            }
        }
        let caught = catch("stage", || std::panic::panic_any(Bomb)).unwrap_err();
        assert_eq!(caught.message, "a panic without a message");
    }
}
