//! What columns mean, by their names: positions, radii, velocities.

/// Names of the three coordinates, as programs write them.
const AXES: [[&str; 3]; 11] = [
    ["x", "y", "z"],
    ["xu", "yu", "zu"],
    ["xs", "ys", "zs"],
    ["xsu", "ysu", "zsu"],
    ["px", "py", "pz"],
    ["pos_x", "pos_y", "pos_z"],
    ["position_x", "position_y", "position_z"],
    ["posx", "posy", "posz"],
    ["points:0", "points:1", "points:2"],
    ["points_0", "points_1", "points_2"],
    ["position:0", "position:1", "position:2"],
];
/// Names of radii; of twice the radius.
const RADII: [&str; 3] = ["radius", "r", "pscale"];
const DIAMETERS: [&str; 2] = ["diameter", "diam"];
/// Names of velocities.
const VELOCITIES: [[&str; 3]; 6] = [
    ["vx", "vy", "vz"],
    ["v_x", "v_y", "v_z"],
    ["velocity_x", "velocity_y", "velocity_z"],
    ["velocity:0", "velocity:1", "velocity:2"],
    ["velocity_0", "velocity_1", "velocity_2"],
    ["vel_x", "vel_y", "vel_z"],
];
/// Names of columns whose whole numbers are kinds.
const KINDS: [&str; 9] = ["type", "kind", "element", "species", "class", "label", "phase", "material", "atomic_number"];

/// A name without its case, and without a unit in brackets behind it.
fn bare(name: &str) -> String {
    let bare = name.split(['(', '[']).next().unwrap_or_default().trim();
    (if bare.is_empty() { name.trim() } else { bare }).to_ascii_lowercase()
}

/// Where the three columns of a triple are.
fn triple(names: &[String], known: &[[&str; 3]]) -> Option<[usize; 3]> {
    let at = |wanted: &str| names.iter().position(|name| *name == wanted);
    known.iter().find_map(|[x, y, z]| Some([at(x)?, at(y)?, at(z)?]))
}

/// The columns of the coordinates.
pub(in crate::load) fn axes<N: AsRef<str>>(names: &[N]) -> Option<[usize; 3]> {
    triple(&all_bare(names), &AXES)
}

/// The columns of the velocities.
pub(super) fn velocities<N: AsRef<str>>(names: &[N]) -> Option<[usize; 3]> {
    triple(&all_bare(names), &VELOCITIES)
}

fn all_bare<N: AsRef<str>>(names: &[N]) -> Vec<String> {
    names.iter().map(|name| bare(name.as_ref())).collect()
}

/// The column of the radii, and what its numbers are to be multiplied by.
pub(super) fn radius<N: AsRef<str>>(names: &[N]) -> Option<(usize, f64)> {
    let names = all_bare(names);
    let at = |wanted: &str| names.iter().position(|name| *name == wanted);
    // Beside g and b it is red.
    let color = at("g").is_some() && at("b").is_some();
    let radius = RADII.iter().filter(|name| **name != "r" || !color).find_map(|name| at(name));
    radius.map(|at| (at, 1.0)).or_else(|| DIAMETERS.iter().find_map(|name| at(name)).map(|at| (at, 0.5)))
}

/// Is it the name of a coordinate?
pub(super) fn is_axis(name: &str) -> bool {
    AXES.iter().flatten().any(|axis| *axis == bare(name))
}

/// May the numbers of a column be kinds?
pub(super) fn is_kind(name: &str) -> bool {
    KINDS.contains(&&*bare(name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_found_by_usual_names() {
        assert_eq!(axes(&["id", "X (mm)", "Y [m]", "z", "r"]), Some([1, 2, 3]));
        assert_eq!(axes(&["Points:2", "Points:1", "Points:0"]), Some([2, 1, 0]));
        assert_eq!(axes(&["x", "y", "(z)"]), None);
        assert_eq!([radius(&["x", "Radius"]), radius(&["Diameter"])], [Some((1, 1.0)), Some((0, 0.5))]);
        assert_eq!([radius(&["r", "g", "b"]), radius(&["r", "g"])], [None, Some((0, 1.0))]);
        assert_eq!(velocities(&["vz", "vx", "vy"]), Some([1, 2, 0]));
        assert!(is_kind("Type") && !is_kind("speed"));
    }
}
