//! What the second line of an extended XYZ file says: which columns there are, and the periodic box.

use super::columns::MOST_COLUMNS;
use super::periodic::{self, Cell};
use crate::load::lines::Fault;
use crate::load::text::{number, quoted};

/// What the second line of a frame says.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Extended {
    /// Names of the columns; empty: it does not say.
    pub(super) names: Vec<String>,
    pub(super) cell: Option<Cell>,
}

/// Reads the second line of a frame.
pub(super) fn read(line: &str) -> Result<Extended, Fault> {
    let mut found = Extended { cell: periodic::of_comment(line), ..Extended::default() };
    for (key, value) in pairs(line) {
        match key.to_ascii_lowercase().as_str() {
            "properties" => found.names = names(value)?,
            "lattice" | "cell" => {
                let words = value.split(|c: char| c.is_whitespace() || ",[]".contains(c));
                let numbers: Option<Vec<f64>> = words.filter(|word| !word.is_empty()).map(number).collect();
                let cell = numbers.and_then(|numbers| periodic::of_numbers(&numbers));
                let not = || Fault::new(format!("{} {} is no box", quoted(key), quoted(value)), "give nine numbers");
                found.cell = Some(cell.ok_or_else(not)?);
            }
            _ => {}
        }
    }
    Ok(found)
}

/// Keys and values of a line: `key=value`, where a value with blanks is in quotes.
fn pairs(line: &str) -> impl Iterator<Item = (&str, &str)> {
    let mut rest = line;
    std::iter::from_fn(move || {
        let (before, after) = rest.split_once('=')?;
        let key = before.rsplit(char::is_whitespace).next().unwrap_or_default();
        let quoted = ['"', '\''].into_iter().find_map(|quote| after.strip_prefix(quote)?.split_once(quote));
        let (value, after) =
            quoted.unwrap_or_else(|| after.split_at(after.find(char::is_whitespace).unwrap_or(after.len())));
        rest = after;
        Some((key, value))
    })
}

/// The columns that a value of `Properties` names: `species:S:1:pos:R:3`.
fn names(value: &str) -> Result<Vec<String>, Fault> {
    let fault = |problem: String| Fault::new(problem, "write it as in Properties=species:S:1:pos:R:3");
    let words: Vec<&str> = value.split(':').collect();
    let (triples, rest) = words.as_chunks::<3>();
    if !rest.is_empty() {
        return Err(fault(format!("Properties {} are no triples of name, type and count", quoted(value))));
    }
    let mut all = Vec::new();
    for [name, _, count] in triples {
        let count = count.parse().ok().filter(|count| (1..=MOST_COLUMNS).contains(count));
        let count: usize =
            count.ok_or_else(|| fault(format!("the property {} has no sensible count", quoted(name))))?;
        let axes = |[x, y, z]: [&str; 3]| [x, y, z].map(str::to_owned).to_vec();
        all.extend(match (name.to_ascii_lowercase().as_str(), count) {
            ("species" | "element", 1) => vec!["element".to_owned()],
            ("pos" | "position" | "positions", 3) => axes(["x", "y", "z"]),
            ("velo" | "vel" | "velocity" | "velocities", 3) => axes(["vx", "vy", "vz"]),
            ("force" | "forces", 3) => axes(["fx", "fy", "fz"]),
            (_, 1) => vec![(*name).to_owned()],
            (_, 3) => ["x", "y", "z"].map(|axis| format!("{name}_{axis}")).to_vec(),
            _ => (1..=count).map(|number| format!("{name}_{number}")).collect(),
        });
        if all.len() > MOST_COLUMNS {
            return Err(fault(format!("there are more than {MOST_COLUMNS} columns")));
        }
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_and_box() {
        let line = r#"Lattice="4 0 0 0 5 0 1 0 6" Properties=species:S:1:pos:R:3:velo:R:3:q:R:1:dip:R:3:t:R:2 Time=0.5 pbc='T T F'"#;
        let found = read(line).unwrap();
        let expected = ["element", "x", "y", "z", "vx", "vy", "vz", "q", "dip_x", "dip_y", "dip_z", "t_1", "t_2"]
            .map(str::to_owned);
        assert_eq!(found.names, expected);
        assert_eq!(found.cell, Some([[4.0, 0.0, 0.0], [0.0, 5.0, 0.0], [1.0, 0.0, 6.0]]));
        assert_eq!(read("a water molecule, t = 0.5").unwrap(), Extended::default());
        assert!(read("box 1 2 3").unwrap().cell.is_some());
        for (line, expected) in [
            ("Lattice=\"1 2\"", "is no box"),
            ("Properties=pos:R", "no triples"),
            ("Properties=pos:R:0", "no sensible count"),
            ("Properties=pos:R:99999999999", "no sensible count"),
            ("Properties=a:R:200:b:R:200", "more than 256 columns"),
        ] {
            assert!(read(line).unwrap_err().problem.contains(expected), "{line}");
        }
    }
}
