//! The newest picture, copied for the window, and the display that copies it.

use std::error::Error;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use winit::event_loop::EventLoopProxy;

use super::news::News;
use crate::app::{RayCounts, ShownSamples};
use crate::display::png::write_png;
use crate::display::sheet::Sheet;
use crate::pipeline::{Display, Picture, Shown};
use crate::sampler::SamplerKind;

/// What the window and the pipeline share.
#[derive(Clone, Debug)]
pub(super) struct Screen {
    shared: Arc<Mutex<Shared>>,
    samples: Option<ShownSamples>,
    proxy: EventLoopProxy<News>,
}

/// The newest picture, and what is known of its frame.
#[derive(Debug, Default)]
pub(super) struct Shared {
    /// Width and height; zero before the first picture.
    pub(super) size: [usize; 2],
    /// Pixels as 0x00RRGGBB, row by row from the top.
    pub(super) pixels: Vec<u32>,
    /// Samples a pixel; 0 while it is not finished.
    pub(super) samples: u32,
    /// Rays of the frame before.
    pub(super) rays_per_frame: u64,
    rays_before: u64,
    screenshot: Option<Screenshot>,
    /// What is laid over the picture: what colours mean, and all else, in this order.
    pub(super) legend: Option<Sheet>,
    pub(super) hides_legend: bool,
    pub(super) sheets: Vec<Sheet>,
}

/// A screenshot that is wanted.
#[derive(Debug)]
pub(super) struct Screenshot {
    /// Of the first picture from this frame on that is finished.
    pub(super) frame: u64,
    pub(super) file: PathBuf,
    /// What makes the same picture, for people.
    pub(super) same: Same,
}

/// What makes the same picture: for people, with the sampler between two parts.
#[derive(Debug)]
pub(super) struct Same {
    pub(super) before: String,
    pub(super) sampler: Option<SamplerKind>,
    pub(super) behind: String,
}

impl Same {
    /// Of a picture with so many samples a pixel.
    fn of(&self, samples: u32) -> String {
        let sampler = self.sampler.map(|sampler| sampler.after(samples).to_string()).unwrap_or_default();
        format!("{}{sampler}{}", self.before, self.behind)
    }
}

impl Screen {
    pub(super) fn new(proxy: EventLoopProxy<News>) -> Self {
        Self { shared: Arc::default(), samples: None, proxy }
    }

    /// The same for another pipeline, of which `samples` knows how many its pictures have, where they are refined.
    pub(super) fn of_engine(&self, samples: Option<ShownSamples>) -> Self {
        let mut shared = self.lock();
        (shared.rays_before, shared.rays_per_frame, shared.screenshot) = (0, 0, None);
        drop(shared);
        Self { samples, ..self.clone() }
    }

    /// Tells the window something.
    pub(super) fn tell(&self, news: News) {
        // Nobody listens when the window was closed first.
        let _ = self.proxy.send_event(news);
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
        for sheet in legend.into_iter().chain(&self.sheets) {
            sheet.cover(size, y, row);
        }
    }

    /// Row `y` of the picture in a window of a size: until there is one of that size, the old one in the middle, as large as it fits. Black
    /// before the first picture.
    fn fill_from_picture(&self, [width, height]: [usize; 2], y: usize, row: &mut [u32]) {
        let [from_width, from_height] = self.size;
        if self.pixels.is_empty() {
            row.fill(0);
            return;
        }
        let line = |y: usize| &self.pixels[y * from_width..][..from_width];
        if self.size == [width, height] {
            row.copy_from_slice(line(y));
            return;
        }
        let wide = width * from_height <= height * from_width;
        let [to_width, to_height] = match wide {
            true => [width, (from_height * width / from_width).max(1)],
            false => [(from_width * height / from_height).max(1), height],
        };
        let (left, above) = ((width - to_width) / 2, (height - to_height) / 2);
        row.fill(0);
        if let Some(y) = y.checked_sub(above).filter(|y| *y < to_height) {
            let from = line(y * from_height / to_height);
            for (x, pixel) in row[left..][..to_width].iter_mut().enumerate() {
                *pixel = from[x * from_width / to_width];
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
        shared.rays_per_frame = total.saturating_sub(shared.rays_before);
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
        shared.samples = self.screen.samples.as_ref().map_or(u32::MAX, |samples| samples.of(picture.frame));
        let samples = shared.samples;
        let wanted = shared.screenshot.take_if(|wanted| picture.frame >= wanted.frame && samples > 0);
        drop(shared);
        if let Some(Screenshot { file, same, .. }) = wanted {
            let written = write_png(&file, picture.buffer);
            let told = written.map(|()| format!("{}; {}", file.display(), same.of(samples)));
            let told = told.map_err(|error| error.to_string());
            self.screen.tell(News::Screenshot(told));
        }
        let open = self.screen.proxy.send_event(News::Picture).is_ok();
        Ok(if open { Shown::Continue } else { Shown::Detach })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shown(shared: &Shared, size: [usize; 2]) -> Vec<Vec<u32>> {
        let row = |y: usize| {
            let mut row = vec![7; size[0]];
            shared.fill_row(size, y, &mut row);
            row
        };
        (0..size[1]).map(row).collect()
    }

    #[test]
    fn pictures_of_another_size_keep_their_proportions() {
        let shared = Shared { size: [4, 2], pixels: (1..=8).collect(), ..Shared::default() };
        assert_eq!(shown(&shared, [4, 2]), [[1, 2, 3, 4], [5, 6, 7, 8]]);
        assert_eq!(shown(&shared, [4, 6]), [[0; 4], [0; 4], [1, 2, 3, 4], [5, 6, 7, 8], [0; 4], [0; 4]]);
        assert_eq!(shown(&shared, [8, 2])[1], [0, 0, 5, 6, 7, 8, 0, 0]);
        assert_eq!(shown(&shared, [2, 3]), [[0, 0], [1, 3], [0, 0]]);
        assert_eq!(shown(&shared, [1, 1]), [[1]]);
        assert_eq!(shown(&Shared::default(), [2, 1]), [[0, 0]]);
    }
}
