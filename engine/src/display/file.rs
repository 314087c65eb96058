//! Pictures in files, in the format that the name's end says, or on standard output.
//!
//! Files are whole or not there, as [`output`] says.

use std::error::Error;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::error::PictureError;
use super::format::PictureFormat;
use super::sheet::Sheet;
use super::{exr, jpeg, png, ppm};
use crate::image::FrameBuffer;
use crate::output;
use crate::pipeline::{Display, Picture, Shown};

/// The name that stands for standard output, where pictures are PPM.
pub const STANDARD_OUTPUT: &str = "-";

/// Writes pictures to a file, each in place of the one before; or, if there are marks `#` in the file's name, each to a file of its
/// own: the last marks, two or more, become the number of the frame, of so many digits or more. Files whose names' ends are not known are
/// PNG.
#[derive(Clone, Debug)]
pub struct PictureFile {
    file: PathBuf,
    /// What is laid over each picture.
    sheet: Option<Sheet>,
}

impl PictureFile {
    /// Its name in faults.
    pub const NAME: &str = "picture file";

    /// Writes every frame that it is shown.
    pub fn new(file: impl Into<PathBuf>) -> Self {
        Self { file: file.into(), sheet: None }
    }

    /// With something laid over each picture, but those that hold light.
    pub fn with_sheet(self, sheet: Option<Sheet>) -> Self {
        Self { sheet, ..self }
    }

    /// The file of a frame.
    pub fn file(&self, frame: u64) -> PathBuf {
        let name = self.file.file_name().unwrap_or_default().to_string_lossy();
        let Some(last) = name.rfind("##").map(|at| at + 1) else { return self.file.clone() };
        let before = name[..last].trim_end_matches('#');
        let digits = last + 1 - before.len();
        self.file.with_file_name(format!("{before}{frame:0digits$}{}", &name[last + 1..]))
    }

    /// What the files are.
    pub fn format(&self) -> PictureFormat {
        match &self.file {
            file if file == Path::new(STANDARD_OUTPUT) => PictureFormat::Ppm,
            file => PictureFormat::of(file).unwrap_or(PictureFormat::Png),
        }
    }

    /// Encodes a picture.
    fn encode(&self, out: impl Write, picture: &FrameBuffer) -> io::Result<()> {
        let size = [picture.size().width(), picture.size().height()];
        let format = self.format();
        if format == PictureFormat::Exr {
            let missing = || io::Error::other("this picture has no layers, which EXR files hold");
            return exr::encode(out, size, picture.layers().ok_or_else(missing)?);
        }
        let pixels: Box<dyn Iterator<Item = u32>> = match &self.sheet {
            None => Box::new(picture.pixels()),
            Some(sheet) => {
                // Sheets have their bytes the other way round.
                let mut pixels: Vec<u32> = picture.pixels().map(|pixel| pixel.swap_bytes() >> 8).collect();
                pixels.chunks_exact_mut(size[0]).enumerate().for_each(|(y, row)| sheet.cover(size, y, row));
                Box::new(pixels.into_iter().map(|pixel| (pixel << 8).swap_bytes()))
            }
        };
        match format {
            PictureFormat::Jpeg => jpeg::encode(out, size, pixels),
            PictureFormat::Ppm => ppm::encode(out, size, pixels),
            PictureFormat::Png | PictureFormat::Exr => png::encode(out, size, pixels),
        }
    }
}

/// Does the name of a file have a place for the numbers of frames, as [`PictureFile`] fills it?
pub fn is_numbered(file: &Path) -> bool {
    file.file_name().is_some_and(|name| name.to_string_lossy().contains("##"))
}

impl Display for PictureFile {
    fn name(&self) -> &str {
        Self::NAME
    }

    fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn Error + Send + Sync>> {
        let file = self.file(picture.frame);
        let written = if file == Path::new(STANDARD_OUTPUT) {
            self.encode(io::stdout().lock(), picture.buffer)
        } else {
            output::write(&file, |handle| self.encode(handle, picture.buffer))
        };
        written.map_err(|problem| PictureError::new(&file, problem))?;
        Ok(Shown::Continue)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_numbered_where_there_are_marks() {
        let names = ["a/##.png", "a/b-####.png", "#-##-#", "C#.png", "##a/b.png"];
        let files = names.map(|name| PictureFile::new(name).file(107));
        assert_eq!(files, ["a/107.png", "a/b-0107.png", "#-107-#", "C#.png", "##a/b.png"].map(PathBuf::from));
        assert_eq!(names.map(|name| is_numbered(name.as_ref())), [true, true, true, false, false]);
    }

    #[test]
    fn the_end_of_the_name_says_what_a_file_is() {
        let formats =
            ["a.png", "a.JPG", "b/a.jpeg", "a.ppm", "a-##.exr", "-", "a"].map(|name| PictureFile::new(name).format());
        use PictureFormat::{Exr, Jpeg, Png, Ppm};
        assert_eq!(formats, [Png, Jpeg, Jpeg, Ppm, Exr, Ppm, Png]);
    }
}
