//! Headers of text: fields with a name, a value and the line where they stand.

use std::path::Path;

use crate::load::LoadError;
use crate::load::lines::Fault;
use crate::load::text::{counted, number, quoted};

/// A longer line is in no header of voxels.
pub(super) const LONGEST_LINE: usize = 1 << 16;
/// More fields are in none.
const MOST_FIELDS: usize = 1 << 10;

/// A fault and its line.
#[derive(Debug)]
pub(super) struct Wrong {
    fault: Fault,
    line: u64,
}

impl Wrong {
    pub(super) fn new(line: u64, problem: impl Into<String>, remedy: &'static str) -> Self {
        Self { fault: Fault::new(problem, remedy), line }
    }

    /// The error in a file.
    pub(super) fn into_error(self, file: &Path) -> LoadError {
        LoadError::new(file, self.fault.problem, self.fault.remedy).at(self.line)
    }
}

/// The fields of a header.
#[derive(Debug, Default)]
pub(super) struct Fields(Vec<Field>);

/// A field of a header.
#[derive(Debug)]
pub(super) struct Field {
    /// Its name as formats define it.
    name: &'static str,
    pub(super) value: String,
    line: u64,
}

impl Fields {
    /// Adds a field, of which there may be one of a name.
    pub(super) fn add(&mut self, name: &'static str, value: &str, line: u64) -> Result<(), Wrong> {
        if let Some(first) = self.get(name) {
            let problem = format!("'{name}' stands here and in line {}", first.line);
            return Err(Wrong::new(line, problem, "leave one of them out"));
        }
        if self.0.len() >= MOST_FIELDS {
            return Err(Wrong::new(line, "the header has too many fields", "check that it is what its name says"));
        }
        self.0.push(Field { name, value: value.trim().to_owned(), line });
        Ok(())
    }

    /// The field of a name.
    pub(super) fn get(&self, name: &str) -> Option<&Field> {
        self.0.iter().find(|field| field.name == name)
    }

    /// The first field of several names.
    pub(super) fn any(&self, names: &[&str]) -> Option<&Field> {
        names.iter().find_map(|name| self.get(name))
    }

    /// The field of a name, which must be there; else the error at the last line.
    pub(super) fn required(&self, name: &'static str, last: u64) -> Result<&Field, Wrong> {
        let missing = || Wrong::new(last, format!("the header has no '{name}'"), "check how it was written");
        self.get(name).ok_or_else(missing)
    }
}

impl Field {
    /// What is wrong with it.
    pub(super) fn wrong(&self, problem: impl AsRef<str>, remedy: &'static str) -> Wrong {
        Wrong::new(self.line, format!("{} {}", self.name, problem.as_ref()), remedy)
    }

    /// What was found wrong where it stands.
    pub(super) fn at(&self, fault: Fault) -> Wrong {
        Wrong { fault, line: self.line }
    }

    /// Its words.
    pub(super) fn words(&self) -> Vec<&str> {
        self.value.split_whitespace().collect()
    }

    /// Its words, of which there must be so many.
    pub(super) fn so_many_words(&self, count: usize) -> Result<Vec<&str>, Wrong> {
        let words = self.words();
        self.so_many(&words, count)?;
        Ok(words)
    }

    /// Checks how many values there are.
    pub(super) fn so_many<T>(&self, values: &[T], count: usize) -> Result<(), Wrong> {
        if values.len() == count {
            return Ok(());
        }
        let problem = format!("has {}, not {count}", counted(values.len() as u64, "value"));
        Err(self.wrong(problem, "give one for each dimension"))
    }

    /// A value that is a size.
    pub(super) fn size(&self, word: &str) -> Result<u64, Wrong> {
        word.parse().map_err(|_| {
            let problem = format!("{} is not a whole number, or too large", quoted(word));
            self.wrong(problem, "check how it was written")
        })
    }

    /// A value that is a whole number.
    pub(super) fn whole(&self, word: &str) -> Result<i64, Wrong> {
        let problem = || format!("{} is not a whole number", quoted(word));
        word.parse().map_err(|_| self.wrong(problem(), "check how it was written"))
    }

    /// A value that is a number, perhaps not a finite one.
    pub(super) fn number(&self, word: &str) -> Result<f64, Wrong> {
        let problem = || format!("{} is not a number", quoted(word));
        number(word).ok_or_else(|| self.wrong(problem(), "check how it was written"))
    }

    /// So many numbers.
    pub(super) fn numbers(&self, count: usize) -> Result<Vec<f64>, Wrong> {
        self.so_many_words(count)?.into_iter().map(|word| self.number(word)).collect()
    }
}
