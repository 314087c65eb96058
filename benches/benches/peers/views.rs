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
    /// Field of view in degrees.
    #[arg(long, default_value_t = 40.0, requires = "mesh")]
    fov: f32,
    /// Pixels a side, a multiple of 16.
    #[arg(long, default_value_t = 1024, requires = "mesh")]
    resolution: u32,
}

/// The views of a list: options as on the command line, a view a line.
pub(crate) fn of_list(file: &Path) -> Result<Vec<ViewOptions>, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let lines = text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let view = |(number, line): (usize, &str)| {
        let words = std::iter::once("view").chain(line.split_whitespace());
        let options = ViewOptions::try_parse_from(words);
        let wrong = |problem: &str| format!("{}:{}: {problem}", file.display(), number + 1);
        let options = options.map_err(|error| wrong(error.to_string().lines().next().unwrap_or_default()))?;
        options.mesh.is_some().then_some(options).ok_or_else(|| wrong("there is no --mesh"))
    };
    lines.map(view).collect()
}

impl ViewOptions {
    /// The view and what is seen; `None` if there is no file. Light comes from the upper left of it.
    pub(crate) fn view(&self) -> Result<Option<(View, Primitives)>, String> {
        let Some(source) = &self.mesh else { return Ok(None) };
        let scene = scenes::scene(source, Path::new(""))?;
        let primitives = Primitives::of(&scene);
        let built = mobula::scene::build(&scene, mobula::accel::AccelerationKind::Brute).map_err(|e| e.to_string())?;
        let framed = built.view(1.0);
        let point = |given: &[f32], usual: glam::Vec3, name: &str| match given {
            [] => Ok(usual.to_array()),
            &[x, y, z] => Ok([x, y, z]),
            _ => Err(format!("--{name} is three numbers: X,Y,Z")),
        };
        let (eye, at) = (point(&self.eye, framed.eye, "eye")?, point(&self.at, framed.at, "at")?);
        if self.resolution == 0 || self.resolution % 16 != 0 {
            return Err(format!("--resolution {}: not a multiple of 16", self.resolution));
        }
        let (low, high) = built.bulk;
        let size = (high - low).length();
        let up = built.up.vector();
        let right = (framed.at - framed.eye).cross(up).normalize_or_zero();
        let to_light = up * 1.7 - right * 0.8 - (framed.at - framed.eye).normalize_or_zero();
        let stem =
            PathBuf::from(source).file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let name = format!("{}_{}", stem.split('.').next().unwrap_or_default().replace(':', "_"), self.resolution);
        let view = View {
            name: name.leak(),
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
