//! Materials of a document (glTF 2.0, section 3.9), and their textures.

use std::collections::HashMap;
use std::path::Path;
use std::sync::Arc;

use glam::Vec3;
use gltf::material::AlphaMode;
use gltf::texture::{Info, TextureTransform, WrappingMode};
use gltf::{Document, image};
use serde_json::Value;

use super::buffers::Buffers;
use super::container::fetch;
use crate::load::picture;
use crate::load::textures::{Use, at_once, texture};
use crate::material::{Dielectric, Flat, Material, NamedMaterial, Principled, ThinDielectric};
use crate::progress::Progress;
use crate::texture::{Map, Maps, NormalMap, OpacityMap, Texture, Wrap};

/// The textures of a document, by the number of the image and what it is for.
pub(super) struct Textures {
    decoded: HashMap<(usize, Use), Arc<Texture>>,
}

impl Textures {
    /// Decodes all images that materials name. Those that cannot be are told.
    pub(super) fn read(
        file: &Path,
        document: &Document,
        buffers: &Buffers,
        progress: &Progress,
        warnings: &mut Vec<String>,
    ) -> Self {
        let mut wanted: Vec<(usize, Use)> = Vec::new();
        for material in document.materials() {
            let mut want = |texture: Option<gltf::Texture<'_>>, what: Use| {
                wanted.extend(texture.and_then(|texture| texture.source()).map(|image| (image.index(), what)));
            };
            let metallic = material.pbr_metallic_roughness();
            want(metallic.base_color_texture().map(|info| info.texture()), Use::Color);
            want(metallic.metallic_roughness_texture().map(|info| info.texture()), Use::Data);
            want(material.normal_texture().map(|normal| normal.texture()), Use::Bumps);
            want(material.emissive_texture().map(|info| info.texture()), Use::Color);
            let glossy = material.pbr_specular_glossiness();
            want(glossy.and_then(|glossy| glossy.diffuse_texture()).map(|info| info.texture()), Use::Color);
        }
        wanted.sort_unstable();
        wanted.dedup();
        let images: Vec<image::Image<'_>> = document.images().collect();
        progress.expect(wanted.len() as u64);
        // The crate takes for granted that an image has bytes.
        let has_bytes = |number: usize| {
            let image = document.as_json().images.get(number);
            image.is_some_and(|image| image.uri.is_some() || image.buffer_view.is_some())
        };
        let decoded = at_once(&wanted, |&(number, what)| {
            if !has_bytes(number) {
                return Err("it has neither a uri nor a buffer view".to_owned());
            }
            let picture = match images[number].source() {
                image::Source::View { view, mime_type } => {
                    buffers.view(&view).and_then(|bytes| picture::decode(bytes, mime_type.strip_prefix("image/")))
                }
                image::Source::Uri { uri, .. } => {
                    fetch(file, uri).and_then(|bytes| picture::decode(&bytes, uri.rsplit_once('.').map(|(_, end)| end)))
                }
            };
            progress.advance(1);
            picture.map(|picture| Arc::new(texture(picture, what)))
        });
        let mut all = HashMap::new();
        for (key, result) in wanted.into_iter().zip(decoded) {
            match result {
                Ok(texture) => drop(all.insert(key, texture)),
                Err(problem) => {
                    let file = file.display();
                    warnings.push(format!("{file}: image {}: {problem}; materials keep their colours", key.0));
                }
            }
        }
        Self { decoded: all }
    }

    fn map(&self, wanted: &gltf::Texture<'_>, what: Use, transform: Option<TextureTransform<'_>>) -> Option<Map> {
        let texture = self.decoded.get(&(wanted.source()?.index(), what))?.clone();
        let wrap = |mode| match mode {
            WrappingMode::Repeat => Wrap::Repeat,
            WrappingMode::MirroredRepeat => Wrap::Mirror,
            WrappingMode::ClampToEdge => Wrap::Clamp,
        };
        let sampler = wanted.sampler();
        let mut map = Map { wrap: [wrap(sampler.wrap_s()), wrap(sampler.wrap_t())], ..Map::new(texture) };
        if let Some(transform) = transform {
            (map.turn, map.offset) = from_above(transform.scale(), transform.rotation(), transform.offset());
        }
        Some(map)
    }

    fn of(&self, info: Option<Info<'_>>, what: Use) -> Option<Map> {
        let info = info?;
        self.map(&info.texture(), what, info.texture_transform())
    }
}

/// A transform of texture coordinates whose second one goes down, for ours, which goes up.
fn from_above([across, down]: [f32; 2], rotation: f32, [right, below]: [f32; 2]) -> ([[f32; 2]; 2], [f32; 2]) {
    let (sine, cosine) = (libm::sinf(rotation), libm::cosf(rotation));
    let turn = [[cosine * across, -sine * down], [sine * across, cosine * down]];
    (turn, [sine * down + right, 1.0 - cosine * down - below])
}

/// All materials, by number.
pub(super) fn materials(document: &Document, textures: &Textures) -> Vec<NamedMaterial> {
    document.materials().map(|material| describe(&material, textures)).collect()
}

/// What a material looks like.
fn describe(material: &gltf::Material<'_>, textures: &Textures) -> NamedMaterial {
    let name = material.name().map_or_else(|| format!("material {}", material.index().unwrap_or(0)), str::to_owned);
    let metallic = material.pbr_metallic_roughness();
    let mut factor = metallic.base_color_factor();
    let mut color = textures.of(metallic.base_color_texture(), Use::Color);
    let mut principled = Principled {
        metallic: metallic.metallic_factor(),
        roughness: metallic.roughness_factor(),
        emission: Vec3::from(material.emissive_factor()) * material.emissive_strength().unwrap_or(1.0),
        emission_map: textures.of(material.emissive_texture(), Use::Color),
        ior: material.ior().unwrap_or(1.5),
        ..Principled::default()
    }
    .with_metallic_roughness(textures.of(metallic.metallic_roughness_texture(), Use::Data));
    if let Some(glossy) = material.pbr_specular_glossiness() {
        // What mirrors more than any dielectric is a metal.
        let specular = Vec3::from(glossy.specular_factor());
        let diffuse = glossy.diffuse_factor();
        let metal =
            specular.max_element() > 0.25 && specular.max_element() > diffuse[..3].iter().fold(0.0, |a, b| b.max(a));
        factor = if metal { [specular.x, specular.y, specular.z, diffuse[3]] } else { diffuse };
        color = textures.of(glossy.diffuse_texture(), Use::Color);
        principled.metallic = if metal { 1.0 } else { 0.0 };
        principled.roughness = 1.0 - glossy.glossiness_factor();
    }
    let alpha = factor[3];
    let cutoff = material.alpha_cutoff().unwrap_or(0.5);
    let holes = color.clone().filter(|map| map.texture.has_alpha());
    let (opacity, holes) = match (material.alpha_mode(), holes) {
        (AlphaMode::Opaque, _) => (1.0, None),
        (AlphaMode::Mask, None) => (if alpha >= cutoff { 1.0 } else { 0.0 }, None),
        (AlphaMode::Blend, None) => (alpha, None),
        (mode, Some(map)) => {
            let cutoff = (mode == AlphaMode::Mask).then_some(cutoff);
            (1.0, Some(OpacityMap { map, channel: 3, factor: alpha, cutoff }))
        }
    };
    let normal = material.normal_texture();
    let normal = normal.and_then(|normal| {
        let mut map = textures.map(&normal.texture(), Use::Bumps, None)?;
        // The crate has no words for that of normals.
        if let Some(transform) = normal.extension_value("KHR_texture_transform") {
            let number = |value: &Value, usual: f32| value.as_f64().map_or(usual, |x| x as f32);
            let pair = |name: &str, usual: f32| [0, 1].map(|i| number(&transform[name][i], usual));
            let rotation = number(&transform["rotation"], 0.0);
            (map.turn, map.offset) = from_above(pair("scale", 1.0), rotation, pair("offset", 0.0));
        }
        Some(NormalMap { map, scale: normal.scale() })
    });
    let base_color = Vec3::new(factor[0], factor[1], factor[2]);
    let maps = Maps { color, normal, opacity: holes };
    let glass = material.transmission().filter(|transmission| transmission.transmission_factor() > 0.5);
    let described: Arc<dyn Material> = if material.unlit() {
        Arc::new(Flat { color: base_color, maps })
    } else if glass.is_some() && principled.roughness < 0.2 {
        // A body of glass, or else a pane.
        match material.volume().filter(|volume| volume.thickness_factor() > 0.0) {
            Some(volume) => {
                let color = Vec3::from(volume.attenuation_color());
                let distance = volume.attenuation_distance();
                let (color, distance) = if distance < 1e9 { (color, distance) } else { (Vec3::ONE, 1.0) };
                Arc::new(Dielectric { ior: principled.ior, color, distance })
            }
            None => Arc::new(ThinDielectric { ior: principled.ior, color: base_color }),
        }
    } else {
        Arc::new(Principled { base_color, opacity, maps, ..principled })
    };
    NamedMaterial { name, material: described }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transforms_of_places_from_above() {
        // The lower left quarter of the texture, which from above begins half way down.
        let (turn, offset) = from_above([0.5, 0.5], 0.0, [0.0, 0.5]);
        assert_eq!((turn, offset), ([[0.5, 0.0], [0.0, 0.5]], [0.0, 0.0]));
        assert_eq!(from_above([1.0, 1.0], 0.0, [0.0, 0.0]), ([[1.0, 0.0], [0.0, 1.0]], [0.0, 0.0]));
    }
}
