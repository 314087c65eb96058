//! Names of files: those that a pattern means, and how names differ.

use std::fs;
use std::path::{Path, PathBuf};

use crate::load::LoadError;

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
pub(super) enum Part {
    Number(u128, String),
    Text(String),
}

/// The parts of a name, which sort as people do: 2 before 10.
pub(super) fn numbered(name: &str) -> Vec<Part> {
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
pub(super) fn differ_at(a: &[Part], b: &[Part]) -> Option<usize> {
    let different: Vec<usize> = (0..a.len().min(b.len())).filter(|&i| a[i] != b[i]).collect();
    match different[..] {
        [at] if a.len() == b.len() => matches!((&a[at], &b[at]), (Part::Number(..), Part::Number(..))).then_some(at),
        _ => None,
    }
}

/// The name of a series: of its files, with a star for the number.
pub(super) fn name(parts: &[Part], at: Option<usize>) -> String {
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
