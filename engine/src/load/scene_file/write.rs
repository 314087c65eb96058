//! What is shown as a scene file: a copy of the one that it came from, or objects for its files; with the present view.

use std::fs;
use std::path::{Component, Path};

use toml::{Table, Value};

use crate::generate;
use crate::light::LightKind;
use crate::load::place::Place;
use crate::load::{LoadError, Raw, RawParticles, VoxelType};
use crate::medium::{DEFAULT_STEP, Fog};
use crate::scene::{GRAIN, Object, Rendering, Shown};
use crate::view::Up;
use crate::volume::Preset;

/// A scene that can be written as a file.
#[derive(Clone, Debug)]
pub struct SavedScene {
    table: Table,
    place: Place,
}

/// What somebody changed of how all volumes and particles are shown. What is `None` stays as it is.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes {
    /// The values of iso-surfaces.
    pub iso: Option<Vec<f64>>,
    /// A transfer function by name, lit as goes with it, over the values that it is for.
    pub transfer: Option<String>,
    /// Level and width of the transfer functions.
    pub window: Option<[f64; 2]>,
    /// Attributes of particles, and from where to where their values are shown.
    pub crops: Vec<(String, [f32; 2])>,
    /// An attribute that decides about the colours of particles, and the name of a map if it has not that which goes with it.
    pub color: Option<(String, Option<String>)>,
}

/// What options say of all particles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SavedParticles {
    /// The radius, in units of the files.
    pub radius: Option<f32>,
    /// The attribute whose values are the radii, multiplied by `radius`.
    pub radius_by: Option<String>,
    /// How often the periodic box is repeated.
    pub tile: Option<[u32; 3]>,
    /// The sides of that box, in units of the files.
    pub sides: Option<[f64; 3]>,
    /// Attributes, and from where to where their values are shown.
    pub crops: Vec<(String, Vec<[f32; 2]>)>,
    /// How opaque they are, or what the opacities of `opacity_by` are multiplied by.
    pub opacity: Option<f32>,
    /// Which attribute decides about that, and its values with their opacities, if these were said.
    pub opacity_by: Option<(String, Option<Vec<[f32; 2]>>)>,
    /// Which attribute decides about colours; `none`: none does.
    pub color_by: Option<String>,
    /// The name of the colour map.
    pub map: Option<String>,
    /// The values at its ends.
    pub range: Option<[f32; 2]>,
}

impl SavedScene {
    /// A copy of a scene file, for the folder in which the program runs, as far as it does not say from where it is seen.
    ///
    /// # Errors
    /// If it cannot be read any more.
    pub fn of_file(file: &Path, place: Place) -> Result<Self, LoadError> {
        let unreadable = |problem: String| LoadError::new(file, problem, "save it again");
        let text = fs::read_to_string(file).map_err(|error| unreadable(format!("cannot be read: {error}")))?;
        let parsed = text.trim_start_matches('\u{feff}').parse();
        let mut table: Table = parsed.map_err(|error: toml::de::Error| unreadable(error.message().to_owned()))?;
        let own: Vec<String> =
            table.get("transfer").and_then(Value::as_table).into_iter().flat_map(Table::keys).cloned().collect();
        let folder = file.parent().unwrap_or(Path::new(""));
        for object in objects(&mut table) {
            for kind in ["mesh", "particles", "volume"] {
                match object.get_mut(kind) {
                    Some(Value::String(name)) => *name = moved(folder, name),
                    Some(Value::Array(names)) => names.iter_mut().for_each(|name| {
                        if let Value::String(name) = name {
                            *name = moved(folder, name);
                        }
                    }),
                    _ => {}
                }
            }
            if let Some(Value::String(name)) = object.get_mut("transfer")
                && !own.contains(name)
                && !is_known(name)
            {
                *name = moved(folder, name);
            }
        }
        if let Some(Value::String(name)) =
            table.get_mut("background").and_then(Value::as_table_mut).and_then(|table| table.get_mut("file"))
        {
            *name = moved(folder, name);
        }
        Ok(Self { table, place })
    }

    /// Objects for files that are shown together.
    pub fn of_objects(objects: &[Object], place: Place) -> Self {
        let object = |object: &Object| {
            let names: Vec<Value> = object.names.iter().map(|name| name.as_str().into()).collect();
            let files = match &names[..] {
                [one] => one.clone(),
                _ => Value::Array(names),
            };
            Value::Table(Table::from_iter([(object.kind.to_owned(), files)]))
        };
        let list = Value::Array(objects.iter().map(object).collect());
        Self { table: Table::from_iter([("object".to_owned(), list)]), place }
    }

    /// Says what is in files of nothing but voxels, which `is_raw` tells by their names.
    pub fn describe_raw(&mut self, raw: &Raw, is_raw: impl Fn(&str) -> bool) {
        self.insert_raw("volume", &raw_table(raw), is_raw);
    }

    /// Says what is in files of nothing but the numbers of particles, which `is_raw` tells by their names.
    pub fn describe_raw_particles(&mut self, raw: &RawParticles, is_raw: impl Fn(&str) -> bool) {
        let names = raw.columns.iter().map(|name| name.as_deref().unwrap_or("_").into());
        let entries = [("layout", Value::Array(names.collect())), ("type", raw_type(raw.kind, raw.big_endian))];
        let table = entries.map(|(key, value)| (key.to_owned(), value)).into_iter().collect();
        self.insert_raw("particles", &table, is_raw);
    }

    fn insert_raw(&mut self, kind: &str, raw: &Table, is_raw: impl Fn(&str) -> bool) {
        for object in objects(&mut self.table) {
            let found = match object.get(kind) {
                Some(Value::String(name)) => is_raw(name),
                Some(Value::Array(names)) => names.iter().filter_map(Value::as_str).any(&is_raw),
                _ => false,
            };
            if found {
                object.insert("raw".into(), raw.clone().into());
            }
        }
    }

    /// Says what volumes are shown as where nothing is said yet. `transfer` names the transfer function of the first of these, the
    /// second, ...
    pub fn describe_volumes(
        &mut self,
        parts: &[Object],
        shown: &[Option<Shown>],
        transfer: impl Fn(usize) -> Option<String>,
    ) {
        const HOW: [&str; 7] = ["transfer", "window", "shading", "step_length", "iso", "cut", "origin"];
        let (mut at, mut unsaid) = (0, 0);
        for (object, part) in objects(&mut self.table).zip(parts) {
            let all = shown.get(at..at + part.volumes).unwrap_or_default();
            at += part.volumes;
            let Some(Some(shown)) = all.first() else { continue };
            if HOW.iter().any(|key| object.contains_key(*key)) {
                continue;
            }
            let transfer = transfer(unsaid);
            unsaid += part.volumes;
            describe(object, shown, transfer, &self.place);
        }
    }

    /// Says what all particles are shown as.
    pub fn describe_particles(&mut self, said: &SavedParticles) {
        let SavedParticles { radius, radius_by, tile, sides, crops, opacity, opacity_by, color_by, map, range } = said;
        for object in objects(&mut self.table).filter(|object| object.contains_key("particles")) {
            let mut put = |key: &str, value: Option<Value>| object.extend(value.map(|value| (key.to_owned(), value)));
            put("radius", radius.map(|radius| exact(radius).into()));
            put("radius_by", radius_by.as_ref().map(|by| by.as_str().into()));
            put("tile", tile.map(|times| Value::Array(times.map(|n| whole(n.into())).into())));
            put("box", sides.map(|sides| Value::Array(vec![numbers([0.0; 3]), numbers(sides)])));
            put(
                "color",
                color_by.as_ref().map(|by| {
                    if by == "none" {
                        return numbers(GRAIN.map(exact));
                    }
                    let mut table = color_by_table(by, map.as_deref());
                    table.extend(range.map(|range| ("range".to_owned(), numbers(range.map(exact)))));
                    Value::Table(table)
                }),
            );
            put("opacity", opacity_value(*opacity, opacity_by.as_ref()));
            crops.iter().for_each(|(attribute, ranges)| set_crop(object, attribute, ranges));
        }
    }

    /// Puts the only light at a point of the files.
    pub fn light(&mut self, at: [f64; 3], color: [f32; 3]) {
        let entries =
            [("kind", LightKind::Point.name().into()), ("at", numbers(at)), ("color", numbers(color.map(f64::from)))];
        let light: Table = entries.map(|(key, value)| (key.to_owned(), value)).into_iter().collect();
        self.table.insert("light".into(), Value::Array(vec![Value::Table(light)]));
    }

    /// Puts the only light where the camera is.
    pub fn light_at_camera(&mut self) {
        let light = Table::from_iter([("kind".to_owned(), LightKind::Camera.name().into())]);
        self.table.insert("light".into(), Value::Array(vec![Value::Table(light)]));
    }

    /// Says from which angle on, in degrees, edges of meshes without normals are creases.
    pub fn smooth(&mut self, degrees: f32) {
        self.table.insert("smooth".into(), exact(degrees).into());
    }

    /// Gives it a background, in words.
    pub fn background(&mut self, words: &str) {
        self.table.insert("background".into(), words.into());
    }

    /// Gives it a picture of everything around as a background, as it is.
    pub fn background_file(&mut self, file: &str) {
        let table = Table::from_iter([("file".to_owned(), file.into())]);
        self.table.insert("background".into(), Value::Table(table));
    }

    /// Puts a ground under it.
    pub fn ground(&mut self) {
        self.table.insert("ground".into(), Value::Boolean(true));
    }

    /// Gives it fog.
    pub fn fog(&mut self, fog: &Fog) {
        let density = f64::from(fog.density) * self.place.scale;
        let color = numbers(fog.color.to_array().map(f64::from));
        let entries = [("density".to_owned(), density.into()), ("color".to_owned(), color)];
        self.table.insert("fog".into(), Value::Table(entries.into_iter().collect()));
    }

    /// The text of the file, with how it is rendered and what was changed.
    pub fn text(&self, rendering: &Rendering, axis: Up, changes: &Changes) -> String {
        let mut table = self.table.clone();
        table.remove("mobula");
        let Rendering {
            size,
            camera,
            aperture,
            focus,
            eye,
            at,
            up,
            fov,
            renderer,
            sampler,
            shadows,
            occlusion,
            tone,
            exposure,
            time,
        } = rendering;
        let mut look = Table::new();
        let back = |point: glam::Vec3| numbers(self.place.back(point.into()));
        look.extend(camera.map(|kind| ("kind".to_owned(), kind.name().into())));
        let length = |length: f32| Value::Float(f64::from(length) / self.place.scale);
        look.extend(aperture.map(|radius| ("aperture".to_owned(), length(radius))));
        look.extend(focus.map(|distance| ("focus".to_owned(), length(distance))));
        look.extend(eye.map(|eye| ("eye".to_owned(), back(eye))));
        look.extend(at.map(|at| ("at".to_owned(), back(at))));
        look.extend(up.map(|up| ("up".to_owned(), numbers(up.to_array().map(f64::from)))));
        look.extend(fov.map(|fov| ("fov".to_owned(), f64::from(fov).into())));
        let mut put = |key: &str, value: Option<Value>| table.extend(value.map(|value| (key.to_owned(), value)));
        put("camera", Some(Value::Table(look)));
        put("up", Some(if axis == Up::Y { "y" } else { "z" }.into()));
        put("size", size.map(|size| Value::Array([size.width(), size.height()].map(|side| whole(side as u64)).into())));
        put("renderer", renderer.map(|kind| kind.name().into()));
        put("sampler", sampler.map(|kind| kind.to_string().into()));
        put("shadows", shadows.map(Value::Boolean));
        put("tone", tone.map(|curve| curve.name().into()));
        put("exposure", exposure.map(|stops| f64::from(stops).into()));
        put("occlusion", occlusion.map(|reach| (f64::from(reach) / self.place.scale).into()));
        if let Some(time) = time {
            let old = table.entry("time").or_insert_with(|| Value::Table(Table::new()));
            if let Value::Table(old) = old {
                old.insert("show".into(), whole(time.shown as u64));
            }
        }
        objects(&mut table).filter(|object| object.contains_key("volume")).for_each(|object| change(object, changes));
        for object in objects(&mut table).filter(|object| object.contains_key("particles")) {
            changes.crops.iter().for_each(|(attribute, range)| set_crop(object, attribute, &[*range]));
            let color = changes.color.as_ref().map(|(by, map)| color_by_table(by, map.as_deref()).into());
            object.extend(color.map(|color| ("color".to_owned(), color)));
        }
        format!("mobula = 1\n{table}")
    }
}

/// The tables of the objects.
fn objects(table: &mut Table) -> impl Iterator<Item = &mut Table> {
    let list = table.get_mut("object").and_then(Value::as_array_mut);
    list.into_iter().flatten().filter_map(Value::as_table_mut)
}

/// Is it the name of a transfer function that is in no file?
fn is_known(transfer: &str) -> bool {
    transfer.eq_ignore_ascii_case("labels") || transfer.parse::<Preset>().is_ok()
}

/// A name from a folder on, as seen from outside.
fn moved(folder: &Path, name: &str) -> String {
    let plain = folder.components().all(|part| part == Component::CurDir);
    if plain || name.starts_with(generate::PREFIX) {
        return name.to_owned();
    }
    folder.join(name).to_string_lossy().into_owned()
}

/// The shortest number that means the same `f32`.
fn exact(number: f32) -> f64 {
    number.to_string().parse().unwrap_or(number.into())
}

/// Lets an object of particles show only some values of an attribute.
fn set_crop(object: &mut Table, attribute: &str, ranges: &[[f32; 2]]) {
    let crops = object.entry("crop").or_insert_with(|| Value::Table(Table::new()));
    if let Value::Table(crops) = crops {
        let value = match ranges {
            [only] => numbers(only.map(exact)),
            several => pairs(several),
        };
        crops.insert(attribute.to_owned(), value);
    }
}

/// What says that colours go by an attribute.
fn color_by_table(by: &str, map: Option<&str>) -> Table {
    let map = map.map(|map| ("map".to_owned(), map.into()));
    [("by".to_owned(), by.into())].into_iter().chain(map).collect()
}

/// How opaque particles are.
fn opacity_value(all: Option<f32>, by: Option<&(String, Option<Vec<[f32; 2]>>)>) -> Option<Value> {
    let Some((by, points)) = by else { return all.map(|opacity| exact(opacity).into()) };
    let points = points.as_ref().map(|points| ("points".to_owned(), pairs(points)));
    let scale = all.map(|factor| ("scale".to_owned(), exact(factor).into()));
    Some(Value::Table([("by".to_owned(), by.as_str().into())].into_iter().chain(points).chain(scale).collect()))
}

fn pairs(pairs: &[[f32; 2]]) -> Value {
    Value::Array(pairs.iter().map(|pair| numbers(pair.map(exact))).collect())
}

fn numbers<const N: usize>(numbers: [f64; N]) -> Value {
    Value::Array(numbers.map(Value::Float).into())
}

fn whole(number: u64) -> Value {
    Value::Integer(i64::try_from(number).unwrap_or(i64::MAX))
}

fn raw_type(kind: VoxelType, big_endian: bool) -> Value {
    format!("{kind}{}", if big_endian { "be" } else { "le" }).into()
}

fn raw_table(raw: &Raw) -> Table {
    let entries = [
        ("dims", Value::Array(raw.dims.map(whole).into())),
        ("steps", whole(raw.steps)),
        ("type", raw_type(raw.kind, raw.big_endian)),
        ("spacing", numbers(raw.spacing)),
    ];
    entries.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
}

/// The keys of an object that say what its volume is shown as.
fn describe(object: &mut Table, shown: &Shown, transfer: Option<String>, place: &Place) {
    let mut put = |key: &str, value: Option<Value>| object.extend(value.map(|value| (key.to_owned(), value)));
    put("transfer", transfer.map(Value::String));
    let transparency = |number: usize| shown.transparent.get(number).or(shown.transparent.last()).copied();
    let iso =
        shown.iso.iter().enumerate().map(|(number, &value)| match transparency(number).filter(|part| *part > 0.0) {
            None => Value::Float(value),
            Some(part) => {
                let entries = [("value".to_owned(), value.into()), ("transparent".to_owned(), f64::from(part).into())];
                Value::Table(entries.into_iter().collect())
            }
        });
    put("iso", (!shown.iso.is_empty()).then(|| Value::Array(iso.collect())));
    if shown.transfer.is_some() {
        put("window", shown.window.map(numbers));
        put("shading", shown.lit.map(|lit| if lit { "on" } else { "off" }.into()));
        let length = (shown.step_length != DEFAULT_STEP).then(|| f64::from(shown.step_length));
        put("step_length", length.map(Value::Float));
    }
    put("origin", shown.origin.map(|origin| numbers(place.back(origin))));
    let cuts = shown.cuts.iter().map(|cut| numbers(place.plane_back(*cut)));
    put("cut", (!shown.cuts.is_empty()).then(|| Value::Array(cuts.collect())));
}

/// Changes what an object of a volume says.
fn change(object: &mut Table, changes: &Changes) {
    if let Some(values) = &changes.iso {
        let old = object.get("iso").and_then(Value::as_array).filter(|old| old.len() == values.len());
        let new = values.iter().enumerate().map(|(number, &value)| match old.map(|old| &old[number]) {
            Some(Value::Table(old)) => {
                let mut new = old.clone();
                new.insert("value".into(), value.into());
                Value::Table(new)
            }
            _ => Value::Float(value),
        });
        let new = Value::Array(new.collect());
        if object.contains_key("iso") || !object.contains_key("transfer") {
            object.insert("iso".into(), new);
        }
    }
    if object.contains_key("transfer") {
        if let Some(transfer) = &changes.transfer {
            object.insert("transfer".into(), transfer.as_str().into());
            object.remove("window");
            object.remove("shading");
        }
        if let Some(window) = changes.window {
            object.insert("window".into(), numbers(window));
        }
    }
}
