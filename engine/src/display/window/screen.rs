//! The newest picture, copied for the window, and the display that copies it.

use std::error::Error;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use winit::event_loop::EventLoopProxy;

use super::news::News;
use crate::app::RayCounts;
use crate::display::png::write_png;
use crate::display::sheet::Sheet;
use crate::pipeline::{Display, Picture, Shown};

/// What the window and the pipeline share.
#[derive(Clone, Debug)]
pub(super) struct Screen {
    shared: Arc<Mutex<Shared>>,
    proxy: EventLoopProxy<News>,
}

/// The newest picture, and what is known of its frame.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Width and height; zero before the first picture.
    pub(super) size: [usize; 2],
    /// Pixels as 0x00RRGGBB, row by row from the top.
    pub(super) pixels: Vec<u32>,
    /// Rays of the frame before.
    pub(super) rays_per_frame: u64,
    rays_before: u64,
    screenshot: Option<Screenshot>,
    /// What is laid over the picture: help, and what colours mean.
    pub(super) help: Option<Sheet>,
    pub(super) legend: Option<Sheet>,
    pub(super) hides_legend: bool,
}

/// A screenshot that is wanted.
#[derive(Debug)]
pub(super) struct Screenshot {
    /// Of the first picture from this frame on.
    pub(super) frame: u64,
    pub(super) file: PathBuf,
    /// What makes the same picture, for people.
    pub(super) same: String,
}

impl Screen {
    pub(super) fn new(proxy: EventLoopProxy<News>) -> Self {
        Self { shared: Arc::default(), proxy }
    }

    /// The picture. Do not hold it for long: the display waits for it.
    pub(super) fn lock(&self) -> MutexGuard<'_, Shared> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The display that fills this screen.
    pub(super) fn display(&self) -> WindowDisplay {
        WindowDisplay { screen: self.clone() }
    }

    /// Who is told of the rays that have been traced, before each frame.
    pub(super) fn ray_counter(&self) -> RayCounter {
        RayCounter { screen: self.clone() }
    }

    /// Asks for a screenshot.
    pub(super) fn want(&self, screenshot: Screenshot) {
        self.lock().screenshot = Some(screenshot);
    }
}

impl Shared {
    /// Row `y` of what is shown in a window of a size: the picture, and what is laid over it.
    pub(super) fn fill_row(&self, size: [usize; 2], y: usize, row: &mut [u32]) {
        self.fill_from_picture(size, y, row);
        let legend = self.legend.as_ref().filter(|_| !self.hides_legend);
        for sheet in [legend, self.help.as_ref()].into_iter().flatten() {
            sheet.cover(size, y, row);
        }
    }

    /// Row `y` of the picture, enlarged or shrunk to a size; black before the first picture.
    fn fill_from_picture(&self, [width, height]: [usize; 2], y: usize, row: &mut [u32]) {
        let [from_width, from_height] = self.size;
        if self.pixels.is_empty() {
            row.fill(0);
            return;
        }
        let from = &self.pixels[y * from_height / height * from_width..][..from_width];
        if from_width == width {
            row.copy_from_slice(from);
        } else {
            for (x, pixel) in row.iter_mut().enumerate() {
                *pixel = from[x * from_width / width];
            }
        }
    }
}

/// Counts the rays of each frame.
#[derive(Debug)]
pub(super) struct RayCounter {
    screen: Screen,
}

impl RayCounter {
    /// Takes note of all rays traced so far.
    pub(super) fn note(&self, rays: &RayCounts) {
        let mut shared = self.screen.lock();
        let total = rays.total();
        shared.rays_per_frame = total - shared.rays_before;
        shared.rays_before = total;
    }
}

/// Shows pictures by copying them to a [`Screen`] and telling the window.
#[derive(Debug)]
pub(super) struct WindowDisplay {
    screen: Screen,
}

impl Display for WindowDisplay {
    fn name(&self) -> &str {
        "window display"
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        let mut shared = self.screen.lock();
        shared.pixels.clear();
        shared.pixels.try_reserve_exact(picture.size.pixels())?;
        shared.size = [picture.size.width(), picture.size.height()];
        shared.pixels.extend(picture.buffer.pixels().map(|pixel| {
            let [red, green, blue, _] = pixel.to_le_bytes();
            u32::from_be_bytes([0, red, green, blue])
        }));
        let wanted = shared.screenshot.take_if(|wanted| picture.frame >= wanted.frame);
        drop(shared);
        if let Some(Screenshot { file, same, .. }) = wanted {
            let written = write_png(&file, picture.buffer);
            let told = written.map(|()| format!("{}; {same}", file.display()));
            let told = told.map_err(|error| error.to_string());
            let _ = self.screen.proxy.send_event(News::Screenshot(told));
        }
        let open = self.screen.proxy.send_event(News::Picture).is_ok();
        Ok(if open { Shown::Continue } else { Shown::Detach })
    }
}
