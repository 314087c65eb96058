//! Which file uses which, and where: every `use` and every path in the code, followed through re-exports to the file that
//! defines what is meant.

use std::collections::{BTreeMap, HashSet};

use proc_macro2::{Delimiter, Group, TokenStream, TokenTree};

use crate::source::{Meaning, Module, is_punct, is_test_attribute};

/// Where a file first uses another.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Import {
    /// Line in the file that uses.
    pub(crate) line: usize,
    /// What it uses.
    pub(crate) path: String,
}

/// The imports of each file, by the file that is imported.
pub(crate) type Imports = BTreeMap<String, BTreeMap<String, Import>>;

/// All imports among the files of a crate. A module that re-exports what is below it does not import it by that.
pub(crate) fn imports(modules: &[Module]) -> Imports {
    let names = Names(modules);
    let mut imports = Imports::new();
    let mut add = |this: usize, meant: Vec<Meant>, line: usize, path: &[String]| {
        for meant in meant {
            if let Meant::Item(there) = meant
                && modules[there].file != modules[this].file
            {
                let of_file = imports.entry(modules[this].file.clone()).or_default();
                let new = Import { line, path: path.join("::") };
                let import = of_file.entry(modules[there].file.clone()).or_insert_with(|| new.clone());
                if line < import.line {
                    *import = new;
                }
            }
        }
    };
    for (this, module) in modules.iter().enumerate() {
        for used in &module.uses {
            let mut meant = names.meaning(this, &used.path, &mut HashSet::new());
            if used.public {
                meant.retain(|meant| !names.is_below(meant.module(), this));
            }
            if used.glob {
                // All of a module's names: as good as the use of one that it defines.
                meant = meant.into_iter().map(|meant| Meant::Item(meant.module())).collect();
            }
            add(this, meant, used.line, &used.path);
        }
        for body in &module.bodies {
            paths(body.clone(), &mut |path, line, called| {
                let plain = path.len() == 1 && !called && path[0].starts_with(|c: char| c.is_lowercase());
                if !plain {
                    add(this, names.meaning(this, path, &mut HashSet::new()), line, path);
                }
            });
        }
    }
    imports
}

/// What a path means.
#[derive(Clone, Copy, PartialEq)]
enum Meant {
    /// Something that this module defines.
    Item(usize),
    /// This module itself.
    Module(usize),
}

impl Meant {
    fn module(self) -> usize {
        match self {
            Self::Item(module) | Self::Module(module) => module,
        }
    }
}

struct Names<'a>(&'a [Module]);

impl Names<'_> {
    /// All that a path may mean where it is written in a module; nothing, if it leads out of the crate.
    fn meaning(&self, this: usize, path: &[String], seen: &mut HashSet<(usize, String)>) -> Vec<Meant> {
        let mut meant = match path[0].as_str() {
            "crate" => vec![Meant::Module(0)],
            "self" => vec![Meant::Module(this)],
            "super" => self.0[this].parent.map(Meant::Module).into_iter().collect(),
            name => self.lookup(this, name, seen),
        };
        for name in &path[1..] {
            let modules: Vec<_> = meant.iter().filter(|meant| matches!(meant, Meant::Module(_))).copied().collect();
            if modules.is_empty() {
                // A variant, a constant or a function of what was found.
                break;
            }
            meant.clear();
            for module in modules.into_iter().map(Meant::module) {
                if name == "super" {
                    meant.extend(self.0[module].parent.map(Meant::Module));
                    continue;
                }
                let found = self.lookup(module, name, seen);
                // A name that nothing declares: a macro made it in that module.
                let made = found.is_empty().then_some(Meant::Item(module));
                meant.extend(found.into_iter().chain(made));
            }
        }
        meant
    }

    /// What a name stands for in a module. While it is `seen`, what is declared there under this name is all it can be:
    /// in `mod a; pub use a::a;` the first `a` of the path is the module.
    fn lookup(&self, this: usize, name: &str, seen: &mut HashSet<(usize, String)>) -> Vec<Meant> {
        let module = &self.0[this];
        let first = seen.insert((this, name.into()));
        let mut meant = Vec::new();
        for meaning in module.names.get(name).into_iter().flatten() {
            match *meaning {
                Meaning::Item(definer) => meant.push(Meant::Item(definer)),
                Meaning::Module(child) => meant.push(Meant::Module(child)),
                Meaning::Use(number) if first => meant.extend(self.meaning(this, &module.uses[number].path, seen)),
                Meaning::Use(_) => {}
            }
        }
        if first && !module.names.contains_key(name) {
            for glob in module.uses.iter().filter(|used| used.glob) {
                for source in self.meaning(this, &glob.path, seen) {
                    if let Meant::Module(source) = source {
                        meant.extend(self.lookup(source, name, seen));
                    }
                }
            }
        }
        if first {
            seen.remove(&(this, name.into()));
        }
        meant
    }

    /// Is a module a descendant of another?
    fn is_below(&self, mut module: usize, ancestor: usize) -> bool {
        while let Some(parent) = self.0[module].parent {
            if parent == ancestor {
                return true;
            }
            module = parent;
        }
        false
    }
}

/// Calls `found` with every path in code that is not for tests, its line, and whether it is called like a function or macro.
fn paths(tokens: TokenStream, found: &mut impl FnMut(&[String], usize, bool)) {
    let tokens: Vec<_> = tokens.into_iter().collect();
    let at = |i: usize, what| tokens.get(i).is_some_and(|token| is_punct(token, what));
    let before = |i: usize, n: usize, what| i >= n && at(i - n, what);
    let mut i = 0;
    while i < tokens.len() {
        match &tokens[i] {
            // An attribute is no code.
            TokenTree::Group(group) if before(i, 1, '#') || before(i, 1, '!') && before(i, 2, '#') => {
                i += for_tests(group, &tokens[i + 1..]);
            }
            TokenTree::Group(group) => paths(group.stream(), found),
            TokenTree::Ident(first) if first == "use" && !at(i + 1, '<') => {
                // Read already.
                while i < tokens.len() && !at(i, ';') {
                    i += 1;
                }
            }
            TokenTree::Ident(first) => {
                let line = first.span().start().line;
                let field = before(i, 1, '.') && !before(i, 2, '.');
                let goes_on = before(i, 1, ':') && before(i, 2, ':');
                let lifetime = before(i, 1, '\'');
                let of_macro = before(i, 1, '$') && first != "crate";
                let defines =
                    i > 0 && matches!(&tokens[i - 1], TokenTree::Ident(word) if is_definer(&word.to_string()));
                let mut path = vec![first.to_string()];
                while at(i + 1, ':') && at(i + 2, ':') {
                    let Some(TokenTree::Ident(next)) = tokens.get(i + 3) else { break };
                    path.push(next.to_string());
                    i += 3;
                }
                let turbofish = at(i + 1, ':') && at(i + 2, ':') && at(i + 3, '<');
                let arguments = matches!(tokens.get(i + 1), Some(TokenTree::Group(group))
                    if group.delimiter() == Delimiter::Parenthesis);
                if !(field || goes_on || lifetime || of_macro || defines) {
                    found(&path, line, turbofish || arguments || at(i + 1, '!'));
                }
            }
            _ => {}
        }
        i += 1;
    }
}

/// How many of the tokens after an attribute are what it leaves to tests.
fn for_tests(attribute: &Group, after: &[TokenTree]) -> usize {
    let ends = |token: &TokenTree| match token {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        token => is_punct(token, ';'),
    };
    match after.iter().position(ends) {
        _ if !is_test_attribute(attribute) => 0,
        Some(end) => end + 1,
        None => after.len(),
    }
}

/// Does the name of something new stand after this word?
fn is_definer(word: &str) -> bool {
    ["fn", "struct", "enum", "trait", "type", "const", "static", "union", "mod", "let"].contains(&word)
}
