//! Which axes of an NRRD file are those of space and of time, and where in space samples are.

use glam::{DVec3, DVec4};

use super::fields::{Field, Fields, Wrong};
use crate::load::text::{counted, quoted};
use crate::view::Up;
use crate::volume::GridPlace;

/// What the axes of an NRRD file are.
#[derive(Debug)]
pub(super) struct Axes<'a> {
    /// Those of space.
    pub(super) in_space: [usize; 3],
    /// That of time.
    pub(super) in_time: Option<usize>,
    pub(super) place: GridPlace,
    /// What says where samples are.
    pub(super) placed_by: Option<&'a Field>,
    /// Which way is up, where the space has a name that says so.
    pub(super) up: Option<Up>,
    /// What people should know.
    pub(super) warning: Option<&'static str>,
}

/// What an axis is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    Space,
    Time,
    /// Nothing: it has one sample.
    Nothing,
    Unknown,
}

impl<'a> Axes<'a> {
    /// What fields say about axes of these sizes.
    pub(super) fn of(fields: &'a Fields, sizes: &[u64]) -> Result<Self, Wrong> {
        let count = sizes.len();
        let mut roles = match fields.get("kinds") {
            Some(field) => {
                let words = field.so_many_words(count)?;
                (0..count).map(|axis| role(field, axis, words[axis], sizes[axis])).collect::<Result<Vec<_>, _>>()?
            }
            None => vec![Role::Unknown; count],
        };
        let with_directions = fields.get("space directions");
        let directions = with_directions.map(|field| directions(field, &mut roles)).transpose()?;
        let of_axis = |name| fields.get(name).map(|field| field.numbers(count)).transpose();
        let [spacings, mins, maxs] = [of_axis("spacings")?, of_axis("axis mins")?, of_axis("axis maxs")?];

        // What kinds do not say the directions do, or a spacing that is none.
        let four = roles.iter().filter(|&&role| role != Role::Nothing).count() > 3;
        for (axis, role) in roles.iter_mut().enumerate().filter(|(_, role)| **role == Role::Unknown) {
            let placed = match (&directions, &spacings) {
                (Some(directions), _) => directions[axis].is_some(),
                (None, Some(spacings)) => !(four && spacings[axis].is_nan()),
                (None, None) => true,
            };
            *role = if placed { Role::Space } else { Role::Time };
        }
        let all = |wanted: Role| (0..count).filter(|&axis| roles[axis] == wanted).collect::<Vec<_>>();
        let (mut in_space, mut in_time) = (all(Role::Space), all(Role::Time));
        let mut warning = None;
        if in_space.len() == 4 && in_time.is_empty() {
            in_time.extend(in_space.pop());
            warning = Some("the header does not say which dimension is time; the last is taken");
        }
        let field = fields.any(&["kinds", "sizes"]);
        let wrong = |problem: String, remedy| match field {
            Some(field) => field.wrong(problem, remedy),
            None => Wrong::new(1, problem, remedy),
        };
        let &[x, y, z] = &in_space[..] else {
            let problem = format!("give {} of space: a volume has three", counted(in_space.len() as u64, "dimension"));
            let remedy = if in_space.len() < 3 { "pictures and lines cannot be loaded" } else { "cut the others" };
            return Err(wrong(problem, remedy));
        };
        let in_space = [x, y, z];
        if let (Some(directions), Some(field)) = (&directions, with_directions)
            && let Some(axis) = in_space.into_iter().find(|&axis| directions[axis].is_none())
        {
            let problem = format!("has none for dimension {}, which is one of space", axis + 1);
            return Err(field.wrong(problem, "give each a direction"));
        }
        if in_time.len() > 1 {
            return Err(wrong(format!("give {} dimensions beside space", in_time.len()), "cut all but time"));
        }

        let mut place = GridPlace::with_spacing([1.0; 3]);
        for (k, &axis) in in_space.iter().enumerate() {
            let unit = [DVec3::X, DVec3::Y, DVec3::Z][k];
            // From the middle of the first to that of the last sample, or from border to border.
            let cells = fields.get("centers").is_none_or(|field| field.words().get(axis) != Some(&"node"));
            let min = mins.as_ref().map_or(f64::NAN, |mins| mins[axis]);
            let max = maxs.as_ref().map_or(f64::NAN, |maxs| maxs[axis]);
            let parts = if cells { sizes[axis] } else { sizes[axis].saturating_sub(1) };
            let ranged = (max - min) / parts.max(1) as f64;
            let spaced = spacings.as_ref().map_or(f64::NAN, |spacings| spacings[axis]);
            let directed = directions.as_ref().and_then(|directions| directions[axis]);
            let spacing = match (&spacings, ranged.is_finite()) {
                (None, true) => ranged,
                (None, false) => 1.0,
                (Some(_), ranges) => {
                    if spaced.is_nan() && ranges {
                        ranged
                    } else {
                        spaced
                    }
                }
            };
            place.axes[k] = directed.unwrap_or(unit * spacing);
            if directed.is_none() && min.is_finite() {
                place.origin[k] = if cells { min + spacing / 2.0 } else { min };
            }
        }
        if let Some(field) = fields.get("space origin") {
            place.origin = match vectors(field)?[..] {
                [Some(origin)] => origin.truncate(),
                _ => return Err(field.wrong("is not one point", "write it as (x,y,z)")),
            };
        }
        let up = fields.get("space").and_then(|field| {
            let name = field.value.to_ascii_lowercase();
            let superior = name.contains("superior") || ["ras", "las", "lps"].contains(&name.as_str());
            superior.then_some(Up::Z)
        });
        let placed_by = fields.any(&["space directions", "spacings", "axis mins"]);
        Ok(Self { in_space, in_time: in_time.first().copied(), place, placed_by, up, warning })
    }
}

/// What a word among the kinds says of an axis.
fn role(field: &Field, axis: usize, kind: &str, size: u64) -> Result<Role, Wrong> {
    match kind.to_ascii_lowercase().as_str() {
        "domain" | "space" => Ok(Role::Space),
        "time" | "list" => Ok(Role::Time),
        "none" | "???" => Ok(Role::Unknown),
        // One number a voxel, whatever it is called.
        _ if size == 1 => Ok(Role::Nothing),
        lower => {
            let known =
                ["vector", "color", "matrix", "normal", "gradient", "point", "complex", "quaternion", "scalar", "stub"];
            let what = format!("{} of dimension {}", quoted(kind), axis + 1);
            if known.iter().any(|part| lower.contains(part)) {
                let problem = format!("{what} is not supported: a voxel must be one number");
                Err(field.wrong(problem, "write each component into a file of its own"))
            } else {
                Err(field.wrong(format!("{what} is not known"), "for time it is 'time', for space 'domain'"))
            }
        }
    }
}

/// A vector of space for each axis that has one. What goes only along a fourth dimension is time.
fn directions(field: &Field, roles: &mut [Role]) -> Result<Vec<Option<DVec3>>, Wrong> {
    let vectors = vectors(field)?;
    field.so_many(&vectors, roles.len())?;
    let mut directions = Vec::new();
    for (vector, role) in vectors.into_iter().zip(roles) {
        // What is not there may be written as no numbers too.
        let vector = vector.filter(|vector| !vector.truncate().is_nan_mask().all());
        let (along, later) = vector.map_or((None, 0.0), |vector| (Some(vector.truncate()), vector.w));
        if later != 0.0 && along == Some(DVec3::ZERO) {
            *role = Role::Time;
            directions.push(None);
        } else if later != 0.0 {
            return Err(field.wrong("has a direction of space and time", "give each axis its own"));
        } else {
            directions.push(along);
        }
    }
    Ok(directions)
}

/// Vectors of three or four numbers in parentheses, or `none`.
fn vectors(field: &Field) -> Result<Vec<Option<DVec4>>, Wrong> {
    let mut vectors = Vec::new();
    let mut rest = field.value.trim_start();
    while !rest.is_empty() {
        let after = if let Some(inside) = rest.strip_prefix('(') {
            let Some((inside, after)) = inside.split_once(')') else {
                return Err(field.wrong("has a parenthesis that is not closed", "write vectors as (x,y,z)"));
            };
            let numbers = inside.split(',').map(|word| field.number(word.trim())).collect::<Result<Vec<_>, _>>()?;
            vectors.push(Some(match numbers[..] {
                [x, y, z] => DVec4::new(x, y, z, 0.0),
                [x, y, z, w] => DVec4::new(x, y, z, w),
                _ => {
                    let problem = format!("has a vector of {}", counted(numbers.len() as u64, "number"));
                    return Err(field.wrong(problem, "give three: other spaces cannot be loaded"));
                }
            }));
            after
        } else if let Some(after) = rest.strip_prefix("none") {
            vectors.push(None);
            after
        } else {
            return Err(field.wrong(format!("has {} for a vector", quoted(rest)), "write vectors as (x,y,z)"));
        };
        rest = after.trim_start();
    }
    Ok(vectors)
}
