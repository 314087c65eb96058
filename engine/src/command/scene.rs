//! Scenes by name: files, generated ones, and the built-in one.

use std::path::{Path, PathBuf};
use std::time::Instant;

use mobula::geometry::Role;
use mobula::load::series::{self, Gathering, Joined};
use mobula::load::{self, Loaded, Memory, Options, Place, Report, printable};
use mobula::progress::Progress;
use mobula::scene::{Object, SceneDescription};
use mobula::{builtin, generate};

use super::failure::Failure;
use super::progress::watch;
use super::raw::RawOptions;
use super::{say, tell};

/// More warnings than these are only counted.
const MOST_WARNINGS: usize = 8;

/// Loads or makes all scenes and joins them into one; none: the built-in scene. `raw` says what is in files of nothing but numbers.
/// Steps of particles that do not fit into `memory` are read when they are shown. Meshes are smoothed as `smooth` says.
pub(crate) fn gather(
    names: &[PathBuf],
    raw: &RawOptions,
    smooth: Option<f32>,
    memory: &Memory,
) -> Result<Loaded, Failure> {
    let (raw, raw_particles) = (raw.raw(), raw.particles());
    let mut options = Options { raw, raw_particles, smooth, memory: memory.clone(), ..Options::default() };
    let common = options.clone();
    let mut parts = Gathering::new(&common, load::load_with);
    for name in names {
        for name in series::expand(name)? {
            if parts.defers(&name) {
                continue;
            }
            let loaded = open(&name, &options)?;
            // Files that belong together stay together, wherever the first was put.
            options.place = options.place.or(Some(loaded.place));
            parts.add(name, loaded);
        }
    }
    let mut parts = parts.join().into_iter().map(with_objects);
    let Some(mut all) = parts.next() else {
        let mut all = made(builtin::scene());
        all.scene.objects.push(Object { kind: "mesh", names: vec![load::BUILT_IN.into()], material: None, volumes: 0 });
        return Ok(all);
    };
    for Loaded { scene, report, .. } in parts {
        all.scene.merge(scene);
        if report.format == load::SCENE_FILE {
            all.report.format = load::SCENE_FILE;
        }
        all.report.merge(report);
    }
    Ok(all)
}

/// What was loaded, with an object for it unless a scene file said which.
fn with_objects(Joined { files, mut loaded }: Joined) -> Loaded {
    let scene = &mut loaded.scene;
    if loaded.report.format != load::SCENE_FILE {
        let volumes = scene.volumes.len();
        let names = files.iter().map(|file| file.to_string_lossy().into_owned()).collect();
        let kind = match (volumes, scene.particles.len()) {
            (0, 0) => "mesh",
            (0, _) => "particles",
            _ => "volume",
        };
        scene.objects.push(Object { kind, names, material: None, volumes });
    }
    loaded
}

/// Loads or makes one scene, and tells people about it.
fn open(name: &Path, options: &Options) -> Result<Loaded, Failure> {
    let start = Instant::now();
    let options = Options { progress: Progress::default(), ..options.clone() };
    let what = format!("loading {}", printable(&name.display().to_string()));
    let loaded = watch(&what, &options.progress, || open_quietly(name, &options))?;
    warn(&loaded.report.warnings);
    let seconds = start.elapsed().as_secs_f64();
    tell!("mobula: {}: {}, loaded in {seconds:.2} s", printable(&loaded.scene.name), contents(&loaded));
    Ok(loaded)
}

fn open_quietly(name: &Path, options: &Options) -> Result<Loaded, Failure> {
    match name.to_str().filter(|name| name.starts_with(generate::PREFIX)) {
        Some(name) if !generate::has_memory(name) => {
            Err(Failure::Output(format!("{name}: there is no memory for this scene")))
        }
        Some(name) => generate::generate(name).map(made).ok_or_else(|| {
            let known = generate::SCENES.map(|(name, _)| name).join(", ");
            Failure::UnknownScene(printable(name).into_owned(), known)
        }),
        None => load::load_with(name, options).map_err(Failure::Load),
    }
}

/// A scene that no file holds.
fn made(scene: SceneDescription) -> Loaded {
    Loaded { report: Report::of_scene(&scene), scene, place: Place::default() }
}

/// Prints warnings.
pub(crate) fn warn(warnings: &[String]) {
    for warning in warnings.iter().take(MOST_WARNINGS) {
        say!("mobula: warning: {}", printable(warning));
    }
    if warnings.len() > MOST_WARNINGS {
        say!("mobula: warning: {} more warnings", warnings.len() - MOST_WARNINGS);
    }
}

/// What is in a scene, in a few words.
fn contents(loaded: &Loaded) -> String {
    let report = &loaded.report;
    let mut parts = Vec::new();
    let mut add = |count: u64, one: &str, many: &str| {
        if count > 0 {
            parts.push(format!("{} {}", grouped(count), if count == 1 { one } else { many }));
        }
    };
    let of = |role: Role| report.census.items().iter().filter(move |(item, _)| item.role == role);
    of(Role::Primitives).for_each(|(item, count)| add(*count, item.one, item.many));
    add(loaded.scene.materials.len() as u64, "material", "materials");
    for (item, count) in of(Role::LeftOut) {
        add(*count, &format!("{} left out", item.one), &format!("{} left out", item.many));
    }
    parts.join(", ")
}

/// A number with commas between groups of three digits.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_grouped() {
        let texts = [0, 12, 999, 1000, 331_653, 10_240_000].map(grouped);
        assert_eq!(texts, ["0", "12", "999", "1,000", "331,653", "10,240,000"]);
    }

    #[test]
    fn the_built_in_scene_is_counted() {
        let loaded = gather(&[], &RawOptions::default(), None, &Memory::default()).unwrap();
        let census = &loaded.report.census;
        assert!(census.count("triangles") > 0 && census.count("spheres") > 0);
        assert_eq!(census.left_out(), 0);
    }
}
