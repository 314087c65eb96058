//! How a pipeline is set up.

use std::time::Duration;

use super::threads::{MAX_THREADS, ThreadCountError, check_thread_count};

/// The settings of a [`Pipeline`](super::Pipeline).
#[derive(Clone, Debug)]
pub struct Config {
    /// Render threads, 1 to [`MAX_THREADS`]. Default: one for each core.
    pub threads: usize,
    /// Pin render threads to cores while there are enough of them. Default: true.
    pub pin: bool,
    /// Render a frame only when something changed (interactive use). Default: false, one frame after the other.
    pub on_demand: bool,
    /// The time from frame to frame as callbacks see it, for films. Default: none, the clock on the wall.
    pub frame_time: Option<Duration>,
    /// How often idle callbacks are called while idle. Default: 100 ms.
    pub idle_interval: Duration,
    /// Stack of a render thread in bytes. Default: the standard library's.
    pub stack_size: Option<usize>,
    /// Wrap the panic hook so that caught panics of components print nothing, as the
    /// [`fault`](super::fault) module says. Default: true.
    pub quiet_panics: bool,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            threads: std::thread::available_parallelism().map_or(1, usize::from).min(MAX_THREADS),
            pin: true,
            on_demand: false,
            frame_time: None,
            idle_interval: Duration::from_millis(100),
            stack_size: None,
            quiet_panics: true,
        }
    }
}

impl Config {
    /// The default with another thread count.
    pub fn with_threads(threads: usize) -> Self {
        Self { threads, ..Self::default() }
    }

    pub(super) fn check(&self) -> Result<(), ThreadCountError> {
        check_thread_count(self.threads)
    }
}
