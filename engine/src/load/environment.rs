//! Pictures that show everything around a scene.

use std::path::Path;

use super::{LoadError, picture};
use crate::background::Panorama;

/// How names of files end that may hold one.
pub const PICTURES: &[&str] = &["hdr", "exr", "png", "jpg", "jpeg", "tga"];

/// Does this name a picture?
pub fn is_picture(file: &Path) -> bool {
    let end = file.extension().and_then(|end| end.to_str());
    end.is_some_and(|end| PICTURES.iter().any(|known| known.eq_ignore_ascii_case(end)))
}

/// The picture of a file as a background, turned by degrees and multiplied: see [`Panorama::new`].
///
/// # Errors
/// If it cannot be read, or is not twice as wide as it is high, so that it does not show the whole sphere.
pub fn environment(file: &Path, rotate: f32, strength: f32) -> Result<Panorama, LoadError> {
    let picture = picture::read(file)?;
    let [width, height] = picture.size();
    // A texel more or less is what scaling may leave.
    if width.abs_diff(2 * height) > 1 + height / 64 {
        let problem =
            format!("{width}x{height} pixels are no picture of everything around, which is twice as wide as high");
        return Err(LoadError::new(file, problem, "name an equirectangular picture, also called latitude-longitude"));
    }
    Ok(Panorama::new(&picture, rotate, strength))
}
