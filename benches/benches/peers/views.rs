//! Scenes that nobody thought of: any file, looked at from anywhere.

use std::path::{Path, PathBuf};

use clap::Parser;
use mobula_benches::scenes::{self, Far, Primitives, View};

/// A file and a view of it.
#[derive(Clone, Debug, Default, Parser)]
pub(crate) struct ViewOptions {
    /// Another scene: a file that Mobula loads, or gen:NAME. Others than this are then measured only if --scene names them.
    #[arg(long, value_name = "FILE")]
    pub(crate) mesh: Option<String>,
    /// Where the rays start; where nothing is said, all is in the picture.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, requires = "mesh")]
    eye: Vec<f32>,
    /// What is in the middle of the picture.
    #[arg(long, value_delimiter = ',', allow_hyphen_values = true, requires = "mesh")]
    at: Vec<f32>,
    /// Field of view in degrees, more than 0 and at most 170.
    #[arg(long, default_value_t = 40.0, requires = "mesh", allow_hyphen_values = true)]
    fov: f32,
    /// Pixels a side, a multiple of 16, at most 16384.
    #[arg(long, default_value_t = 1024, requires = "mesh", allow_hyphen_values = true)]
    resolution: u32,
}

/// Pixels a side of the largest picture.
const MOST_PIXELS: u32 = 1 << 14;
/// Where eyes may be: farther away, the squares of distances are no numbers.
const FARTHEST: f32 = 1e15;

/// The views of a list: options as on the command line, a view a line.
pub(crate) fn of_list(file: &Path) -> Result<Vec<ViewOptions>, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let text = text.trim_start_matches('\u{feff}');
    let without_comment = |line: &'_ str| line.split(" #").next().unwrap_or_default().trim().to_owned();
    let lines = text.lines().map(without_comment).enumerate();
    let lines = lines.filter(|(_, line)| !line.is_empty() && !line.starts_with('#'));
    let view = |(number, line): (usize, String)| {
        let words = std::iter::once("view").chain(line.split_whitespace());
        let options = ViewOptions::try_parse_from(words);
        let wrong = |problem: &str| format!("{}:{}: {problem}", file.display(), number + 1);
        let options = options.map_err(|error| wrong(&one_line(&error.to_string())))?;
        if options.mesh.is_none() {
            return Err(wrong("there is no --mesh"));
        }
        options.check().map_err(|problem| wrong(&problem))?;
        Ok(options)
    };
    let views: Vec<_> = lines.map(view).collect::<Result<_, String>>()?;
    if views.is_empty() {
        return Err(format!("{}: there is no view in it", file.display()));
    }
    Ok(views)
}

/// What is wrong, without how the options are used.
fn one_line(message: &str) -> String {
    let lines = message.lines().map(str::trim).take_while(|line| !line.is_empty());
    lines.collect::<Vec<_>>().join(" ").trim_start_matches("error: ").to_owned()
}

impl ViewOptions {
    /// Checks what can be checked without the file.
    pub(crate) fn check(&self) -> Result<(), String> {
        let Some(source) = &self.mesh else { return Ok(()) };
        if !source.starts_with(mobula::generate::PREFIX) && !Path::new(source).exists() {
            return Err(format!("there is no file {source}"));
        }
        for (name, point) in [("eye", &self.eye), ("at", &self.at)] {
            if !matches!(point[..], [] | [_, _, _]) {
                return Err(format!("--{name} is three numbers: X,Y,Z"));
            }
            // Neither is a NaN.
            if !point.iter().all(|x| x.abs() <= FARTHEST) {
                return Err(format!("--{name}: a number is not from -{FARTHEST:e} to {FARTHEST:e}"));
            }
        }
        if !(self.fov > 0.0 && self.fov <= 170.0) {
            return Err(format!("--fov {}: not more than 0 and at most 170 degrees", self.fov));
        }
        if self.resolution == 0 || !self.resolution.is_multiple_of(16) || self.resolution > MOST_PIXELS {
            return Err(format!("--resolution {}: not a multiple of 16 from 16 to {MOST_PIXELS}", self.resolution));
        }
        Ok(())
    }

    /// The view, as options.
    pub(crate) fn words(&self) -> String {
        let point = |name: &str, point: &[f32]| match point {
            [x, y, z] => format!(" --{name} {x},{y},{z}"),
            _ => String::new(),
        };
        // Without the folder: it says nothing to others.
        let file = self.mesh.as_deref().unwrap_or_default().rsplit('/').next().unwrap_or_default();
        let (eye, at) = (point("eye", &self.eye), point("at", &self.at));
        format!("--mesh {file}{eye}{at} --fov {} --resolution {}", self.fov, self.resolution)
    }

    /// What rows of the view are called, before others of that name.
    pub(crate) fn name(&self) -> String {
        let file = PathBuf::from(self.mesh.as_deref().unwrap_or_default());
        let stem = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        format!("{}_{}", stem.split('.').next().unwrap_or_default().replace(':', "_"), self.resolution)
    }

    /// The view and what is seen; `None` if there is no file. Light comes from the upper left of it.
    pub(crate) fn view(&self, name: &str) -> Result<Option<(View, Primitives)>, String> {
        let Some(source) = &self.mesh else { return Ok(None) };
        let scene = scenes::scene(source, Path::new(""))?;
        let primitives = Primitives::of(&scene);
        let built = mobula::scene::build(&scene, mobula::accel::AccelerationKind::Brute).map_err(|e| e.to_string())?;
        let framed = built.view(1.0);
        let point = |given: &[f32], usual: glam::Vec3| given.try_into().unwrap_or(usual.to_array());
        let (eye, at) = (point(&self.eye, framed.eye), point(&self.at, framed.at));
        if eye == at {
            return Err(format!("{source}: --eye and --at are one point: nothing says where to look"));
        }
        let (low, high) = built.bulk;
        let size = (high - low).length();
        let up = built.up.vector();
        let right = (framed.at - framed.eye).cross(up).normalize_or_zero();
        let to_light = up * 1.7 - right * 0.8 - (framed.at - framed.eye).normalize_or_zero();
        let view = View {
            name: name.to_owned().leak(),
            source: source.clone().leak(),
            eye,
            at,
            up: up.to_array(),
            tangent: (self.fov.to_radians() / 2.0).tan(),
            pixels: self.resolution,
            light: ((low + high) / 2.0 + to_light * size).to_array(),
            sun: to_light.to_array(),
            reach: 0.1 * size,
            offset: 1e-4 * size,
            known: None,
            far: Far::Nothing,
        };
        Ok(Some((view, primitives)))
    }
}
