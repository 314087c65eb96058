//! What has a name in a scene file: materials, transfer functions, colour maps.

use std::sync::Arc;

use glam::Vec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::keys::{
    Checker, ColorBy, Colored, Dielectric, Emissive, Measured, NoKeys, Paint, Phong, Principled, Rough, ThinDielectric,
    TransferRows, Wireframe,
};
use super::text::Text;
use super::textures;
use super::values::{Named, Number};
use crate::color::from_srgb;
use crate::load::LoadError;
use crate::load::textures::Use;
use crate::material::{self, LineWidth, Material, MaterialKind, NamedMaterial};
use crate::scene::Map;
use crate::texture::Maps;
use crate::volume::{MOST_POINTS, Preset, Scale, TransferFunction, TransferPoint};

/// No scene file has more names of one kind.
const MOST_NAMES: usize = 4096;

/// Everything that has a name.
#[derive(Debug, Default)]
pub(super) struct Definitions {
    pub(super) materials: Vec<Defined>,
    pub(super) transfers: Vec<Arc<TransferFunction>>,
    maps: Vec<(String, Vec<ColorPoint>)>,
}

/// A material, and the attribute that decides about its colour, if one does.
#[derive(Debug)]
pub(super) struct Defined {
    pub(super) named: NamedMaterial,
    pub(super) color: Option<Coloring>,
}

/// A place on a colour map, from 0 to 1, and the colour there, linear RGB.
pub(super) type ColorPoint = (f64, [f32; 3]);

/// Colours that go by an attribute.
#[derive(Clone, Debug)]
pub(super) struct Coloring {
    /// The attribute.
    pub(super) by: String,
    /// Which colours; `None`: as goes with the attribute.
    pub(super) map: Option<Map>,
    /// The values at the ends of the map; `None`: the least and the greatest.
    pub(super) range: Option<[f64; 2]>,
}

impl Definitions {
    /// What a file defines.
    pub(super) fn read(text: &Text<'_>, file: &mut DeTable<'_>) -> Result<Self, LoadError> {
        let mut all = Self::default();
        for (name, value) in section(text, file, "maps")? {
            all.maps.push((name.into_inner(), map(text, value)?));
        }
        for (name, value) in section(text, file, "transfer")? {
            all.transfers.push(Arc::new(transfer(text, name.into_inner(), value)?));
        }
        for (name, value) in section(text, file, "materials")? {
            let defined = all.material(text, name.into_inner(), value)?;
            all.materials.push(defined);
        }
        Ok(all)
    }

    /// The number of the material that is called so.
    pub(super) fn find(&self, text: &Text<'_>, name: &Spanned<String>) -> Result<u32, LoadError> {
        let found = self.materials.iter().position(|defined| defined.named.name == *name.get_ref());
        let known = || self.materials.iter().map(|defined| defined.named.name.as_str()).collect::<Vec<_>>();
        found.map(|number| number as u32).ok_or_else(|| text.unknown_name(name, "material", &known()))
    }

    /// As [`find`](Self::find), for what has no attributes.
    pub(super) fn find_plain(&self, text: &Text<'_>, name: &Spanned<String>) -> Result<u32, LoadError> {
        let number = self.find(text, name)?;
        match &self.materials[number as usize].color {
            None => Ok(number),
            Some(color) => {
                let problem = format!("this material is coloured by {}, which only particles have", color.by);
                Err(text.error(name.span(), problem, "give it a colour, or another material here"))
            }
        }
    }

    /// Colours as an attribute says.
    pub(super) fn coloring(&self, text: &Text<'_>, keys: ColorBy) -> Result<Coloring, LoadError> {
        let map = keys.map.as_ref().map(|name| self.map(text, name)).transpose()?;
        let range = keys.range.map(|range| ascending(text, &range)).transpose()?;
        Ok(Coloring { by: keys.by, map, range })
    }

    /// The colour map that is called so.
    fn map(&self, text: &Text<'_>, name: &Spanned<String>) -> Result<Map, LoadError> {
        if let Some((name, points)) = self.maps.iter().find(|(known, _)| known == name.get_ref()) {
            let point = |&(value, color): &ColorPoint| TransferPoint { value, color, extinction: 0.0 };
            let (name, points) = (name.clone(), points.iter().map(point).collect());
            let function = TransferFunction { name, points, values: Scale::Relative, lengths: Scale::Relative };
            return Ok(Map::Function(Arc::new(function)));
        }
        match name.get_ref().as_str() {
            "labels" => Ok(Map::Labels),
            "elements" => Ok(Map::Elements),
            word => {
                let presets = Preset::ALL.iter().filter(|preset| !preset.is_lit()).map(|preset| preset.name());
                let names =
                    self.maps.iter().map(|(name, _)| name.as_str()).chain(presets).chain(["labels", "elements"]);
                let found = word.parse().ok().filter(|preset: &Preset| !preset.is_lit());
                let unknown = || text.unknown_name(name, "colour map", &names.collect::<Vec<_>>());
                found.map(Map::Preset).ok_or_else(unknown)
            }
        }
    }

    fn material(&self, text: &Text<'_>, name: String, value: Spanned<DeValue<'_>>) -> Result<Defined, LoadError> {
        let (kind, value) = kind_of::<MaterialKind>(text, value, "material", MaterialKind::NAMES)?;
        let mut value = value;
        let textured = matches!(
            kind,
            MaterialKind::Lambertian | MaterialKind::Flat | MaterialKind::Phong | MaterialKind::Principled
        );
        let maps = if textured { textures::maps(text, &mut value)? } else { Maps::default() };
        let mut coloring = None;
        let mut paint = |paint: Option<Paint>, usual: Vec3| {
            Ok(match paint {
                None => usual,
                Some(Paint::Plain(color)) => color.0,
                Some(Paint::By(keys)) => {
                    coloring = Some(self.coloring(text, keys)?);
                    Vec3::ONE
                }
            })
        };
        let material: Arc<dyn Material> = match kind {
            MaterialKind::Lambertian => {
                let Colored { color, .. } = text.read(value)?;
                let diffuse = paint(color, material::Lambertian::default().diffuse.max(white(&maps)))?;
                Arc::new(material::Lambertian { diffuse, maps })
            }
            MaterialKind::Flat => {
                let Colored { color, .. } = text.read(value)?;
                let color = paint(color, material::Flat::default().color.max(white(&maps)))?;
                Arc::new(material::Flat { color, maps })
            }
            MaterialKind::Emissive => {
                let Emissive { color, strength } = text.read(value)?;
                let strength = strength.map_or(1.0, |x| x.0 as f32);
                Arc::new(material::Flat::new(paint(color, Vec3::ONE)? * strength))
            }
            MaterialKind::Principled => {
                let metallic_roughness = textures::take(text, &mut value, "metallic_roughness_map", Use::Data)?;
                let emission_map = textures::take(text, &mut value, "emission_map", Use::Color)?;
                let Principled { color, metallic, roughness, emission, opacity, ior, .. } = text.read(value)?;
                let usual = material::Principled::default();
                let described = material::Principled {
                    base_color: paint(color, usual.base_color.max(white(&maps)))?,
                    metallic: metallic.map_or(usual.metallic, |x| x.0 as f32),
                    roughness: roughness.map_or(usual.roughness, |x| x.0 as f32),
                    emission: emission
                        .map_or(if emission_map.is_some() { Vec3::ONE } else { usual.emission }, |color| color.0),
                    opacity: opacity.map_or(usual.opacity, |x| x.0 as f32),
                    ior: ior.map_or(usual.ior, |x| x.0 as f32),
                    maps,
                    emission_map,
                    ..usual
                };
                Arc::new(described.with_metallic_roughness(metallic_roughness))
            }
            MaterialKind::Metal => {
                let Rough { color, roughness } = text.read(value)?;
                let usual = material::Metal::default();
                Arc::new(material::Metal {
                    color: paint(color, usual.color)?,
                    roughness: roughness.map_or(usual.roughness, |x| x.0 as f32),
                })
            }
            MaterialKind::OrenNayar => {
                let Rough { color, roughness } = text.read(value)?;
                let usual = material::OrenNayar::default();
                Arc::new(material::OrenNayar {
                    color: paint(color, usual.color)?,
                    roughness: roughness.map_or(usual.roughness, |x| x.0 as f32),
                })
            }
            MaterialKind::Dielectric => {
                let Dielectric { ior, color, distance } = text.read(value)?;
                let usual = material::Dielectric::default();
                Arc::new(material::Dielectric {
                    ior: ior.map_or(usual.ior, |x| x.0 as f32),
                    color: color.map_or(usual.color, |color| color.0),
                    distance: distance.map_or(usual.distance, |x| x.0 as f32),
                })
            }
            MaterialKind::ThinDielectric => {
                let ThinDielectric { ior, color } = text.read(value)?;
                let usual = material::ThinDielectric::default();
                Arc::new(material::ThinDielectric {
                    ior: ior.map_or(usual.ior, |x| x.0 as f32),
                    color: color.map_or(usual.color, |color| color.0),
                })
            }
            MaterialKind::Checker => {
                let Checker { colors, size, by } = text.read(value)?;
                let usual = material::Checker::default();
                Arc::new(material::Checker {
                    colors: colors.map_or(usual.colors, |colors| colors.map(|color| color.0)),
                    size: size.map_or(usual.size, |x| x.0 as f32),
                    by: by.map_or(usual.by, |Named(by)| by),
                })
            }
            MaterialKind::Wireframe => {
                let span = value.span();
                let Wireframe { line, color, width, relative_width, pixels } = text.read(value)?;
                let usual = material::Wireframe::default();
                let widths = [
                    width.map(|x| LineWidth::Units(x.0 as f32)),
                    relative_width.map(|x| LineWidth::Relative(x.0 as f32)),
                    pixels.map(|x| LineWidth::Pixels(x.0 as f32)),
                ];
                let mut given = widths.into_iter().flatten();
                let width = given.next();
                if given.next().is_some() {
                    let problem = "there are several widths of lines";
                    return Err(text.error(span, problem, "keep one of width, relative_width and pixels"));
                }
                Arc::new(material::Wireframe {
                    line: line.map_or(usual.line, |color| color.0),
                    color: paint(color, usual.color)?,
                    width: width.unwrap_or(usual.width),
                })
            }
            MaterialKind::NormalColor => {
                let NoKeys {} = text.read(value)?;
                Arc::new(material::NormalColor)
            }
            MaterialKind::Phong => {
                let specular_map = textures::take(text, &mut value, "specular_map", Use::Color)?;
                let Phong { color, specular, shininess, reflection, transparency, refractive_index, .. } =
                    text.read(value)?;
                let usual = material::Phong::default();
                Arc::new(material::Phong {
                    diffuse: paint(color, usual.diffuse.max(white(&maps)))?,
                    specular: specular
                        .map_or(if specular_map.is_some() { Vec3::ONE } else { usual.specular }, |color| color.0),
                    shininess: shininess.map_or(usual.shininess, |x| x.0 as f32),
                    reflection: reflection.map_or(usual.reflection, |x| x.0 as f32),
                    transparency: transparency.map_or(usual.transparency, |x| x.0 as f32),
                    refractive_index: refractive_index.map_or(usual.refractive_index, |x| x.0 as f32),
                    maps,
                    specular_map,
                })
            }
        };
        Ok(Defined { named: NamedMaterial { name, material }, color: coloring })
    }
}

/// White, where a texture of colours is multiplied by a colour that is not given.
fn white(maps: &Maps) -> Vec3 {
    if maps.color.is_some() { Vec3::ONE } else { Vec3::ZERO }
}

/// A name, and what is behind it.
type Entry<'de> = (Spanned<String>, Spanned<DeValue<'de>>);

/// The entries of a table of the file, by name; none if it is not there.
fn section<'de>(text: &Text<'_>, file: &mut DeTable<'de>, name: &str) -> Result<Vec<Entry<'de>>, LoadError> {
    let Some(value) = file.remove(name) else { return Ok(Vec::new()) };
    let span = value.span();
    let DeValue::Table(table) = value.into_inner() else {
        return Err(text.error(
            span,
            format!("{name} is no table"),
            format!("write [{name}], and what is in it below"),
        ));
    };
    if table.len() > MOST_NAMES {
        let first = table.keys().map(|key| key.span()).min_by_key(|span| span.start).unwrap_or(span);
        return Err(text.error(first, format!("more than {MOST_NAMES} {name}"), "leave out what no object names"));
    }
    let owned = |key: Spanned<std::borrow::Cow<'_, str>>| Spanned::new(key.span(), key.into_inner().into_owned());
    Ok(table.into_iter().map(|(key, value)| (owned(key), value)).collect())
}

/// What a table is by its key `kind`, and the table without it.
pub(super) fn kind_of<'de, K: std::str::FromStr<Err: std::fmt::Display>>(
    text: &Text<'_>,
    value: Spanned<DeValue<'de>>,
    what: &str,
    names: &[&str],
) -> Result<(K, Spanned<DeValue<'de>>), LoadError> {
    let span = value.span();
    let DeValue::Table(mut table) = value.into_inner() else {
        let remedy = format!("write {{ kind = \"{}\" }}", names.first().copied().unwrap_or_default());
        return Err(text.error(span, format!("a {what} is a table"), remedy));
    };
    let Some(kind) = table.remove("kind") else {
        let remedy = format!("write kind = \"...\"; there are {}", names.join(", "));
        return Err(text.error(span, format!("this {what} has no kind"), remedy));
    };
    let name: Spanned<String> = Spanned::new(kind.span(), text.read(kind)?);
    let kind = name.get_ref().parse().map_err(|_| text.unknown_name(&name, what, names))?;
    Ok((kind, Spanned::new(span, DeValue::Table(table))))
}

/// Two numbers, the second above the first.
fn ascending(text: &Text<'_>, range: &Spanned<[Number; 2]>) -> Result<[f64; 2], LoadError> {
    let [low, high] = range.get_ref().map(|x| x.0);
    let wrong = || text.error(range.span(), format!("{high} is not above {low}"), "write the lesser number first");
    (low < high).then_some([low, high]).ok_or_else(wrong)
}

fn transfer(text: &Text<'_>, name: String, value: Spanned<DeValue<'_>>) -> Result<TransferFunction, LoadError> {
    let span = value.span();
    let (rows, values, lengths) = match text.read(value)? {
        TransferRows::Points(rows) => (rows, None, None),
        TransferRows::Scaled(rows) => (rows.points, rows.values, rows.lengths),
    };
    let remedy = "a point is [value, red, green, blue, extinction]";
    let scale = |measured: Option<Named<Measured>>| match measured {
        Some(Named(Measured::Relative)) => Scale::Relative,
        _ => Scale::Absolute,
    };
    if rows.len() > MOST_POINTS {
        return Err(text.error(span, format!("more than {MOST_POINTS} points"), "leave some out"));
    }
    let mut points = Vec::with_capacity(rows.len());
    for (number, row) in rows.iter().enumerate() {
        let [value, red, green, blue, extinction] = row.map(|x| x.0);
        let color = srgb([red, green, blue]).ok_or_else(|| {
            text.error(span.clone(), format!("the colour of point {} is not from 0 to 1", number + 1), remedy)
        })?;
        points.push(TransferPoint { value, color, extinction });
    }
    TransferFunction::new(name, points, scale(values), scale(lengths))
        .map_err(|error| text.error(span, error.to_string(), remedy))
}

fn map(text: &Text<'_>, value: Spanned<DeValue<'_>>) -> Result<Vec<ColorPoint>, LoadError> {
    let span = value.span();
    let rows: Vec<[Number; 4]> = text.read(value)?;
    let wrong = |problem: String| {
        text.error(span.clone(), problem, "a point is [place, red, green, blue], all from 0 to 1, by place")
    };
    if rows.is_empty() || rows.len() > MOST_POINTS {
        return Err(wrong(format!("a colour map has 1 to {MOST_POINTS} points")));
    }
    let mut points: Vec<ColorPoint> = Vec::with_capacity(rows.len());
    for (number, row) in rows.iter().enumerate() {
        let [place, red, green, blue] = row.map(|x| x.0);
        let number = number + 1;
        if !(0.0..=1.0).contains(&place) || points.last().is_some_and(|before| place < before.0) {
            return Err(wrong(format!("the place of point {number} is not from 0 to 1, or below the one before")));
        }
        let color = srgb([red, green, blue]);
        points.push((place, color.ok_or_else(|| wrong(format!("the colour of point {number} is not from 0 to 1")))?));
    }
    Ok(points)
}

/// A colour on the sRGB curve, as files of transfer functions have it, linear RGB.
fn srgb(curve: [f64; 3]) -> Option<[f32; 3]> {
    curve.iter().all(|channel| (0.0..=1.0).contains(channel)).then(|| from_srgb(curve).to_array())
}
