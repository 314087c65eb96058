//! The textures that a model wants: each picture once, decoded by all processors.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use super::{LoadError, picture};
use crate::progress::Progress;
use crate::texture::{Encoding, Picture, Texels, Texture};

/// What a picture is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) enum Use {
    /// Colours.
    Color,
    /// Plain numbers.
    Data,
    /// Normals; of a picture in greys, which are heights, the normals that go with them.
    Bumps,
}

/// Pictures that are wanted, by number.
#[derive(Default)]
pub(super) struct Gallery {
    wanted: Vec<(PathBuf, Use)>,
    numbers: HashMap<(PathBuf, Use), usize>,
}

/// What became of each picture that was wanted.
pub(super) type Decoded = Vec<Result<Arc<Texture>, LoadError>>;

impl Gallery {
    /// The number of a picture in a file.
    pub(super) fn want(&mut self, file: PathBuf, what: Use) -> usize {
        let next = self.wanted.len();
        *self.numbers.entry((file, what)).or_insert_with_key(|key| {
            self.wanted.push(key.clone());
            next
        })
    }

    /// Decodes them all.
    pub(super) fn decode(self, progress: &Progress) -> Decoded {
        let sizes = self.wanted.iter().map(|(file, _)| file.metadata().map_or(0, |data| data.len()));
        progress.expect(sizes.sum());
        at_once(&self.wanted, |(file, what)| {
            let picture = picture::read(file);
            progress.advance(file.metadata().map_or(0, |data| data.len()));
            picture.map(|picture| Arc::new(texture(picture, *what)))
        })
    }
}

/// Does something with each item, on all processors, and gives the results in the items' order.
pub(super) fn at_once<T: Sync, R: Send>(items: &[T], work: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let threads = thread::available_parallelism().map_or(1, usize::from).min(items.len());
    if threads <= 1 {
        return items.iter().map(work).collect();
    }
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::with_capacity(items.len()));
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                // Relaxed: it only numbers the items.
                while let Some((at, item)) =
                    Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|at| Some((at, items.get(at)?)))
                {
                    let result = work(item);
                    done.lock().unwrap_or_else(PoisonError::into_inner).push((at, result));
                }
            });
        }
    });
    let mut done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.sort_by_key(|(at, _)| *at);
    done.into_iter().map(|(_, result)| result).collect()
}

/// A texture of a picture.
pub(super) fn texture(picture: Picture, what: Use) -> Texture {
    match what {
        Use::Color => Texture::new(picture, Encoding::Srgb),
        Use::Bumps if is_grey(&picture) => Texture::new(normals(&picture), Encoding::Linear),
        Use::Data | Use::Bumps => Texture::new(picture, Encoding::Linear),
    }
}

/// Is a picture without any colour? Of normals, those that point straight away are blue.
fn is_grey(picture: &Picture) -> bool {
    match picture.texels() {
        Texels::Bytes(texels) => texels.iter().all(|[r, g, b, _]| r.abs_diff(*g).max(g.abs_diff(*b)) <= 8),
        Texels::Floats(texels) => texels.iter().all(|[r, g, b, _]| (r - g).abs().max((g - b).abs()) <= 0.03),
    }
}

/// How many texels white is higher than black, in pictures of heights. Nothing says; it looks like what modellers show.
const HEIGHT: f32 = 8.0;

/// The normals of a surface whose heights a picture shows, which goes on beyond its borders.
fn normals(heights: &Picture) -> Picture {
    let size = heights.size();
    let [width, height] = size.map(|side| side as usize);
    let red: Vec<f32> = match heights.texels() {
        Texels::Bytes(texels) => texels.iter().map(|texel| f32::from(texel[0]) / 255.0).collect(),
        Texels::Floats(texels) => {
            texels.iter().map(|texel| if texel[0].is_finite() { texel[0] } else { 0.0 }).collect()
        }
    };
    let at = |x: usize, y: usize| red[y % height * width + x % width] * (0.5 * HEIGHT);
    let texel = |x: usize, y: usize| {
        let across = at(x + width - 1, y) - at(x + 1, y);
        // Rows go down.
        let up = at(x, y + 1) - at(x, y + height - 1);
        let length = (across * across + up * up + 1.0).sqrt();
        let byte = |part: f32| ((part / length * 0.5 + 0.5) * 255.0 + 0.5) as u8;
        [byte(across), byte(up), byte(1.0), 255]
    };
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    Picture::new(size, Texels::Bytes(texels)).expect("as many as there were")
}
