//! Displays: where the finished pictures of a channel go.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2 (image display as an imbalanced stage).

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

use super::fault;
use super::stage::{Balance, Frame, Stage};
use crate::image::{FrameBuffer, Size};

/// A picture to be shown.
#[derive(Debug)]
pub struct Picture<'a, B = FrameBuffer> {
    /// Number of the frame.
    pub frame: u64,
    /// Index of the channel.
    pub channel: usize,
    /// Name of the channel.
    pub name: &'a str,
    /// Size of the picture: it may be older than the channel's present size.
    pub size: Size,
    /// The pixels.
    pub buffer: &'a B,
}

/// What becomes of a display after a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Show the next one too.
    Continue,
    /// This display is closed: show it no more pictures; the run goes on.
    Detach,
    /// End the run.
    Stop,
}

/// Shows pictures, one at a time, on whichever render thread the pipeline chooses.
pub trait Display<B = FrameBuffer>: Send {
    /// What it is called in errors.
    fn name(&self) -> &str;

    /// Shows one picture. An error ends the run with a fault that names the display.
    fn show(&mut self, picture: &Picture<'_, B>) -> Result<Shown, Box<dyn Error + Send + Sync>>;
}

impl<B, D: Display<B> + ?Sized> Display<B> for Box<D> {
    fn name(&self) -> &str {
        (**self).name()
    }

    fn show(&mut self, picture: &Picture<'_, B>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        (**self).show(picture)
    }
}

/// A display, until it detaches.
type Slot<B> = Arc<Mutex<Option<Box<dyn Display<B>>>>>;

/// The imbalanced stage that shows each channel on its display. Channels without a display are not shown.
///
/// A clone has the same displays: keep one to [`attach`](Self::attach) displays while the pipeline runs.
pub struct DisplayStage<B = FrameBuffer> {
    displays: Arc<Mutex<BTreeMap<usize, Slot<B>>>>,
}

impl<B> DisplayStage<B> {
    /// A stage without displays.
    pub fn new() -> Self {
        Self { displays: Arc::default() }
    }

    /// Shows a channel on a display, in the place of the one it had.
    #[must_use]
    pub fn with(self, channel: usize, display: impl Display<B> + 'static) -> Self {
        self.attach(channel, display);
        self
    }

    /// Shows a channel's next picture, and those behind it, on a display, in the place of the one it had.
    pub fn attach(&self, channel: usize, display: impl Display<B> + 'static) {
        let slot: Slot<B> = Arc::new(Mutex::new(Some(Box::new(display))));
        self.lock().insert(channel, slot);
    }

    /// Shows a channel's next picture no more. A picture that is being shown is not waited for.
    pub fn detach(&self, channel: usize) {
        self.lock().remove(&channel);
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, BTreeMap<usize, Slot<B>>> {
        self.displays.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<S, B: Send + Sync> Stage<S, B> for DisplayStage<B> {
    fn name(&self) -> &str {
        "display"
    }

    fn balance(&self) -> Balance {
        Balance::Imbalanced
    }

    fn run(&self, frame: &Frame<'_, S, B>) {
        for view in frame.channels() {
            let Some(display) = self.lock().get(&view.index).cloned() else { continue };
            // One thread per channel and frame: the lock is never waited for.
            let mut slot = display.lock().unwrap_or_else(PoisonError::into_inner);
            let Some(display) = slot.as_mut() else { continue };
            let picture = Picture {
                frame: frame.number,
                channel: view.index,
                name: &view.channel.name,
                size: view.size,
                buffer: view.buffer,
            };
            let name = display.name().to_owned();
            let shown = fault::scope(&name, || display.show(&picture).unwrap_or_else(|error| fault::fail(error)));
            match shown {
                Shown::Continue => {}
                Shown::Detach => *slot = None,
                Shown::Stop => frame.request_stop(),
            }
        }
    }
}

impl<B> Clone for DisplayStage<B> {
    fn clone(&self) -> Self {
        Self { displays: Arc::clone(&self.displays) }
    }
}

impl<B> Default for DisplayStage<B> {
    fn default() -> Self {
        Self::new()
    }
}

impl<B> std::fmt::Debug for DisplayStage<B> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("DisplayStage").field("channels", &self.lock().keys()).finish()
    }
}

/// A display made of a closure.
struct Closure<F> {
    name: String,
    show: F,
}

impl<B, F> Display<B> for Closure<F>
where
    F: FnMut(&Picture<'_, B>) -> Result<Shown, Box<dyn Error + Send + Sync>> + Send,
{
    fn name(&self) -> &str {
        &self.name
    }

    fn show(&mut self, picture: &Picture<'_, B>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        (self.show)(picture)
    }
}

/// A display from a closure.
pub fn display<B>(
    name: impl Into<String>,
    show: impl FnMut(&Picture<'_, B>) -> Result<Shown, Box<dyn Error + Send + Sync>> + Send + 'static,
) -> impl Display<B> + 'static {
    Closure { name: name.into(), show }
}

/// A display that throws pictures away and counts nothing: for benchmarks.
#[derive(Clone, Copy, Debug, Default)]
pub struct NullDisplay;

impl<B> Display<B> for NullDisplay {
    fn name(&self) -> &str {
        "null display"
    }

    fn show(&mut self, _: &Picture<'_, B>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        Ok(Shown::Continue)
    }
}
