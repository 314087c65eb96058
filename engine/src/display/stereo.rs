//! Stereo: the pictures of two eyes become one, which goes to one display.
//!
//! Source: Bigler, Stephens and Parker 2006, section 5.2 (channels). Each eye is a channel: both are rendered in the same
//! balanced stage, and the one that is shown last hands the joined picture on.

use std::collections::BTreeMap;
use std::error::Error;
use std::sync::{Arc, Mutex, PoisonError};

use crate::choice::choice;
use crate::image::{FrameBuffer, Size, SizeError};
use crate::pipeline::{Display, Picture, Shown};

choice! {
    /// How two pictures become one.
    "kind of stereo" Stereo {
        /// The left eye's picture on the left, both at full size.
        SideBySide = "side-by-side",
        /// Red from the left eye, green and blue from the right, for red and cyan glasses.
        Anaglyph = "anaglyph",
    }
}

impl Stereo {
    /// The size of the joined picture.
    ///
    /// # Errors
    /// If it would be too large.
    pub fn size(self, eye: Size) -> Result<Size, SizeError> {
        match self {
            Self::SideBySide => Size::new(eye.width() * 2, eye.height()),
            Self::Anaglyph => Ok(eye),
        }
    }

    /// Joins the pictures of the left and the right eye; `None` if their sizes differ.
    ///
    /// # Errors
    /// If the whole would be too large, or there is no memory for it.
    pub fn join(self, [left, right]: [&FrameBuffer; 2]) -> Result<Option<FrameBuffer>, SizeError> {
        let size = left.size();
        if right.size() != size {
            return Ok(None);
        }
        let joined = FrameBuffer::try_with_size(self.size(size)?)?;
        // The lowest byte is red.
        const RED: u32 = 0xff;
        for y in 0..size.height() {
            for x in 0..size.width() {
                let (left, right) = (left.get(x, y), right.get(x, y));
                match self {
                    Self::SideBySide => {
                        joined.set(x, y, left);
                        joined.set(x + size.width(), y, right);
                    }
                    Self::Anaglyph => joined.set(x, y, left & RED | right & !RED),
                }
            }
        }
        Ok(Some(joined))
    }

    /// Displays for the channels of the left and the right eye that show the joined pictures on `display`.
    pub fn displays(self, display: impl Display + 'static) -> [Eye; 2] {
        let name: Arc<str> = display.name().into();
        let pair = Pair { stereo: self, waiting: BTreeMap::new(), display: Box::new(display), shown: Shown::Continue };
        let pair = Arc::new(Mutex::new(pair));
        [0, 1].map(|eye| Eye { eye, name: Arc::clone(&name), pair: Arc::clone(&pair) })
    }
}

/// The display of one eye; see [`Stereo::displays`].
pub struct Eye {
    eye: usize,
    name: Arc<str>,
    pair: Arc<Mutex<Pair>>,
}

struct Pair {
    stereo: Stereo,
    /// Pictures whose other eye has not been shown yet, by frame.
    waiting: BTreeMap<u64, (usize, FrameBuffer)>,
    display: Box<dyn Display>,
    shown: Shown,
}

impl Display for Eye {
    fn name(&self) -> &str {
        &self.name
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        let mut pair = self.pair.lock().unwrap_or_else(PoisonError::into_inner);
        if pair.shown != Shown::Continue {
            return Ok(pair.shown);
        }
        let Some((eye, other)) = pair.waiting.remove(&picture.frame) else {
            let copy = FrameBuffer::try_with_size(picture.size)?;
            copy.copy_from(picture.buffer, 0, 0, picture.size.width(), picture.size.height());
            pair.waiting.insert(picture.frame, (self.eye, copy));
            return Ok(Shown::Continue);
        };
        // What is older was left behind by a frame that only one eye took part in.
        pair.waiting.retain(|&frame, _| frame > picture.frame);
        let eyes = if eye == 0 { [&other, picture.buffer] } else { [picture.buffer, &other] };
        let Some(joined) = pair.stereo.join(eyes)? else { return Ok(Shown::Continue) };
        let picture = Picture { channel: 0, size: joined.size(), buffer: &joined, ..*picture };
        pair.shown = pair.display.show(&picture)?;
        Ok(pair.shown)
    }
}

impl std::fmt::Debug for Eye {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Eye").field("eye", &self.eye).field("display", &self.name).finish_non_exhaustive()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::rgba8;

    /// Frames and their pixels.
    type Kept = Vec<(u64, Vec<u32>)>;

    struct Keep(Arc<Mutex<Kept>>);

    impl Display for Keep {
        fn name(&self) -> &str {
            "keep"
        }

        fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
            self.0.lock().unwrap().push((picture.frame, picture.buffer.pixels().collect()));
            Ok(if picture.frame == 2 { Shown::Stop } else { Shown::Continue })
        }
    }

    fn plain(colour: u32) -> FrameBuffer {
        let buffer = FrameBuffer::new(2, 1).unwrap();
        buffer.set_row(0, 0, &[colour, colour]);
        buffer
    }

    #[test]
    fn both_kinds_join_both_eyes() {
        let (left, right) = (rgba8(10, 20, 30, 255), rgba8(40, 50, 60, 255));
        let join =
            |stereo: Stereo| stereo.join([&plain(left), &plain(right)]).unwrap().unwrap().pixels().collect::<Vec<_>>();
        assert_eq!(join(Stereo::SideBySide), [left, left, right, right]);
        assert_eq!(join(Stereo::Anaglyph), [rgba8(10, 50, 60, 255); 2]);
        assert!(Stereo::Anaglyph.join([&plain(0), &FrameBuffer::new(3, 1).unwrap()]).unwrap().is_none());
    }

    #[test]
    fn frames_are_joined_with_their_own_other_eye() {
        let kept = Arc::<Mutex<Kept>>::default();
        let [mut left, mut right] = Stereo::Anaglyph.displays(Keep(Arc::clone(&kept)));
        let mut show = |eye: usize, frame: u64| {
            let buffer = plain(rgba8(frame as u8, frame as u8, 0, 255));
            let picture = Picture { frame, channel: eye, name: "eye", size: buffer.size(), buffer: &buffer };
            if eye == 0 { left.show(&picture).unwrap() } else { right.show(&picture).unwrap() }
        };
        show(0, 0); // its other eye never comes
        for frame in 1..3 {
            let (first, second) = (frame as usize % 2, 1 - frame as usize % 2);
            assert_eq!(show(first, frame), Shown::Continue);
            assert_eq!(show(second, frame), if frame == 2 { Shown::Stop } else { Shown::Continue });
        }
        let whole = |frame: u8| vec![rgba8(frame, frame, 0, 255); 2];
        assert_eq!(*kept.lock().unwrap(), [(1, whole(1)), (2, whole(2))]);
    }
}
