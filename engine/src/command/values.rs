//! Values on the command line: from words to what they mean, or to what would be right.

use std::fmt;
use std::path::PathBuf;
use std::sync::Arc;

use mobula::background::{self, Background, BackgroundKind, Daylight};
use mobula::camera::Up;
use mobula::choice::list;
use mobula::color;
use mobula::display::{PictureFormat, STANDARD_OUTPUT};
use mobula::image::Size;
use mobula::load::{PICTURES, is_picture};
use mobula::medium::{Fog, LEAST_STEP};
use mobula::pipeline::MAX_THREADS;
use mobula::sampler::{SamplerKind, Sobol};
use mobula::tone::Tone;
use mobula::volume::Preset;

/// An axis, or a guess.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct UpChoice(pub(super) Option<Up>);

/// A value, and the words that it was given in.
#[derive(Clone, Debug)]
pub(super) struct Given<T> {
    #[cfg_attr(not(feature = "window"), allow(dead_code, reason = "for windows"))]
    pub(super) words: String,
    pub(super) value: T,
}

pub(super) fn as_given<T>(parse: fn(&str) -> Result<T, String>) -> impl Fn(&str) -> Result<Given<T>, String> + Clone {
    move |words| parse(words).map(|value| Given { words: words.to_owned(), value })
}

/// A word as a shell takes it.
#[cfg(feature = "window")]
pub(super) fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-+=:,./%@".contains(c);
    if word.contains(char::is_control) {
        // As bash, zsh and others read it; bytes, so that no control character is shown.
        let bytes = word.bytes().map(|b| {
            if b.is_ascii_graphic() && !b"'\\".contains(&b) { char::from(b).to_string() } else { format!("\\x{b:02x}") }
        });
        return format!("$'{}'", bytes.collect::<String>());
    }
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}

/// A transfer function, by name.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Transfer {
    Preset(Preset),
    Labels,
    File(PathBuf),
}

pub(super) fn transfer(text: &str) -> Result<Transfer, String> {
    if text.eq_ignore_ascii_case("labels") {
        return Ok(Transfer::Labels);
    }
    Ok(text.parse().map_or_else(|_| Transfer::File(text.into()), Transfer::Preset))
}

impl fmt::Display for Transfer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Preset(preset) => preset.fmt(f),
            Self::Labels => f.write_str("labels"),
            Self::File(file) => file.display().fmt(f),
        }
    }
}

/// The middle of a range of values, and its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Window(pub(super) [f64; 2]);

pub(super) fn window(text: &str) -> Result<Window, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[level, width]) if level.is_finite() && width.is_finite() && width > 0.0 => Ok(Window([level, width])),
        _ => Err("write two numbers with a comma between them, the second above 0, such as 40,400".into()),
    }
}

/// Three lengths above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lengths(pub(super) [f64; 3]);

pub(super) fn lengths(text: &str) -> Result<Lengths, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if [x, y, z].iter().all(|x| x.is_finite() && *x > 0.0) => Ok(Lengths([x, y, z])),
        _ => Err("write three numbers above 0 with commas between them, such as 0.5,0.5,1.25".into()),
    }
}

/// When media of volumes are lit.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shading {
    /// As goes with the transfer function
    Auto,
    /// Lit by the lights
    On,
    /// They glow
    Off,
}

pub(super) fn step_length(text: &str) -> Result<f32, String> {
    let cells = text.parse().ok().filter(|cells: &f32| (LEAST_STEP..=16.0).contains(cells));
    cells.ok_or_else(|| format!("give a number from {LEAST_STEP} to 16"))
}

pub(super) fn size(text: &str) -> Result<Size, String> {
    let side = |text: &str| {
        let digits = !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
        // More digits than a usize holds are too large in any case.
        let side = digits.then(|| text.parse().unwrap_or(usize::MAX));
        side.ok_or_else(|| "write it as WIDTHxHEIGHT, such as 1024x768".to_owned())
    };
    let (width, height) = match text.split_once(['x', 'X', '×', '*', ',']) {
        Some((width, height)) => (side(width.trim())?, side(height.trim())?),
        None => side(text).map(|width| (width, if width < 2 { width } else { width.saturating_mul(3) / 4 }))?,
    };
    Size::new(width, height).map_err(|error| error.to_string())
}

pub(super) fn at_least_one(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|count| *count > 0).ok_or_else(|| "give a whole number, 1 or more".to_owned())
}

pub(super) fn channels(text: &str) -> Result<u16, String> {
    text.parse().ok().filter(|count| (1..=64).contains(count)).ok_or_else(|| "give a number from 1 to 64".to_owned())
}

pub(super) fn threads(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|count| (1..=MAX_THREADS).contains(count));
    count.ok_or_else(|| format!("there can be 1 to {MAX_THREADS} threads"))
}

pub(super) fn samples(text: &str) -> Result<SamplerKind, String> {
    let count = text.parse().ok().filter(|count| (1..=Sobol::MOST).contains(count));
    count.map(SamplerKind::of_samples).ok_or_else(|| format!("there can be 1 to {} samples", Sobol::MOST))
}

pub(super) fn threshold(text: &str) -> Result<f64, String> {
    let threshold = text.parse().ok().filter(|threshold| (1e-6..=1.0).contains(threshold));
    threshold.ok_or_else(|| "give a number from 0.000001 to 1, such as 0.005".into())
}

/// Where the only light is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum LightChoice {
    At(Point),
    /// With the camera.
    Camera,
}

impl fmt::Display for LightChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::At(Point([x, y, z])) => write!(f, "{x},{y},{z}"),
            Self::Camera => f.write_str("camera"),
        }
    }
}

pub(super) fn light(text: &str) -> Result<LightChoice, String> {
    if text.eq_ignore_ascii_case("camera") {
        return Ok(LightChoice::Camera);
    }
    point(text).map(LightChoice::At).map_err(|problem| format!("{problem}, or camera"))
}

/// A point with the numbers of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Point(pub(super) [f64; 3]);

pub(super) fn point(text: &str) -> Result<Point, String> {
    let parts: Vec<&str> = text.split([',', ' ']).filter(|part| !part.is_empty()).collect();
    let numbers: Vec<f64> = parts.iter().filter_map(|part| finite(part).ok()).collect();
    match numbers[..] {
        [x, y, z] if parts.len() == 3 && !text.contains(",,") => Ok(Point([x, y, z])),
        _ => Err("write three numbers with commas between them, such as 1,2.5,-3".into()),
    }
}

pub(super) fn finite(text: &str) -> Result<f64, String> {
    let number = text.trim().parse().ok().filter(|number: &f64| number.is_finite());
    number.ok_or_else(|| "give numbers with commas between them, such as 300 or -200,300".into())
}

pub(super) fn exposure(text: &str) -> Result<f32, String> {
    let most = Tone::MOST_EXPOSURE;
    let stops = text.trim().parse().ok().filter(|stops: &f32| stops.abs() <= most);
    stops.ok_or_else(|| format!("give a number from -{most} to {most}"))
}

pub(super) fn reach(text: &str) -> Result<f64, String> {
    let reach = text.trim().parse().ok().filter(|reach: &f64| *reach >= 0.0);
    reach.ok_or_else(|| "give a distance from 0 on, or inf".into())
}

pub(super) fn part(text: &str) -> Result<f32, String> {
    let part = text.trim().parse().ok().filter(|part| (0.0..=1.0).contains(part));
    part.ok_or_else(|| "give numbers from 0 (opaque) to 1 with commas between them".into())
}

/// A plane (a, b, c, d) with the points where a x + b y + c z = d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Plane(pub(super) [f64; 4]);

pub(super) fn plane(text: &str) -> Result<Plane, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|number| finite(number).ok()).collect();
    match numbers[..] {
        [a, b, c, d] if text.split(',').count() == 4 && [a, b, c] != [0.0; 3] => Ok(Plane([a, b, c, d])),
        _ => Err("give four numbers, the first three not all 0, such as 1,0,0,0.5 for what is right of x = 0.5".into()),
    }
}

pub(super) fn fov(text: &str) -> Result<f32, String> {
    let angle = text.parse().ok().filter(|angle| (1.0..=360.0).contains(angle));
    angle.ok_or_else(|| "give an angle from 1 to 170 degrees, for a fisheye camera to 360".into())
}

pub(super) fn radius(text: &str) -> Result<f64, String> {
    let radius = text.parse().ok().filter(|radius| (0.0..=1e30).contains(radius));
    radius.ok_or_else(|| "give a number, 0 or more".into())
}

pub(super) fn focus(text: &str) -> Result<f64, String> {
    let distance = text.parse().ok().filter(|distance| *distance > 0.0 && *distance <= 1e30);
    distance.ok_or_else(|| "give a number above 0".into())
}

pub(super) fn crease(text: &str) -> Result<f32, String> {
    let angle = text.parse().ok().filter(|angle| (0.0..=180.0).contains(angle));
    angle.ok_or_else(|| "give an angle from 0 (facets) to 180 degrees".into())
}

pub(super) fn distance(text: &str) -> Result<f32, String> {
    let distance = text.parse().ok().filter(|distance: &f32| distance.is_finite() && *distance > 0.0);
    distance.ok_or_else(|| "give a number above 0".into())
}

pub(super) fn up(text: &str) -> Result<UpChoice, String> {
    match text {
        "y" => Ok(UpChoice(Some(Up::Y))),
        "z" => Ok(UpChoice(Some(Up::Z))),
        "auto" => Ok(UpChoice(None)),
        _ => Err("the axes are y, z and auto".into()),
    }
}

/// What is seen where nothing is.
#[derive(Clone, Debug)]
pub(super) enum BackgroundChoice {
    Plain(Arc<dyn Background>),
    /// A picture of everything around.
    File(PathBuf),
}

pub(super) fn background(text: &str) -> Result<BackgroundChoice, String> {
    if let Some(background) = background::parse(text) {
        return Ok(BackgroundChoice::Plain(background));
    }
    if is_picture(text.as_ref()) {
        return Ok(BackgroundChoice::File(text.into()));
    }
    let names = BackgroundKind::NAMES.join(", ");
    let [least, most] = [Daylight::TURBIDITIES.start(), Daylight::TURBIDITIES.end()];
    Err(format!(
        "give {names}, three numbers from 0 to 1 such as 0.1,0.2,0.3, #rrggbb, a picture ({}), or daylight: with the elevation of the sun \
         (0 to 90 degrees), its azimuth, and turbidity ({least} to {most}), such as daylight:30,200",
        PICTURES.join(", ")
    ))
}

pub(super) fn fog(text: &str) -> Result<Fog, String> {
    let usage = || {
        "give a density of at least 0, or a density and a colour such as 0.05,0.6,0.7,0.8 or 0.05,#aabbcc".to_owned()
    };
    let (density, tint) = text.split_once(',').map_or((text, None), |(density, tint)| (density, Some(tint)));
    let density = density.trim().parse().ok().filter(|density: &f32| density.is_finite() && *density >= 0.0);
    let fog = Fog::new(density.ok_or_else(usage)?);
    match tint {
        None => Ok(fog),
        Some(tint) => color::parse(tint).map(|color| Fog { color, ..fog }).ok_or_else(usage),
    }
}

pub(super) fn rate(text: &str) -> Result<f64, String> {
    let rate = text.parse().ok().filter(|rate| (1e-3..=1e6).contains(rate));
    rate.ok_or_else(|| "give a number of frames a second, such as 25".into())
}

pub(super) fn picture(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if text.is_empty() {
        return Err("give the name of a file".to_owned());
    }
    if text == STANDARD_OUTPUT {
        return Ok(path);
    }
    if path.is_dir() || path.file_name().is_none() || text.ends_with('/') {
        let end = if text.ends_with('/') { "" } else { "/" };
        return Err(format!("that is a folder; name a file in it, such as {text}{end}mobula.png"));
    }
    let device = path.metadata().is_ok_and(|there| !there.is_file());
    if device || PictureFormat::of(&path).is_some() {
        return Ok(path);
    }
    const OTHERS: [&str; 8] = ["hdr", "pfm", "tga", "tif", "tiff", "bmp", "webp", "gif"];
    let end = path.extension().map(|end| end.to_string_lossy().to_ascii_lowercase());
    let name = match end {
        Some(end) if OTHERS.contains(&&*end) => path.with_extension("png").display().to_string(),
        _ => format!("{text}.png"),
    };
    let ends = PictureFormat::ALL.iter().flat_map(|format| format.extensions()).copied().collect::<Vec<_>>();
    Err(format!("names of pictures end in {}; name it {name}", list(&ends)))
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    #[test]
    fn sizes_are_checked() {
        for (text, width, height) in [("640x480", 640, 480), ("640 × 480", 640, 480), ("800", 800, 600), ("1", 1, 1)] {
            assert_eq!(size(text), Ok(Size::new(width, height).unwrap()), "{text}");
        }
        for (text, expected) in [
            ("0x0", "at least 1"),
            ("100000x100000", "at most"),
            ("99999999999999999999999x1", "at most"),
            ("640x", "WIDTHxHEIGHT"),
            ("-1x5", "WIDTHxHEIGHT"),
            ("6.5x5", "WIDTHxHEIGHT"),
            ("", "WIDTHxHEIGHT"),
        ] {
            assert!(size(text).unwrap_err().contains(expected), "{text}");
        }
    }

    #[test]
    fn values_are_checked() {
        assert_eq!(point("1,-2.5, 3e1"), Ok(Point([1.0, -2.5, 30.0])));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "nan,0,0", "1,,2,3"] {
            assert!(point(bad).is_err(), "{bad}");
        }
        assert_eq!(samples("1"), Ok(SamplerKind::Single));
        assert_eq!(samples("16"), Ok(SamplerKind::of_samples(16)));
        for bad in ["0", "65537", "1.5", "-4", "4294967296"] {
            assert!(samples(bad).is_err(), "{bad}");
        }
        assert!(threads("0").is_err() && threads("1025").is_err() && threads("two").is_err());
        assert!(background("2,0,0").is_err() && background("pink").is_err() && background("1,0,0.5").is_ok());
        for (text, expected) in [("#ff8800", [255, 136, 0]), ("FF8800", [255, 136, 0]), ("#f80", [255, 136, 0])] {
            assert_eq!(color::parse(text), Some(color::from_srgb8(expected)), "{text}");
        }
        for bad in ["#ff88", "f80", "#+ff880", "#ff880g", "ff", ""] {
            assert_eq!(color::parse(bad), None, "{bad}");
        }
        assert_eq!(fog("0.5").unwrap().density, 0.5);
        assert_eq!(fog("0.5,#ffffff").unwrap().color, Vec3::ONE);
        assert_eq!(fog("0.5,1,0,0.25").unwrap().color, Vec3::new(1.0, 0.0, 0.25));
        for bad in ["", "-1", "nan", "1,", "1,2,0,0", "1,0,0", "x"] {
            assert!(fog(bad).is_err(), "{bad}");
        }
        for (name, expected) in [
            ("a.gif", "name it a.png"),
            ("b/a", "name it b/a.png"),
            ("a.b", "name it a.b.png"),
            (".", "such as ./mobula.png"),
            ("none/", "such as none/mobula.png"),
        ] {
            assert!(picture(name).unwrap_err().ends_with(expected), "{name}: {:?}", picture(name));
        }
        assert!(["b.PNG", "####.png", "a.jpg", "a.exr", "-"].iter().all(|name| picture(name).is_ok()));
        assert_eq!(lengths("0.5,1,2"), Ok(Lengths([0.5, 1.0, 2.0])));
        for bad in ["", "1,1", "1,0,1", "1,nan,1", "1,-1,1", "1,inf,1"] {
            assert!(lengths(bad).is_err(), "{bad}");
        }
        assert_eq!(["0", "30", "180"].map(crease), [Ok(0.0), Ok(30.0), Ok(180.0)]);
        for bad in ["", "-1", "181", "nan", "30 degrees"] {
            assert!(crease(bad).is_err(), "{bad}");
        }
        #[cfg(feature = "window")]
        assert_eq!(["a/b.obj", "a b", "it's", ""].map(quoted), ["a/b.obj", "'a b'", r"'it'\''s'", "''"]);
    }
}
