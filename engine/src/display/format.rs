//! The formats that pictures are written in, by the ends of files' names.

use std::path::Path;

use crate::choice::choice;

choice! {
    /// A format of pictures.
    "format of pictures" PictureFormat {
        /// 8 bits a channel, without loss.
        Png = "png",
        /// 8 bits a channel, with some loss: small files.
        Jpeg = "jpeg",
        /// 8 bits a channel, not compressed: for other programs.
        Ppm = "ppm",
        /// Light as it arrives, and what is behind each pixel, in layers.
        Exr = "exr",
    }
}

impl PictureFormat {
    /// How names of files end that have it, in small letters.
    pub const fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::Png => &["png"],
            Self::Jpeg => &["jpg", "jpeg"],
            Self::Ppm => &["ppm"],
            Self::Exr => &["exr"],
        }
    }

    /// The format of a file, by the end of its name.
    pub fn of(file: &Path) -> Option<Self> {
        let end = file.extension()?.to_str()?.to_ascii_lowercase();
        Self::ALL.iter().copied().find(|format| format.extensions().contains(&&*end))
    }

    /// Does it need [`Layers`](crate::layers::Layers)?
    pub const fn has_layers(self) -> bool {
        matches!(self, Self::Exr)
    }
}
