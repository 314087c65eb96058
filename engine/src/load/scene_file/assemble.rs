//! The scene of a file.

use std::io::Read;
use std::path::Path;

use serde::Deserialize;

use super::keys::Head;
use super::lights;
use super::named::Definitions;
use super::objects::{self, Building};
use super::parts::Parts;
use super::surroundings;
use super::text::Text;
use crate::load::loaded::display_name;
use crate::load::{Load, LoadError, Loaded, Options, Report, input};
use crate::scene::SceneDescription;

/// A larger file is no scene file: what is large belongs in files of its own.
const LARGEST: u64 = 1 << 20;
/// How a scene file starts.
const FIRST: &str = "a scene file starts with the line: mobula = 1";

/// Does the start of a file look like a scene file? The first line that is no comment says so.
pub(crate) fn looks_like(start: &[u8]) -> bool {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let lines = start.split(|&byte| byte == b'\n').map(<[u8]>::trim_ascii);
    let first = lines.into_iter().find(|line| !line.is_empty() && !line.starts_with(b"#"));
    let after = first.and_then(|line| line.strip_prefix(b"mobula"));
    after.is_some_and(|rest| rest.trim_ascii_start().starts_with(b"="))
}

/// Loads a scene file, and with `part` the files that it names.
/// `format` is what reports call the format.
pub(crate) fn load(
    file: &Path,
    mut input: input::Input,
    options: &Options,
    format: &'static str,
    part: Load,
) -> Result<Loaded, LoadError> {
    let mut bytes = Vec::new();
    if let Err(error) = (&mut input.reader).take(LARGEST + 1).read_to_end(&mut bytes) {
        let (problem, remedy) = input::explain(&error, input.gzip);
        return Err(LoadError::new(file, problem, remedy));
    }
    if bytes.len() as u64 > LARGEST {
        let problem = format!("is larger than {} MiB: this is no scene file", LARGEST >> 20);
        return Err(LoadError::new(file, problem, "put what is large in files of its own, and name them"));
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| {
        let line = 1 + bytes[..error.valid_up_to()].iter().filter(|&&byte| byte == b'\n').count();
        LoadError::new(file, "this is not UTF-8 text", FIRST).at(line as u64)
    })?;
    let mut loaded = assemble(Text { file, text }, options, part)?;
    loaded.report.format = format;
    loaded.report.warnings.extend(input.warning(file));
    Ok(loaded)
}

fn assemble(text: Text<'_>, options: &Options, part: Load) -> Result<Loaded, LoadError> {
    let mut file = text.parse()?;
    let version = file.remove_entry("mobula");
    let Some((key, version)) = version else {
        return Err(LoadError::new(text.file, "this is no scene file of Mobula", FIRST).at(1));
    };
    if file.keys().any(|other| other.span().start < key.span().start) {
        return Err(text.error(key.span(), "this is not the first line", FIRST));
    }
    if version.get_ref().as_integer().and_then(|version| version.as_str().parse().ok()) != Some(1) {
        let remedy = "write mobula = 1, or use the version of Mobula that the file is for";
        return Err(text.error(version.span(), "this version of scene files is not known", remedy));
    }
    let head = toml::Deserializer::parse(text.text).and_then(Head::deserialize);
    let head = head.map_err(|error| text.explained(&error, 0..0))?;
    let named = Definitions::read(&text, &mut file)?;
    let lights = lights::lights(&text, &mut file)?;
    let objects = objects::read(&text, &mut file, &named)?;

    let scene = SceneDescription {
        name: display_name(text.file),
        materials: named.materials.iter().map(|defined| defined.named.clone()).collect(),
        ..SceneDescription::default()
    };
    let smooth = options.smooth.or(head.smooth.map(|angle| angle.0 as f32));
    let options = Options { smooth, ..options.clone() };
    let parts = Parts::new(text, &options, part);
    let mut building = Building { text, named: &named, parts, scene, report: Report::default() };
    building.add_all(&objects)?;
    let Building { parts, mut scene, report, .. } = building;
    let place = parts.place();
    if place.scale != 1.0 {
        for named in &mut scene.materials {
            named.material = named.material.scaled(place.scale as f32).unwrap_or_else(|| named.material.clone());
        }
    }
    surroundings::add(&text, &head, &lights, &place, &mut scene)?;
    Ok(Loaded { scene, report, place })
}
