//! Pictures in files, for textures and environments: PNG, JPEG, TGA, Radiance HDR and OpenEXR, through `image`.

use std::io::Cursor;
use std::path::Path;

use image::error::{ImageError, LimitErrorKind};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};

use super::{LoadError, input};
use crate::texture::{Picture, Texels};

/// A picture may have this many texels whatever its file's size...
const TEXELS_BASE: u64 = 1 << 22;
/// ... and this many for each byte of its file beyond that. One colour alone takes a byte for some hundred texels.
const TEXELS_RATIO: u64 = 1024;
/// Texels are at most so bright: sums of brighter ones would not be finite.
const BRIGHTEST: f32 = 1e9;
/// How much memory decoding a picture takes at most.
const MOST_BYTES: u64 = 4 << 30;

/// Reads and decodes a file.
///
/// # Errors
/// If it cannot be read, is in no format of those above, is broken, or is larger than its size justifies.
pub fn read(file: &Path) -> Result<Picture, LoadError> {
    if !input::is_regular(file) && file.exists() {
        return Err(LoadError::new(file, "is no regular file", "name a picture"));
    }
    let bytes = std::fs::read(file).map_err(|error| input::unreadable(file, &error))?;
    decode(&bytes, file.extension().and_then(|end| end.to_str()))
        .map_err(|problem| LoadError::new(file, problem, "open it in an image editor and save it again as PNG or JPEG"))
}

/// Decodes the bytes of a file, which are known by their start; where that says nothing (TGA), by how its name ends.
///
/// # Errors
/// What is wrong with them.
pub fn decode(bytes: &[u8], extension: Option<&str>) -> Result<Picture, String> {
    let known = image::guess_format(bytes).ok();
    let format = known.or_else(|| extension.and_then(ImageFormat::from_extension));
    let format = format.filter(ImageFormat::reading_enabled).ok_or("this is no PNG, JPEG, TGA, HDR or EXR picture")?;
    let reader = || {
        let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
        let mut limits = Limits::default();
        limits.max_alloc = Some(MOST_BYTES);
        reader.limits(limits);
        reader
    };
    let (width, height) = reader().into_dimensions().map_err(|error| explain(&error))?;
    let texels = u64::from(width) * u64::from(height);
    if texels == 0 {
        return Err(format!("the picture has {width}x{height} pixels"));
    }
    if width.max(height) > Picture::MOST {
        return Err(format!("the picture has {width}x{height} pixels, more than {} along a side", Picture::MOST));
    }
    if texels > TEXELS_BASE + TEXELS_RATIO * bytes.len() as u64 {
        return Err(format!("{width}x{height} pixels are out of proportion to the file's {} bytes", bytes.len()));
    }
    let decoded = reader().decode().map_err(|error| explain(&error))?;
    let floats = matches!(decoded, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
    let size = [decoded.width(), decoded.height()];
    let texels = if floats {
        let sound = |x: &f32| if x.is_nan() { 0.0 } else { x.clamp(0.0, BRIGHTEST) };
        let texels = decoded.into_rgba32f().into_raw();
        Texels::Floats(texels.as_chunks::<4>().0.iter().map(|texel| texel.each_ref().map(sound)).collect())
    } else {
        // With room for the smaller copies that a texture appends.
        let count = size[0] as usize * size[1] as usize;
        let mut texels = Vec::with_capacity(count + count / 3 + 16);
        match decoded {
            DynamicImage::ImageRgb8(picture) => {
                texels.extend(picture.as_raw().as_chunks().0.iter().map(|&[r, g, b]| [r, g, b, 255]));
            }
            other => texels.extend_from_slice(other.into_rgba8().as_raw().as_chunks().0),
        }
        Texels::Bytes(texels)
    };
    Picture::new(size, texels).ok_or_else(|| "the picture is not whole".into())
}

fn explain(error: &ImageError) -> String {
    match error {
        ImageError::Limits(limit) if matches!(limit.kind(), LimitErrorKind::DimensionError) => {
            "the picture is too large".into()
        }
        ImageError::Limits(_) => format!("decoding it takes more than {} GiB", MOST_BYTES >> 30),
        error => format!("the picture is broken ({error})"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(format: ImageFormat, picture: &DynamicImage) -> Vec<u8> {
        let mut bytes = Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        bytes.into_inner()
    }

    #[test]
    fn pictures_of_all_formats_are_decoded() {
        let bytes = DynamicImage::from(image::RgbaImage::from_fn(5, 3, |x, y| {
            image::Rgba([x as u8 * 50, y as u8 * 100, 7, 255])
        }));
        let floats =
            DynamicImage::from(image::Rgb32FImage::from_fn(5, 3, |x, y| image::Rgb([x as f32, y as f32 * 0.5, 4.0])));
        for (format, end) in [(ImageFormat::Png, "png"), (ImageFormat::Tga, "tga")] {
            let picture = decode(&encoded(format, &bytes), Some(end)).unwrap();
            assert_eq!(picture.size(), [5, 3]);
            assert_eq!(
                picture.texels(),
                &Texels::Bytes((0..15).map(|i| [i % 5 * 50, i / 5 * 100, 7, 255]).collect()),
                "{end}"
            );
        }
        let jpeg = decode(&encoded(ImageFormat::Jpeg, &bytes.to_rgb8().into()), None).unwrap();
        assert_eq!((jpeg.size(), jpeg.texels().len()), ([5, 3], 15));
        for format in [ImageFormat::Hdr, ImageFormat::OpenExr] {
            let picture = decode(&encoded(format, &floats), None).unwrap();
            let expected = (0..15).map(|i| [(i % 5) as f32, (i / 5) as f32 * 0.5, 4.0, 1.0]).collect();
            assert_eq!(picture.texels(), &Texels::Floats(expected), "{format:?}");
        }
    }

    #[test]
    fn what_is_no_picture_is_told() {
        assert!(decode(b"", None).unwrap_err().contains("no PNG"));
        assert!(decode(b"hello, world", Some("txt")).unwrap_err().contains("no PNG"));
        let png = encoded(ImageFormat::Png, &DynamicImage::new_rgb8(40, 30));
        for cut in [9, 20, 40, png.len() - 20] {
            assert!(decode(&png[..cut], None).unwrap_err().contains("broken"), "{cut}");
        }
        // A header that promises more than the file can hold.
        let mut vast = encoded(ImageFormat::Hdr, &DynamicImage::new_rgb32f(4, 4));
        let at = vast.windows(2).position(|two| two == b"-Y").unwrap();
        vast.splice(at..at + 9, *b"-Y 20000 +X 20000");
        let error = decode(&vast, None).unwrap_err();
        assert!(error.contains("proportion") || error.contains("broken"), "{error}");
    }
}
