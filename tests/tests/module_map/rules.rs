//! The two rules: no cycles among files, and the map in the root's documentation is true.

use std::collections::{BTreeMap, BTreeSet, VecDeque};

use crate::imports::{Import, Imports, imports};
use crate::source::{Files, Meaning, Module, modules};

/// Something that a rule forbids.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Violation {
    /// Which: the same words as long as it is there, wherever its lines move to.
    pub(crate) name: String,
    /// Files and lines.
    pub(crate) places: String,
}

/// All violations in a crate, in order.
pub(crate) fn violations(package: &str, files: &Files) -> Vec<Violation> {
    let modules = modules(files);
    let imports = imports(&modules);
    let mut found = cycles(&imports);
    found.extend(wrong_map(&modules, &imports));
    for violation in &mut found {
        violation.name = format!("{package}: {}", violation.name);
        violation.places = violation.places.replace('\t', &format!("    {package}/src/"));
    }
    found.sort();
    found
}

/// A line of [`Violation::places`].
fn place(file: &str, import: &Import) -> String {
    format!("\t{file}:{}: {}\n", import.line, import.path)
}

/// The shortest cycles, short ones first, without those that share an import with one that is in the list already: what is
/// left of those when it is mended, if anything, is found then.
fn cycles(imports: &Imports) -> Vec<Violation> {
    let mut all = BTreeSet::new();
    for (from, targets) in imports {
        for to in targets.keys() {
            let Some(mut cycle) = shortest_path(imports, to, from) else { continue };
            // One cycle has one name: it begins at the least of its files.
            let least = cycle.iter().enumerate().min_by_key(|(_, file)| **file).map_or(0, |(i, _)| i);
            cycle.rotate_left(least);
            cycle.push(cycle[0]);
            all.insert((cycle.len(), cycle));
        }
    }
    let mut listed = BTreeSet::new();
    let mut found = Vec::new();
    for (_, cycle) in all {
        let pairs: Vec<_> = cycle.windows(2).map(|pair| (pair[0], pair[1])).collect();
        if pairs.iter().all(|pair| !listed.contains(pair)) {
            let places = pairs.iter().map(|&(from, to)| place(from, &imports[from][to])).collect();
            found.push(Violation { name: format!("cycle {}", cycle.join(" -> ")), places });
            listed.extend(pairs);
        }
    }
    found
}

/// The files on the shortest way from one to another, both included; the first in order of those that are as short.
fn shortest_path<'a>(imports: &'a Imports, from: &'a str, to: &'a str) -> Option<Vec<&'a str>> {
    let mut came_from = BTreeMap::from([(from, from)]);
    let mut queue = VecDeque::from([from]);
    while let Some(file) = queue.pop_front() {
        if file == to {
            let mut path = vec![to];
            while path[path.len() - 1] != from {
                path.push(came_from[path[path.len() - 1]]);
            }
            path.reverse();
            return Some(path);
        }
        for next in imports.get(file).into_iter().flat_map(|targets| targets.keys()) {
            if !came_from.contains_key(next.as_str()) {
                came_from.insert(next, file);
                queue.push_back(next);
            }
        }
    }
    None
}

/// What the map does not say, or says wrongly.
fn wrong_map(modules: &[Module], imports: &Imports) -> Vec<Violation> {
    let mut found = Vec::new();
    let mut wrong = |name: String, places: String| found.push(Violation { name, places });
    let root = &modules[0];
    let Some(map) = read_map(&root.doc) else {
        wrong("no map".into(), "\tlib.rs: no table under \"# Map\"\n".into());
        return found;
    };
    let mut listed = BTreeSet::new();
    for name in &map {
        if !root.names.contains_key(name) {
            wrong(format!("the map names {name}, which does not exist"), "\tlib.rs\n".into());
        }
        if !listed.insert(name) {
            wrong(format!("the map names {name} twice"), "\tlib.rs\n".into());
        }
    }
    let mut top_level = BTreeMap::new();
    for (name, meanings) in &root.names {
        for meaning in meanings {
            let Meaning::Module(child) = *meaning else { continue };
            if modules[child].file != root.file {
                top_level.insert(modules[child].file.split(['/', '.']).next().unwrap_or_default(), name);
            }
            if modules[child].public && !listed.contains(name) {
                wrong(format!("the map lacks {name}"), format!("\t{}\n", modules[child].file));
            }
        }
    }
    // A file is part of the module that its folder, or else its name, is called after.
    let rank = |file: &str| {
        let name = *top_level.get(file.split(['/', '.']).next()?)?;
        Some((map.iter().position(|listed| listed == name)?, name))
    };
    let mut upward: BTreeMap<String, String> = BTreeMap::new();
    for (file, targets) in imports {
        for (target, import) in targets {
            if let (Some((from, user)), Some((to, used))) = (rank(file), rank(target))
                && to < from
            {
                *upward.entry(format!("{user} uses {used}, which stands above it")).or_default() +=
                    &place(file, import);
            }
        }
    }
    for (name, places) in upward {
        wrong(name, places);
    }
    found
}

/// The modules that the table under `# Map` names in its first column, from top to bottom and from left to right.
fn read_map(doc: &[String]) -> Option<Vec<String>> {
    let after = doc.iter().position(|line| line.trim() == "# Map")? + 1;
    let rows = doc[after..].iter().map(|line| line.trim()).skip_while(|line| !line.starts_with('|'));
    let mut map = Vec::new();
    for row in rows.take_while(|line| line.starts_with('|')) {
        let first = row.split('|').nth(1).unwrap_or_default();
        map.extend(first.split('`').skip(1).step_by(2).map(String::from));
    }
    (!map.is_empty()).then_some(map)
}
