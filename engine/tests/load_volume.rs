//! Volumes from files, good and broken: what is loaded, and what is said about the rest.

#[path = "support/files.rs"]
mod files;
#[path = "load_volume/hostile.rs"]
mod hostile;
#[path = "load_volume/meta_image.rs"]
mod meta_image;
#[path = "load_volume/nifti.rs"]
mod nifti;
#[path = "load_volume/nrrd.rs"]
mod nrrd;
#[path = "load_volume/raw.rs"]
mod raw;
#[path = "load_volume/real.rs"]
mod real;

use std::io::Write as _;
use std::sync::Arc;

use mobula::load::Loaded;
use mobula::volume::{Grid, Volume};

use files::{Folder, gzip};

impl Folder {
    /// The volume of a sound file, about which nothing is said.
    fn volume(&self, name: &str, bytes: impl AsRef<[u8]>) -> Volume {
        let loaded = self.load(name, bytes).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(loaded.report.warnings, [""; 0]);
        only_volume(&loaded).clone()
    }

    /// The grid of a sound file with one step.
    fn grid(&self, name: &str, bytes: impl AsRef<[u8]>) -> Arc<Grid> {
        let [grid] = &self.volume(name, bytes).steps[..] else { panic!("several steps") };
        Arc::clone(grid)
    }
}

fn only_volume(loaded: &Loaded) -> &Volume {
    assert!(loaded.scene.geometry.is_empty());
    let [volume] = &loaded.scene.volumes[..] else { panic!("{:?}", loaded.scene.volumes) };
    let voxels: usize = volume.steps.iter().map(|step| step.voxels().len()).sum();
    assert_eq!(loaded.report.census.count("voxels"), voxels as u64);
    volume
}

fn zlib(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
}

/// The voxels of a grid.
fn values(grid: &Grid) -> Vec<f64> {
    (0..grid.voxels().len()).map(|i| grid.voxels().get(i)).collect()
}

/// Twenty-four voxels of a type, with the least and the greatest among them, and their bytes in either order.
struct Sample {
    /// In Rust.
    name: &'static str,
    values: Vec<f64>,
    little: Vec<u8>,
    big: Vec<u8>,
}

macro_rules! sample {
    ($type:ident, $low:expr, $high:expr) => {{
        let values: Vec<$type> =
            [$low, $high].into_iter().chain((0..22_u8).map(|i| (i as $type) * (3 as $type))).collect();
        Sample {
            name: stringify!($type),
            little: values.iter().flat_map(|x| x.to_le_bytes()).collect(),
            big: values.iter().flat_map(|x| x.to_be_bytes()).collect(),
            values: values.into_iter().map(|x| x as f64).collect(),
        }
    }};
}

/// One of each type.
fn samples() -> [Sample; 8] {
    [
        sample!(u8, u8::MIN, u8::MAX),
        sample!(i8, i8::MIN, i8::MAX),
        sample!(u16, u16::MIN, u16::MAX),
        sample!(i16, i16::MIN, i16::MAX),
        sample!(u32, u32::MIN, u32::MAX),
        sample!(i32, i32::MIN, i32::MAX),
        sample!(f32, -1.5e-30, f32::INFINITY),
        sample!(f64, -1.5e-300, 1e300),
    ]
}
