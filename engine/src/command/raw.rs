//! What people tell of files of nothing but numbers: voxels, or particles.

use clap::Args;
use mobula::load::{Raw, RawParticles, VoxelType};

use super::values::{Lengths, lengths};

/// What a file of nothing but voxels does not say.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct RawOptions {
    /// Samples along each side of a file of nothing but voxels, the fastest first; a fourth number: steps of time
    #[arg(long, value_name = "X,Y,Z[,T]", requires = "raw_type", group = "raw_shape", value_parser = dims)]
    pub(crate) raw_dims: Option<Dims>,

    /// What each particle has in a file of nothing but numbers, in this order: x, y, z, radius, any other name, or _ for a number
    /// that is left out
    #[arg(long, value_name = "NAME[,NAME...]", group = "raw_shape", value_parser = layout)]
    pub(crate) raw_layout: Option<Layout>,

    /// Type of these voxels, or of the numbers of particles [default for particles: f32]: u8, i8, u16, i16, u32, i32, f32 or f64; with
    /// `be` behind it the most significant byte is first
    #[arg(long, value_name = "TYPE[be|le]", requires = "raw_shape", value_parser = voxel_type)]
    pub(crate) raw_type: Option<RawType>,

    /// Distances between these voxels [default: 1,1,1]
    #[arg(long, value_name = "X,Y,Z", requires = "raw_dims", value_parser = lengths)]
    pub(crate) raw_spacing: Option<Lengths>,
}

/// Samples along each side, and steps of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Dims([u64; 3], u64);

/// The names of the numbers of each particle; `None`: one that is left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Layout(Vec<Option<String>>);

/// The type of voxels, and whether their most significant byte is first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct RawType(VoxelType, bool);

impl RawOptions {
    /// What they say of files.
    pub(crate) fn raw(&self) -> Option<Raw> {
        let (Dims(dims, steps), RawType(kind, big_endian)) = (self.raw_dims?, self.raw_type?);
        Some(Raw { dims, steps, kind, big_endian, spacing: self.raw_spacing.map_or([1.0; 3], |spacing| spacing.0) })
    }

    /// What they say of files of particles.
    pub(crate) fn particles(&self) -> Option<RawParticles> {
        let Layout(columns) = self.raw_layout.clone()?;
        let RawType(kind, big_endian) = self.raw_type.unwrap_or(RawType(VoxelType::F32, false));
        Some(RawParticles { columns, kind, big_endian })
    }

    /// The options as names and values.
    #[cfg(feature = "window")]
    pub(crate) fn words(&self) -> [(&'static str, Option<String>); 4] {
        let dims = self.raw_dims.map(|Dims([x, y, z], steps)| format!("{x},{y},{z},{steps}"));
        let kind = self.raw_type.map(|RawType(kind, big)| format!("{kind}{}", if big { "be" } else { "le" }));
        let spacing = self.raw_spacing.map(|Lengths([x, y, z])| format!("{x},{y},{z}"));
        let layout = self.raw_layout.as_ref().map(|Layout(columns)| {
            let names: Vec<&str> = columns.iter().map(|name| name.as_deref().unwrap_or("_")).collect();
            names.join(",")
        });
        [("raw-dims", dims), ("raw-layout", layout), ("raw-type", kind), ("raw-spacing", spacing)]
    }
}

fn dims(text: &str) -> Result<Dims, String> {
    let numbers: Option<Vec<u64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[x, y, z]) if x > 0 && y > 0 && z > 0 => Ok(Dims([x, y, z], 1)),
        Some(&[x, y, z, steps]) if x > 0 && y > 0 && z > 0 && steps > 0 => Ok(Dims([x, y, z], steps)),
        _ => Err("write three whole numbers above 0 with commas between them, such as 256,256,100".into()),
    }
}

fn voxel_type(text: &str) -> Result<RawType, String> {
    let lower = text.to_ascii_lowercase();
    let little = || lower.strip_suffix("le").unwrap_or(&lower);
    let (name, big) = lower.strip_suffix("be").map_or_else(|| (little(), false), |name| (name, true));
    let kind = name.parse().map_err(|error: mobula::load::NoVoxelType| error.to_string());
    kind.map(|kind| RawType(kind, big))
}

fn layout(text: &str) -> Result<Layout, String> {
    let remedy = "write names with commas between them, such as x,y,z,radius,speed, with _ for what is to be left out";
    let columns = RawParticles::columns(text.split(',').map(str::trim));
    columns.map(Layout).map_err(|error| format!("{error}; {remedy}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_options_are_checked() {
        assert_eq!(dims("2, 3,4"), Ok(Dims([2, 3, 4], 1)));
        assert_eq!(dims("2,3,4,5"), Ok(Dims([2, 3, 4], 5)));
        for bad in ["", "1,2", "0,1,1", "1,2,3,0", "1,2,3,4,5", "1,2,x", "-1,2,3", "99999999999999999999,1,1"] {
            assert!(dims(bad).is_err(), "{bad}");
        }
        assert_eq!(voxel_type("u16"), Ok(RawType(VoxelType::U16, false)));
        assert_eq!(voxel_type("F32le"), Ok(RawType(VoxelType::F32, false)));
        assert_eq!(voxel_type("i32be"), Ok(RawType(VoxelType::I32, true)));
        for bad in ["", "be", "u64", "u16bele", "short"] {
            assert!(voxel_type(bad).unwrap_err().contains("u8, i8, u16"), "{bad}");
        }
        let Layout(names) = layout("x, y,z,_,speed").unwrap();
        assert_eq!(
            names.iter().map(|name| name.as_deref()).collect::<Vec<_>>(),
            [Some("x"), Some("y"), Some("z"), None, Some("speed")]
        );
        for bad in ["", "x,y", "x,y,z,", "x,y,_", "x y z"] {
            assert!(layout(bad).unwrap_err().contains("such as x,y,z,radius"), "{bad}");
        }
    }
}
