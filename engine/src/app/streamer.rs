//! Steps of time that are not in memory: made on a thread of their own, the next ones ahead, and shown by transaction. Rendering goes on
//! meanwhile.

use std::fmt;
use std::io;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;

use super::State;
use crate::geometry::{CloudSeries, Particles};
use crate::pipeline::Handle;

/// Goes from step to step of a scene whose particles are not all in memory.
///
/// When it is dropped its thread ends, once it has made the step that it is about.
pub struct Streamer {
    shared: Arc<Shared>,
}

struct Shared {
    series: Vec<Arc<CloudSeries>>,
    handle: Handle<State>,
    wish: Mutex<Wish>,
    changed: Condvar,
}

struct Wish {
    /// The step that is to be shown.
    step: usize,
    /// It is not in memory yet.
    waits: bool,
    /// Nobody wants anything any more.
    over: bool,
}

impl Streamer {
    /// For the particles of a state; `None` if all of their steps stay in memory. What goes wrong with a step is told, a line each; the
    /// step is then without particles.
    ///
    /// # Errors
    /// If the system has no thread for it.
    pub fn start(
        state: &State,
        handle: Handle<State>,
        tell: impl Fn(&str) + Send + 'static,
    ) -> io::Result<Option<Self>> {
        let all = state.stack.scene.geometry.list().iter().filter_map(|one| one.downcast_ref::<Particles>());
        let series: Vec<_> = all.map(Particles::series).filter(|series| series.makes_steps()).cloned().collect();
        if series.is_empty() {
            return Ok(None);
        }
        let wish = Mutex::new(Wish { step: state.volumes().step, waits: false, over: false });
        let shared = Arc::new(Shared { series, handle, wish, changed: Condvar::new() });
        let work = Arc::clone(&shared);
        thread::Builder::new().name("mobula-steps".to_owned()).spawn(move || work.run(&tell))?;
        Ok(Some(Self { shared }))
    }

    /// Shows a step as soon as it is in memory: with the next frame if it is.
    pub fn show(&self, step: usize) {
        let mut wish = self.shared.wish();
        (wish.step, wish.waits) = (step, true);
        self.shared.grant(&mut wish);
        self.shared.changed.notify_one();
    }

    /// Is the step that was asked for last not in memory yet?
    pub fn waits(&self) -> bool {
        self.shared.wish().waits
    }
}

impl Drop for Streamer {
    fn drop(&mut self) {
        self.shared.wish().over = true;
        self.shared.changed.notify_one();
    }
}

impl Shared {
    fn wish(&self) -> MutexGuard<'_, Wish> {
        self.wish.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Shows what is asked for if it is in memory.
    fn grant(&self, wish: &mut Wish) {
        let step = wish.step;
        if wish.waits && self.series.iter().all(|series| series.get(step).is_some()) {
            wish.waits = false;
            self.handle.send("step", move |state| state.set_step(step));
        }
    }

    /// Makes steps until nobody wants any more.
    fn run(&self, tell: &dyn Fn(&str)) {
        let mut wish = self.wish();
        while !wish.over {
            let shown = wish.step;
            let wanted = self.series.iter().filter_map(|series| Some((series.wanted(shown)?, series)));
            let Some((ahead, series)) = wanted.min_by_key(|(ahead, _)| *ahead) else {
                wish = self.changed.wait(wish).unwrap_or_else(PoisonError::into_inner);
                continue;
            };
            // While nobody can ask for another step: what is about to be shown is not forgotten.
            series.make_room(shown, ahead);
            drop(wish);
            if let Err(problem) = series.make(shown + ahead) {
                tell(&problem);
            }
            wish = self.wish();
            self.grant(&mut wish);
        }
    }
}

impl fmt::Debug for Streamer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Wish { step, waits, .. } = *self.shared.wish();
        f.debug_struct("Streamer").field("step", &step).field("waits", &waits).finish_non_exhaustive()
    }
}
