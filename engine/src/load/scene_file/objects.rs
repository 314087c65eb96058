//! Objects become geometry, and volumes with what they are shown as.

use std::any::Any;
use std::path::Path;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::named::Definitions;
use super::object_keys::{self as keys, Iso, IsoKeys, Raw, Shading};
use super::particles;
use super::parts::{Parts, RawFiles};
use super::text::Text;
use super::values::{Named, point};
use crate::generate;
use crate::geometry::{Geometry, Mesh, MeshSequence, Spheres};
use crate::load::transfer::load_transfer;
use crate::load::{self, LoadError, Report, input};
use crate::medium::DEFAULT_STEP;
use crate::scene::{Object, SceneDescription, Shown, Transfer, grain};
use crate::volume::Preset;

/// No scene file has more objects.
const MOST_OBJECTS: usize = 4096;
/// The keys of which each object has one.
const KINDS: [&str; 4] = ["mesh", "particles", "volume", "spheres"];

/// What one `[[object]]` says.
pub(super) enum Wanted {
    Mesh(keys::Mesh),
    Particles(Box<particles::Particles>),
    Volume(Box<keys::Volume>),
    Spheres(keys::Spheres),
}

/// The objects of a file, with all of their keys checked.
pub(super) fn read(text: &Text<'_>, file: &mut DeTable<'_>, named: &Definitions) -> Result<Vec<Wanted>, LoadError> {
    let objects = list(text, file, "object")?;
    if let Some(object) = objects.get(MOST_OBJECTS) {
        let problem = format!("more than {MOST_OBJECTS} objects");
        return Err(text.error(object.span(), problem, "put what belongs together in one file"));
    }
    objects.into_iter().map(|object| one(text, object, named)).collect()
}

/// The tables of a list, as `[[object]]` and `[[light]]` are written.
pub(super) fn list<'de>(
    text: &Text<'_>,
    file: &mut DeTable<'de>,
    name: &str,
) -> Result<Vec<Spanned<DeValue<'de>>>, LoadError> {
    let Some(value) = file.remove(name) else { return Ok(Vec::new()) };
    let span = value.span();
    match value.into_inner() {
        DeValue::Array(list) => Ok(list.into_iter().collect()),
        _ => Err(text.error(span, format!("{name} is no list"), format!("write [[{name}]], and its keys below"))),
    }
}

fn one(text: &Text<'_>, object: Spanned<DeValue<'_>>, named: &Definitions) -> Result<Wanted, LoadError> {
    let span = object.span();
    let kinds = KINDS.join(", ");
    let DeValue::Table(table) = object.get_ref() else {
        return Err(text.error(span, "an object is a table", "write [[object]], and its keys below"));
    };
    let mut found = KINDS.iter().filter(|kind| table.get(**kind).is_some());
    let (Some(&kind), None) = (found.next(), found.next()) else {
        let known: Vec<&str> = KINDS.iter().copied().chain(["material"]).collect();
        // A key that is meant to be one of them is more likely than none.
        let likely = |key: &str| KINDS.iter().any(|kind| strsim::jaro(kind, key) > 0.7 && *kind != key);
        return Err(match table.keys().find(|key| likely(key.get_ref())) {
            Some(key) if !KINDS.iter().any(|kind| table.get(*kind).is_some()) => {
                text.unknown_key(key.span(), key.get_ref(), &known)
            }
            _ => text.error(span, format!("an object has one of the keys {kinds}"), "make an object of each of them"),
        });
    };
    Ok(match kind {
        "mesh" => Wanted::Mesh(text.read(object)?),
        "volume" => Wanted::Volume(Box::new(text.read(object)?)),
        "spheres" => Wanted::Spheres(text.read(object)?),
        _ => Wanted::Particles(Box::new(particles::read(text, text.read(object)?, named)?)),
    })
}

/// The scene that objects are added to.
pub(super) struct Building<'a> {
    pub(super) text: Text<'a>,
    pub(super) named: &'a Definitions,
    pub(super) parts: Parts<'a>,
    pub(super) scene: SceneDescription,
    pub(super) report: Report,
}

impl Building<'_> {
    /// Adds all objects, in order.
    pub(super) fn add_all(&mut self, objects: &[Wanted]) -> Result<(), LoadError> {
        for object in objects {
            match object {
                Wanted::Mesh(keys::Mesh { mesh: name, .. }) => self.parts.expect(name)?,
                Wanted::Volume(keys) => self.parts.expect(&keys.volume)?,
                Wanted::Particles(particles) => self.parts.expect(&particles.files)?,
                _ => {}
            }
        }
        for object in objects {
            match object {
                Wanted::Mesh(keys) => self.add_mesh(keys)?,
                Wanted::Volume(keys) => self.add_volume(keys)?,
                Wanted::Spheres(keys) => self.add_spheres(keys)?,
                Wanted::Particles(particles) => self.add_particles(particles)?,
            }
        }
        Ok(())
    }

    fn note(&mut self, kind: &'static str, names: &[String], material: Option<&Spanned<String>>, volumes: usize) {
        let material = material.map(|name| name.get_ref().clone());
        self.scene.objects.push(Object { kind, names: names.to_vec(), material, volumes });
    }

    fn add_mesh(&mut self, keys: &keys::Mesh) -> Result<(), LoadError> {
        let keys::Mesh { mesh: name, material } = keys;
        let number = material.as_ref().map(|name| self.named.find_plain(&self.text, name)).transpose()?;
        for mut part in self.parts.get(name, &RawFiles::default())? {
            if name.get_ref().0.iter().any(|name| name.starts_with(generate::PREFIX)) {
                self.scene.ambient = Arc::clone(&part.scene.ambient);
                self.scene.background = Arc::clone(&part.scene.background);
            }
            if !part.scene.volumes.is_empty() {
                return Err(self.text.error(name.span(), "this is a volume", "write volume = instead of mesh ="));
            }
            self.no_particles(name, &part.scene)?;
            if let Some(number) = number {
                // Its own have no use any more.
                part.scene.materials.clear();
                let from = self.scene.geometry.len();
                self.scene.merge(part.scene);
                self.scene.geometry[from..].iter_mut().for_each(|geometry| set_material(geometry, number));
            } else {
                self.scene.merge(part.scene);
            }
            self.report.merge(part.report);
        }
        self.note("mesh", &name.get_ref().0, material.as_ref(), 0);
        Ok(())
    }

    fn no_particles(&self, name: &Spanned<keys::Files>, found: &SceneDescription) -> Result<(), LoadError> {
        let wrong = || self.text.error(name.span(), "these are particles", "write particles = instead");
        found.particles.is_empty().then_some(()).ok_or_else(wrong)
    }

    fn add_spheres(&mut self, keys: &keys::Spheres) -> Result<(), LoadError> {
        let material = keys.material.as_ref().map(|name| self.named.find_plain(&self.text, name)).transpose()?;
        let place = self.parts.place();
        let mut spheres = Spheres { name: "spheres".to_owned(), ..Spheres::default() };
        for (x, y, z, radius) in &keys.spheres {
            spheres.centers.push(place.put([x.0, y.0, z.0]));
            spheres.radii.push((radius.0 * place.scale) as f32);
        }
        spheres.material = material.unwrap_or(spheres.material);
        self.report.census.merge(&spheres.census());
        self.scene.add(spheres);
        let count = load::text::counted(keys.spheres.len() as u64, "sphere");
        self.note("spheres", &[count], keys.material.as_ref(), 0);
        Ok(())
    }

    fn add_particles(&mut self, asked: &particles::Particles) -> Result<(), LoadError> {
        let name = &asked.files;
        let raw = RawFiles { voxels: None, particles: asked.raw.clone() };
        for part in self.parts.get(name, &raw)? {
            if part.scene.particles.is_empty() {
                return Err(self.text.error(name.span(), "these are no particles", "write mesh = or volume = instead"));
            }
            let mut look = asked.look(self.parts.place().scale);
            if let Some(color) = asked.color {
                look.material = Some(self.scene.add_material("particles", grain(color)));
            }
            self.scene.merge(part.scene);
            self.report.merge(part.report);
            self.scene.particle_looks.resize(self.scene.particles.len(), Some(look));
        }
        let material = asked.material.and_then(|number| self.named.materials.get(number as usize));
        let material = material.map(|defined| defined.named.name.clone());
        self.scene.objects.push(Object { kind: "particles", names: name.get_ref().0.clone(), material, volumes: 0 });
        Ok(())
    }

    fn add_volume(&mut self, keys: &keys::Volume) -> Result<(), LoadError> {
        let name = &keys.volume;
        let before = self.scene.volumes.len();
        for part in self.parts.get(name, &RawFiles { voxels: keys.raw.map(raw), particles: None })? {
            self.no_particles(name, &part.scene)?;
            if part.scene.volumes.is_empty() || !part.scene.geometry.is_empty() {
                return Err(self.text.error(name.span(), "this is no volume", "write mesh = instead of volume ="));
            }
            let from = self.scene.volumes.len();
            self.scene.merge(part.scene);
            self.report.merge(part.report);
            let shown = if keys.says_how() { Some(self.shown(keys)?) } else { None };
            self.scene.shown[from..].iter_mut().for_each(|place| place.clone_from(&shown));
            self.scene.shown.resize(self.scene.volumes.len(), shown);
        }
        self.note("volume", &name.get_ref().0, None, self.scene.volumes.len() - before);
        Ok(())
    }

    /// What an object says that its volume is shown as.
    fn shown(&self, keys: &keys::Volume) -> Result<Shown, LoadError> {
        let place = self.parts.place();
        let mut shown = Shown { step_length: DEFAULT_STEP, ..Shown::default() };
        shown.transfer = keys.transfer.as_ref().map(|name| self.transfer(name)).transpose()?;
        for Iso(IsoKeys { value, material, transparent }) in keys.iso.iter().flatten() {
            shown.iso.push(value.0);
            let material = material.as_ref().map(|name| self.named.find_plain(&self.text, name)).transpose()?;
            shown.materials.push(material);
            shown.transparent.push(transparent.map_or(0.0, |part| part.0 as f32));
        }
        shown.window = keys.window.map(|(level, width)| [level.0, width.0]);
        shown.lit = match keys.shading {
            None | Some(Named(Shading::Auto)) => None,
            Some(Named(Shading::On)) => Some(true),
            Some(Named(Shading::Off)) => Some(false),
        };
        shown.step_length = keys.step_length.map_or(shown.step_length, |length| length.0 as f32);
        shown.origin = keys.origin.map(|origin| place.put(point(origin)));
        for cut in keys.cut.iter().flatten() {
            let plane = cut.get_ref().map(|x| x.0);
            if plane[..3] == [0.0; 3] {
                let remedy = "write [1, 0, 0, 0.5] for what is right of x = 0.5";
                return Err(self.text.error(cut.span(), "the first three numbers are 0: this is no plane", remedy));
            }
            shown.cuts.push(place.put_plane(plane));
        }
        Ok(shown)
    }

    /// The transfer function that a name means: one of the file, one that is known, or one in a file of its own.
    fn transfer(&self, name: &Spanned<String>) -> Result<Transfer, LoadError> {
        let word = name.get_ref();
        if let Some(function) = self.named.transfers.iter().find(|function| function.name == *word) {
            return Ok(Transfer::Function(Arc::clone(function)));
        }
        if word.eq_ignore_ascii_case("labels") {
            return Ok(Transfer::Labels);
        }
        if let Ok(preset) = word.parse() {
            return Ok(Transfer::Preset(preset));
        }
        let path = self.text.file.parent().unwrap_or(Path::new("")).join(word);
        if word.is_empty() || word.contains('\0') || !input::is_regular(&path) {
            let own = self.named.transfers.iter().map(|function| function.name.as_str());
            let known: Vec<&str> = own.chain(Preset::NAMES.iter().copied()).chain(["labels"]).collect();
            return Err(self.text.unknown_name(name, "transfer function", &known));
        }
        load_transfer(&path).map(|function| Transfer::Function(Arc::new(function)))
    }
}

fn raw(keys: Raw) -> load::Raw {
    load::Raw {
        dims: keys.dims.map(|count| count.0),
        steps: keys.steps.map_or(1, |count| count.0),
        kind: keys.kind.0.kind,
        big_endian: keys.kind.0.big_endian,
        spacing: keys.spacing.map_or([1.0; 3], |spacing| spacing.map(|x| x.0)),
    }
}

/// Gives all of a geometry one material. A kind that has no such thing keeps its own.
fn set_material(geometry: &mut Arc<dyn Geometry>, material: u32) {
    if let Some(meshes) = geometry.downcast_ref::<MeshSequence>() {
        *geometry = Arc::new(meshes.with_material(material));
        return;
    }
    // Files hold meshes and spheres; one that several objects name is shared, and copied here.
    if Arc::get_mut(geometry).is_none() {
        if let Some(mesh) = geometry.downcast_ref::<Mesh>() {
            *geometry = Arc::new(mesh.clone());
        } else if let Some(spheres) = geometry.downcast_ref::<Spheres>() {
            *geometry = Arc::new(spheres.clone());
        }
    }
    let Some(own) = Arc::get_mut(geometry) else { return };
    let any: &mut dyn Any = own;
    if let Some(mesh) = any.downcast_mut::<Mesh>() {
        (mesh.material, mesh.materials) = (material, Vec::new());
    } else if let Some(spheres) = any.downcast_mut::<Spheres>() {
        (spheres.material, spheres.materials) = (material, Vec::new());
    }
}
