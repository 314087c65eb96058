//! What particles are shown as, and what people are told of them: attributes with their types, ranges and histograms.

use std::sync::Arc;

use mobula::accel::Build;
use mobula::geometry::Cropping;
use mobula::load::{Place, load_transfer, printable};
use mobula::particles::{Particles, TilingError};
use mobula::scene::{
    ColorBy, Map, OpacityBy, ParticleError, ParticleLook, ParticleNote, SceneDescription, Steps, show_particles,
};
use mobula::volume::{Preset, Statistics};
use serde_json::{Value, json};

use super::failure::Failure;
use super::histogram::{self, short};
use super::particle_options::{Crop, ParticleOptions, Range, Tile};
use super::scene::grouped;
use super::values::{Lengths, Transfer};
use super::{memory, progress, say, tell};

/// Adds to a scene what its particles are shown as: as it says itself, or else as the options do. Returns the options with what was chosen
/// and depends on which steps are in memory, or follows from other options.
pub(crate) fn add(
    scene: &mut SceneDescription,
    options: &ParticleOptions,
    place: &Place,
    steps: Steps,
    build: &Build,
) -> Result<ParticleOptions, Failure> {
    let map = options.map.as_ref().map(map).transpose()?;
    let color = match &options.color_by {
        Some(name) if name == "none" => ColorBy::Material,
        name => ColorBy::Attribute { name: name.clone(), map, range: options.range.map(|Range(range)| range) },
    };
    let mut crops: Vec<Cropping> = Vec::new();
    for Crop { attribute, ranges } in &options.crop {
        if crops.iter().any(|crop| crop.attribute == *attribute) {
            let name = printable(attribute);
            let problem = format!("--crop {name}: write all ranges of an attribute in one, such as {name}=0,1,3,4");
            return Err(Failure::Usage(problem));
        }
        crops.push(Cropping { attribute: attribute.clone(), ranges: ranges.clone() });
    }
    let look = ParticleLook {
        radius: options
            .radius
            .or(options.radius_by.as_ref().map(|_| 1.0))
            .map(|radius| (f64::from(radius) * place.scale) as f32),
        radius_by: options.radius_by.clone(),
        tile: options.tile.map(|Tile(times)| times),
        cell: options.periodic_box.map(|Lengths(sides)| {
            let [x, y, z] = sides.map(|side| (side * place.scale) as f32);
            [[x, 0.0, 0.0], [0.0, y, 0.0], [0.0, 0.0, z]]
        }),
        material: None,
        crops,
        color,
        opacity: options.opacity,
        opacity_by: options
            .opacity_by
            .as_ref()
            .map(|by| OpacityBy { name: by.attribute.clone(), curve: by.curve.clone() }),
    };
    let shown = progress::watch("building", &build.progress, || show_particles(scene, |_| look.clone(), steps, build));
    let notes = shown.map_err(|error| match error {
        ParticleError::Tiling(name, TilingError::NoBox) => Failure::Usage(format!(
            "--tile: {} does not say how large its periodic box is: give its edges with --box X,Y,Z",
            printable(&name)
        )),
        ParticleError::Read(problem) => Failure::Output(printable(&problem).into_owned()),
        error => Failure::Usage(printable(&error.to_string()).into_owned()),
    })?;
    let mut chosen = options.clone();
    for note in notes {
        match note {
            ParticleNote::Guessed { particles, radius } => {
                let (name, radius) = (printable(&particles), short(f64::from(radius) / place.scale));
                tell!("mobula: {name}: particles have no radius; {radius} is guessed; choose another with --radius");
            }
            ParticleNote::NotInMemory { particles, in_memory, steps: all, radius, coloring } => {
                chosen.radius = chosen.radius.or(radius.map(|radius| (f64::from(radius) / place.scale) as f32));
                if let Some((attribute, range)) = coloring {
                    chosen.color_by.get_or_insert(attribute);
                    chosen.range.get_or_insert(Range(range));
                }
                let (name, limit) = (printable(&particles), memory::shown(steps.memory));
                tell!(
                    "mobula: {name}: {in_memory} of {all} steps are in memory ({limit}, see --memory); the others are read when they are shown"
                );
            }
            ParticleNote::Colored { particles, attribute, range, map } => {
                if options.map.is_some() || options.range.is_some() {
                    chosen.color_by.get_or_insert(attribute.clone());
                }
                let [low, high] = range.map(|end| short(f64::from(end)));
                let (name, attribute) = (printable(&particles), printable(&attribute));
                // What has a colour for each value needs no range.
                let map =
                    if ["elements", "labels"].contains(&&*map) { map } else { format!("{map} from {low} to {high}") };
                tell!("mobula: {name}: coloured by {attribute} ({map}); choose with --color-by, --map and --range");
            }
            ParticleNote::NothingShown { particles, attribute, range } => {
                let [low, high] = range.map(|end| short(f64::from(end)));
                let (name, attribute) = (printable(&particles), printable(&attribute));
                say!("mobula: warning: {name}: nothing is shown of it: {attribute} is from {low} to {high}");
            }
        }
    }
    Ok(chosen)
}

/// Which options do nothing in a scene, and why.
pub(crate) fn without_effect(scene: &SceneDescription, options: &ParticleOptions) -> Option<String> {
    let ParticleOptions { radius, radius_by, tile, color_by, crop, opacity, opacity_by, .. } = options;
    let given = [
        ("--radius", radius.is_some()),
        ("--radius-by", radius_by.is_some()),
        ("--tile", tile.is_some()),
        ("--color-by", color_by.is_some()),
        ("--crop", !crop.is_empty()),
        ("--opacity", opacity.is_some()),
        ("--opacity-by", opacity_by.is_some()),
    ];
    let names: Vec<_> = given.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
    let nothing = scene.particles.is_empty() && !names.is_empty();
    nothing.then(|| format!("{}: there are no particles", names.join(", ")))
}

/// The colour map that a word means.
fn map(word: &Transfer) -> Result<Map, Failure> {
    Ok(match word {
        Transfer::Preset(preset) => Map::Preset(*preset),
        Transfer::Labels => Map::Labels,
        Transfer::File(file) if file.as_os_str() == "elements" => Map::Elements,
        Transfer::File(file) if !file.exists() => {
            let known = Preset::NAMES.join(", ");
            let name = printable(&file.display().to_string()).into_owned();
            return Err(Failure::Usage(format!(
                "--map {name}: there is neither a colour map of this name nor such a file; there are {known}, labels and elements"
            )));
        }
        Transfer::File(file) => Map::Function(Arc::new(load_transfer(file)?)),
    })
}

/// What programs are told of particles.
pub(crate) fn object(particles: &Particles, place: &Place) -> Value {
    let Some(sample) = particles.sample() else { return json!({}) };
    let attribute = |(name, kind): (&str, &str), found: &Statistics, scale: f64| {
        let range = found.range.map(|range| range.map(|x| x / scale));
        json!({
            "name": name,
            "type": kind,
            "min": range.map(|[low, _]| low),
            "max": range.map(|[_, high]| high),
            "mean": found.mean.map(|mean| mean / scale),
            "histogram": found.histogram.as_slice(),
            "not_numbers": found.not_numbers,
            "infinite": found.infinite,
        })
    };
    let attributes = sample.attributes.iter().filter_map(|known| {
        let found = particles.statistics(&known.name)?;
        Some(attribute((&known.name, known.type_name()), &found, 1.0))
    });
    let counts: Vec<_> = particles.steps.iter().map(|step| step.as_ref().map(|step| step.centers.len())).collect();
    json!({
        "particle_set": particles.name,
        "steps": particles.steps.len(),
        "particles_by_step": counts,
        "attributes": attributes.collect::<Vec<_>>(),
        "radius": particles.radius_statistics().map(|found| attribute(("radius", "f32"), &found, place.scale)),
        "box": sample.cell.map(|cell| cell.map(|edge| edge.map(|x| f64::from(x) / place.scale))),
    })
}

/// What people are told of particles: names and values, a line each.
pub(crate) fn lines(particles: &Particles, place: &Place) -> Vec<(String, String)> {
    let Some(sample) = particles.sample() else { return Vec::new() };
    let mut lines = Vec::new();
    let mut line = |name: &str, value: String| lines.push((name.to_owned(), value));
    line("particle set", printable(&particles.name).into_owned());
    let (steps, read) = (particles.steps.len(), particles.read().count());
    let looked_at =
        if read < steps { format!(", of which {read} were looked at (see --memory)") } else { String::new() };
    line("  steps of time", format!("{steps}{looked_at}"));
    let counts = || particles.read().map(|step| step.centers.len());
    if let (Some(least), Some(most)) = (counts().min(), counts().max())
        && particles.steps.len() > 1
    {
        let between = if least == most {
            grouped(most as u64)
        } else {
            format!("{} to {}", grouped(least as u64), grouped(most as u64))
        };
        line("  in a step", between);
    }
    if let Some(cell) = sample.cell {
        let back = |x: f32| short(f64::from(x) / place.scale);
        let straight = (0..3).all(|k| (0..3).all(|i| i == k || cell[k][i] == 0.0));
        let edge = |edge: [f32; 3]| format!("({})", edge.map(back).join(", "));
        let sides = [0, 1, 2].map(|k| back(cell[k][k])).join(" x ");
        line("  periodic box", if straight { sides } else { cell.map(edge).join(" ") });
    }
    if sample.radii.is_empty() {
        line("  radius", "none".to_owned());
    }
    let mut values = |name: &str, kind: &str, found: &Statistics, scale: f64| {
        let range = match (found.range, found.mean) {
            (Some([low, high]), Some(mean)) => {
                let [low, high, mean] = [low, high, mean].map(|x| short(x / scale));
                format!("{kind}, {low} to {high}, mean {mean}")
            }
            _ => format!("{kind}, no finite value"),
        };
        let counted =
            |count: u64, what: &str| if count > 0 { format!(", {} {what}", grouped(count)) } else { String::new() };
        let odd = counted(found.not_numbers, "not numbers") + &counted(found.infinite, "infinite");
        line(&format!("  {}", printable(name)), range + &odd);
        if found.range.is_some_and(|[low, high]| low < high) {
            line("", histogram::row(found));
        }
    };
    if let Some(found) = particles.radius_statistics() {
        values("radius", "f32", &found, place.scale);
    }
    for known in &sample.attributes {
        if let Some(found) = particles.statistics(&known.name) {
            values(&known.name, known.type_name(), &found, 1.0);
        }
    }
    lines
}
