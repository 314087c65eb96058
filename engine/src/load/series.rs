//! Files of volumes, or of particles, whose names differ only in a number: the steps of time of one.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::{LoadError, Loaded};
use crate::scene::SceneDescription;
use crate::volume::Grid;

/// The files that a pattern means, in the order of their numbers: `*` stands for anything, `?` for a character, `#` for a digit.
/// What is the name of a file, and what is no pattern, stands for itself.
///
/// # Errors
/// If there is none.
pub fn expand(name: &Path) -> Result<Vec<PathBuf>, LoadError> {
    let pattern = name.file_name().and_then(|pattern| pattern.to_str()).unwrap_or_default();
    if !pattern.contains(['*', '?', '#']) || name.exists() {
        return Ok(vec![name.to_owned()]);
    }
    let folder = name.parent().filter(|folder| *folder != Path::new(""));
    let entries = fs::read_dir(folder.unwrap_or(Path::new("."))).map(|entries| entries.flatten().collect());
    let entries: Vec<_> = entries.unwrap_or_default();
    let pattern: Vec<char> = pattern.chars().collect();
    let matching = |name: &str| matches(&pattern, &name.chars().collect::<Vec<_>>());
    let mut names: Vec<String> = entries.iter().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    // What is hidden is not meant.
    names.retain(|name| !name.starts_with('.') && matching(name));
    if names.is_empty() {
        return Err(LoadError::new(name, "no file has a name like this", "check the path"));
    }
    names.sort_by_cached_key(|name| numbered(name));
    Ok(names.into_iter().map(|name| folder.map_or(PathBuf::from(&name), |folder| folder.join(&name))).collect())
}

/// Does a name match a pattern?
fn matches(pattern: &[char], name: &[char]) -> bool {
    let (mut p, mut n) = (0, 0);
    // Where the last star is, and how far what it stands for has been tried.
    let mut star = None;
    while n < name.len() {
        match pattern.get(p) {
            Some('*') => {
                star = Some((p, n));
                p += 1;
            }
            Some(&c) if c == '?' || c == name[n] || (c == '#' && name[n].is_ascii_digit()) => {
                p += 1;
                n += 1;
            }
            _ => match &mut star {
                Some((at, tried)) => {
                    *tried += 1;
                    (p, n) = (*at + 1, *tried);
                }
                None => return false,
            },
        }
    }
    pattern[p..].iter().all(|&c| c == '*')
}

/// A part of a name: a number, its digits, or what is between numbers.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Number(u128, String),
    Text(String),
}

/// The parts of a name, which sort as people do: 2 before 10.
fn numbered(name: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut rest = name;
    while let Some(first) = rest.chars().next() {
        let digits = first.is_ascii_digit();
        let end = rest.find(|c: char| c.is_ascii_digit() != digits).unwrap_or(rest.len());
        let (part, after) = rest.split_at(end);
        parts.push(match part.parse() {
            Ok(number) if digits => Part::Number(number, part.to_owned()),
            _ => Part::Text(part.to_owned()),
        });
        rest = after;
    }
    parts
}

/// The one place where two names have different numbers and are otherwise the same.
fn differ_at(a: &[Part], b: &[Part]) -> Option<usize> {
    let different: Vec<usize> = (0..a.len().min(b.len())).filter(|&i| a[i] != b[i]).collect();
    match different[..] {
        [at] if a.len() == b.len() => matches!((&a[at], &b[at]), (Part::Number(..), Part::Number(..))).then_some(at),
        _ => None,
    }
}

/// What was loaded, and from which files: several are the steps of time of one volume.
#[derive(Clone, Debug)]
pub struct Joined {
    /// The files, in the order of their numbers.
    pub files: Vec<PathBuf>,
    /// What is in them.
    pub loaded: Loaded,
}

/// Files of one series.
struct Series {
    /// The parts of the first name.
    parts: Vec<Part>,
    /// Where names differ, once there are two.
    at: Option<usize>,
    files: Vec<(Vec<Part>, PathBuf, Loaded)>,
}

/// Makes one scene of all files that are the steps of time of one volume, or of the same particles: whose names differ only in a number,
/// and whose grids have the same sides, places and types, or whose particles have the same attributes. Others stay what they are.
pub fn join(all: Vec<(PathBuf, Loaded)>) -> Vec<Joined> {
    let mut list: Vec<Series> = Vec::new();
    for (name, loaded) in all {
        let parts = numbered(&name.to_string_lossy());
        let fits = |series: &Series| {
            let first = &series.files[0].2;
            let at = differ_at(&series.parts, &parts).filter(|&at| series.at.is_none_or(|there| there == at));
            at.filter(|_| alike(first, &loaded))
        };
        match list.iter_mut().find_map(|series| fits(series).map(|at| (series, at))) {
            Some((series, at)) => {
                series.at = Some(at);
                series.files.push((parts, name, loaded));
            }
            None => list.push(Series { parts: parts.clone(), at: None, files: vec![(parts, name, loaded)] }),
        }
    }
    list.into_iter().map(Series::join).collect()
}

/// Are both one volume of the same samples, or particles with the same attributes, and nothing else?
fn alike(a: &Loaded, b: &Loaded) -> bool {
    let parts = |loaded: &Loaded| {
        let SceneDescription { geometry, volumes, particles, .. } = &loaded.scene;
        (geometry.len(), volumes.len(), particles.len())
    };
    // What a scene file puts together is more than that.
    if [a, b].iter().any(|one| !one.scene.shown.is_empty() || !one.scene.particle_looks.is_empty()) {
        return false;
    }
    match (parts(a), parts(b)) {
        ((0, 1, 0), (0, 1, 0)) => {
            let grid = |loaded: &Loaded| loaded.scene.volumes.first()?.steps.first().cloned();
            let samples = |grid: Arc<Grid>| (grid.dims(), *grid.place(), grid.voxels().type_name());
            grid(a).map(samples) == grid(b).map(samples)
        }
        ((0, 0, 1), (0, 0, 1)) => {
            let sample = |loaded: &Loaded| loaded.scene.particles.first()?.sample().cloned();
            sample(a).zip(sample(b)).is_some_and(|(a, b)| a.goes_with(&b))
        }
        _ => false,
    }
}

impl Series {
    /// One scene of all files, in the order of their numbers.
    fn join(mut self) -> Joined {
        self.files.sort_by(|(a, ..), (b, ..)| a.cmp(b));
        let several = self.files.len() > 1;
        let mut files = Vec::with_capacity(self.files.len());
        let mut steps = self.files.into_iter().map(|(_, file, loaded)| {
            files.push(file);
            loaded
        });
        let mut joined = steps.next().expect("at least one");
        for mut loaded in steps {
            for (all, volume) in joined.scene.volumes.iter_mut().zip(loaded.scene.volumes.drain(..)) {
                all.steps.extend(volume.steps);
            }
            for (all, particles) in joined.scene.particles.iter_mut().zip(loaded.scene.particles.drain(..)) {
                all.steps.extend(particles.steps);
            }
            joined.report.merge(loaded.report);
        }
        if several {
            let name = name(&self.parts, self.at);
            joined.scene.volumes.iter_mut().for_each(|volume| volume.name.clone_from(&name));
            for particles in &mut joined.scene.particles {
                particles.name.clone_from(&name);
                particles.unify();
            }
            joined.scene.name = name;
        }
        Joined { files, loaded: joined }
    }
}

/// The name of a series: of its files, with a star for the number.
fn name(parts: &[Part], at: Option<usize>) -> String {
    let part = |(i, part): (usize, &Part)| match part {
        _ if Some(i) == at => "*".to_owned(),
        Part::Number(_, text) | Part::Text(text) => text.clone(),
    };
    let name: String = parts.iter().enumerate().map(part).collect();
    let name = Path::new(&name).file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let name = name.strip_suffix(".gz").unwrap_or(&name);
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patterns_match() {
        let all = |text: &str| text.chars().collect::<Vec<_>>();
        for (pattern, name, expected) in [
            ("a*.nrrd", "a12.nrrd", true),
            ("a*.nrrd", "a.nrrd", true),
            ("a*.nrrd", "a12.nrrd.gz", false),
            ("a##.nrrd", "a12.nrrd", true),
            ("a##.nrrd", "a1x.nrrd", false),
            ("a?.nrrd", "ax.nrrd", true),
            ("*a*b*", "xaxxbx", true),
            ("*a*b*", "xbxxax", false),
            ("*", "", true),
        ] {
            assert_eq!(matches(&all(pattern), &all(name)), expected, "{pattern} {name}");
        }
    }

    #[test]
    fn names_sort_by_their_numbers() {
        let mut names = ["t10.nrrd", "t9.nrrd", "t010.nrrd", "a.nrrd"];
        names.sort_by_cached_key(|name| numbered(name));
        assert_eq!(names, ["a.nrrd", "t9.nrrd", "t010.nrrd", "t10.nrrd"]);
        let at = |a, b| differ_at(&numbered(a), &numbered(b));
        assert_eq!(at("v2/t1.nrrd", "v2/t12.nrrd"), Some(3));
        assert_eq!(at("v2/t1.nrrd", "v3/t12.nrrd"), None);
        assert_eq!(at("t1.nrrd", "t1.nrrd"), None);
        assert_eq!(at("t1.nrrd", "s2.nrrd"), None);
        assert_eq!(name(&numbered("v2/t1.nrrd.gz"), Some(3)), "t*");
    }
}
