//! Textures of the materials of a scene file.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use toml::Spanned;
use toml::de::DeValue;

use super::keys::LaidTexture;
use super::text::{Text, shortened};
use crate::load::textures::{Use, texture};
use crate::load::{LoadError, input};
use crate::texture::{Map, Maps, NormalMap, OpacityMap, Wrap};

/// Takes the textures that most materials may have out of the table of one.
pub(super) fn maps(text: &Text<'_>, material: &mut Spanned<DeValue<'_>>) -> Result<Maps, LoadError> {
    let color = take(text, material, "texture", Use::Color)?;
    let normal = take(text, material, "normal_map", Use::Bumps)?;
    let opacity = take(text, material, "opacity_map", Use::Data)?;
    let holes = color.as_ref().filter(|map| map.texture.has_alpha());
    let alpha = holes.map(|map| OpacityMap { map: map.clone(), channel: 3, factor: 1.0, cutoff: None });
    let opacity = opacity.map(|map| {
        let channel = if map.texture.has_alpha() { 3 } else { 0 };
        OpacityMap { map, channel, factor: 1.0, cutoff: None }
    });
    Ok(Maps { color, normal: normal.map(|map| NormalMap { map, scale: 1.0 }), opacity: opacity.or(alpha) })
}

/// Takes the texture of a key out of the table of a material: the name of a file, or a table.
pub(super) fn take(
    text: &Text<'_>,
    material: &mut Spanned<DeValue<'_>>,
    key: &str,
    what: Use,
) -> Result<Option<Map>, LoadError> {
    let DeValue::Table(table) = material.get_mut() else { return Ok(None) };
    let Some(value) = table.remove(key) else { return Ok(None) };
    let span = value.span();
    let laid = match value.get_ref() {
        DeValue::String(name) => LaidTexture { file: Spanned::new(span, name.to_string()), ..LaidTexture::default() },
        _ => text.read(value)?,
    };
    let read = crate::load::picture::read(&picture(text, &laid.file)?)?;
    let [across, up] = laid.repeat.map_or([1.0; 2], |both| both.map(|x| x.0 as f32));
    let wrap = if laid.clamp { Wrap::Clamp } else { Wrap::Repeat };
    let offset = laid.offset.map_or([0.0; 2], |both| both.map(|x| x.0 as f32));
    let turn = [[across, 0.0], [0.0, up]];
    Ok(Some(Map { wrap: [wrap; 2], turn, offset, ..Map::new(Arc::new(texture(read, what))) }))
}

/// The file of a picture: a regular one only, since a name could be that of a pipe or a device.
pub(super) fn picture(text: &Text<'_>, name: &Spanned<String>) -> Result<PathBuf, LoadError> {
    let file = text.file.parent().unwrap_or(Path::new("")).join(name.get_ref());
    let there = !name.get_ref().contains('\0') && input::is_regular(&file);
    there.then_some(file).ok_or_else(|| {
        let problem = format!("there is no file \"{}\"", shortened(name.get_ref()));
        text.error(name.span(), problem, "name it as seen from the folder of the scene file")
    })
}
