//! What a header says of its voxels, whatever its format; and the scene that they make.

use std::path::Path;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::VoxelType;
use super::layout::Layout;
use crate::geometry::{Census, Item};
use crate::load::lines::Fault;
use crate::load::loaded::{Loaded, Report, display_name};
use crate::load::{LoadError, Options, Place};
use crate::scene::SceneDescription;
use crate::view::Up;
use crate::volume::{Grid, GridPlace, Volume, Voxels};

/// Samples of all steps.
const VOXELS: Item = Item::primitives("voxels", "voxel", "voxels");
/// Samples along one index may be so many times closer than along another.
const OUT_OF_PROPORTION: f64 = 1e7;

/// What a header says of its voxels.
#[derive(Clone, Debug)]
pub(super) struct Header {
    pub(super) layout: Layout,
    pub(super) kind: VoxelType,
    /// Do voxels start with their most significant byte?
    pub(super) big_endian: bool,
    pub(super) place: GridPlace,
    /// A sample stands for the first times its voxel, plus the second.
    pub(super) scale: [f64; 2],
    /// Which way is up, where the format says so.
    pub(super) up: Option<Up>,
}

/// Checks where samples are: at points, and not all of them in a plane.
pub(super) fn check_place(place: &GridPlace) -> Result<(), Fault> {
    let fault = |problem: &str| Err(Fault::new(problem, "check how it was written"));
    if !place.origin.is_finite() {
        return fault("the origin of the grid is not finite");
    }
    if place.axes.iter().any(|axis| !axis.is_finite()) {
        return fault("the spacing or a direction of the grid is not finite");
    }
    // By size first: what is tiny or huge is scaled later.
    let sizes = place.axes.map(|axis| axis.abs().max_element());
    let [low, high] = [sizes.into_iter().fold(f64::INFINITY, f64::min), sizes.into_iter().fold(0.0, f64::max)];
    if low == 0.0 {
        return fault("the spacing of the grid is zero");
    }
    if high / low > OUT_OF_PROPORTION {
        return fault("the spacings of the grid are out of all proportion");
    }
    let [a, b, c] = [0, 1, 2].map(|k| (place.axes[k] / sizes[k]).normalize_or_zero());
    if a.cross(b).dot(c).abs() < 1e-6 {
        return fault("the directions of the grid are all in a plane");
    }
    Ok(())
}

/// The scene of one volume, whose steps these are.
pub(super) fn scene(
    file: &Path,
    format: &'static str,
    header: &Header,
    steps: Vec<Voxels>,
    options: &Options,
    mut warnings: Vec<String>,
) -> Result<Loaded, LoadError> {
    let Header { layout, scale, mut place, up, .. } = *header;
    let positions = place.corners(layout.dims).map(|corner| corner.to_array());
    let put = options.place.unwrap_or_else(|| Place::of(&positions, &[0, 1, 2, 3, 4, 5, 6, 7]));
    if options.place.is_none() {
        warnings.extend(put.warning().map(|text| format!("{}: {text}", file.display())));
    }
    place.origin = (place.origin - DVec3::from(put.offset)) * put.scale;
    place.axes = place.axes.map(|axis| axis * put.scale);

    let mut census = Census::default();
    census.set(VOXELS, layout.voxels() as u64);
    place.corners(layout.dims).iter().for_each(|corner| census.include(corner.as_vec3(), 0.0));
    let size = census.bounds.1 - census.bounds.0;
    if !(size.is_finite() && census.bounds.0.is_finite() && census.bounds.1.is_finite() && size != Vec3::ZERO
        || layout.dims == [1; 3] && census.bounds.0.is_finite())
    {
        let problem = "the grid is too large, too small or too far away for the numbers that rays are traced with";
        return Err(LoadError::new(file, problem, "show it without other files, or change its spacing"));
    }
    let grid = |voxels| {
        let grid = Grid::new(layout.dims, voxels, place, scale);
        grid.map(Arc::new).map_err(|error| LoadError::new(file, error.to_string(), "check how it was written"))
    };
    let steps = steps.into_iter().map(grid).collect::<Result<_, _>>()?;
    let volume = Volume { name: display_name(file), steps };
    let scene =
        SceneDescription { name: volume.name.clone(), volumes: vec![volume], up, ..SceneDescription::default() };
    Ok(Loaded { scene, report: Report { format, census, warnings }, place: put })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_checked() {
        let check = |x: [f64; 3], y: [f64; 3], z: [f64; 3]| {
            let place = GridPlace { origin: DVec3::ONE, axes: [x, y, z].map(DVec3::from) };
            check_place(&place).map_err(|fault| fault.problem)
        };
        for size in [1e-200, 1.0, 1e200] {
            assert_eq!(check([size, 0.0, 0.0], [0.0, -2.0 * size, 0.0], [0.0, 0.0, 1e3 * size]), Ok(()));
            let flat = check([size, 0.0, 0.0], [size, size, 0.0], [3.0 * size, size, 0.0]);
            assert!(flat.unwrap_err().contains("in a plane"));
        }
        let [x, y] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for (z, expected) in
            [([0.0; 3], "zero"), ([0.0, 0.0, f64::NAN], "not finite"), ([0.0, 0.0, 1e-9], "proportion")]
        {
            assert!(check(x, y, z).unwrap_err().contains(expected), "{expected}");
        }
        let place = GridPlace { origin: DVec3::NAN, ..GridPlace::with_spacing([1.0; 3]) };
        assert!(check_place(&place).unwrap_err().problem.contains("origin"));
    }
}
