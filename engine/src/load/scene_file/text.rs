//! Where in the text something is wrong, and what may have been meant.

use std::ops::Range;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;
use toml::de::{DeTable, DeValue, ValueDeserializer};

use crate::load::LoadError;

/// No message is longer.
const LONGEST: usize = 240;
/// Words are taken to be meant for each other from this likeness on.
const ALIKE: f64 = 0.7;
/// What to do about a value that cannot be.
const REMEDY: &str = "see SCENES.md for what may stand here";

/// The text of a scene file.
#[derive(Clone, Copy, Debug)]
pub(super) struct Text<'a> {
    pub(super) file: &'a Path,
    pub(super) text: &'a str,
}

impl<'a> Text<'a> {
    /// The tables of the text.
    pub(super) fn parse(&self) -> Result<DeTable<'a>, LoadError> {
        let parsed = DeTable::parse(self.text).map(Spanned::into_inner);
        parsed.map_err(|error| {
            let problem = format!("this is not TOML: {}", shortened(error.message()));
            let remedy = "check quotes, brackets and commas";
            match error.span() {
                Some(span) => self.error(span, problem, remedy),
                None => LoadError::new(self.file, problem, remedy),
            }
        })
    }

    /// A value as what it should be.
    pub(super) fn read<'de, T: Deserialize<'de>>(&self, value: Spanned<DeValue<'de>>) -> Result<T, LoadError> {
        let span = value.span();
        T::deserialize(ValueDeserializer::from(value)).map_err(|error| self.explained(&error, span))
    }

    /// An error at a place of the text.
    pub(super) fn error(&self, span: Range<usize>, problem: impl Into<String>, remedy: impl Into<String>) -> LoadError {
        let before = self.text.get(..span.start).unwrap_or(self.text);
        let line = before.matches('\n').count() as u64 + 1;
        let column = before.rsplit('\n').next().unwrap_or_default().chars().count() as u64 + 1;
        LoadError::new(self.file, problem, remedy).at_column(line, column)
    }

    /// What is wrong with a value in `within`, in our words where it is an unknown or a missing key.
    pub(super) fn explained(&self, error: &toml::de::Error, within: Range<usize>) -> LoadError {
        let span = error.span().filter(|span| !span.is_empty()).unwrap_or(within);
        let message = error.message();
        if let Some((key, known)) = message.strip_prefix("unknown field `").and_then(|rest| rest.split_once("`, ")) {
            let known: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
            return self.unknown_key(span, key, &known);
        }
        if let Some(key) = message.strip_prefix("missing field `").and_then(|rest| rest.strip_suffix('`')) {
            return self.error(span, format!("the key `{key}` is missing"), format!("write {key} = ..."));
        }
        self.error(span, shortened(message), REMEDY)
    }

    /// A key that does not belong where it is.
    pub(super) fn unknown_key(&self, span: Range<usize>, key: &str, known: &[&str]) -> LoadError {
        let remedy = if known.is_empty() { "leave it out".to_owned() } else { meant(key, known, "the keys here are") };
        self.error(span, format!("there is no key `{}` here", shortened(key)), remedy)
    }

    /// A name that nothing has.
    pub(super) fn unknown_name(&self, name: &Spanned<String>, what: &str, known: &[&str]) -> LoadError {
        let problem = format!("no {what} is called \"{}\"", shortened(name.get_ref()));
        let remedy = match known {
            [] => format!("define it, or leave out what names a {what}"),
            known => meant(name.get_ref(), known, "there are"),
        };
        self.error(name.span(), problem, remedy)
    }
}

/// What may have been meant by a word, and what there is.
fn meant(word: &str, known: &[&str], all: &str) -> String {
    let likeness = |known: &&&str| strsim::jaro(known, &word.to_lowercase());
    let best = known.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    let best = best.filter(|best| word.len() < LONGEST && likeness(best) > ALIKE);
    let suggestion = best.map(|best| format!("do you mean {best}? ")).unwrap_or_default();
    format!("{suggestion}{all} {}", shortened(&known.join(", ")))
}

/// A text that fits on a line.
pub(super) fn shortened(text: &str) -> String {
    match text.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    }
}
