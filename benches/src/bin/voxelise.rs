//! Makes a volume of a mesh: `cargo run --release -p mobula-benches --bin voxelise -- motorbike.obj.gz motorbike.nrrd`.
//! An NRRD file of 16 bits a voxel, in the coordinates of the mesh; memory is that of the mesh and of a slice.

use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::Parser;
use mobula::{load, output};
use mobula_benches::scenes::Primitives;
use mobula_benches::voxels::{self, INSIDE, OUTSIDE, Report, SURFACE, Settings};

/// Makes a volume of a mesh.
#[derive(Debug, Parser)]
struct Options {
    /// The mesh: closed, but for some holes.
    mesh: PathBuf,
    /// The NRRD file to write.
    volume: PathBuf,
    /// Voxels along the longest side.
    #[arg(long, default_value_t = 512, value_parser = clap::value_parser!(u32).range(8..=4096))]
    size: u32,
    /// Rows and slices that each voxel is cut at.
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=16))]
    cuts: u32,
    /// Smooth noise that is added, at most; the surface is 20000 from both sides.
    #[arg(long, default_value_t = 1000.0)]
    noise: f64,
    /// What the noise is made from.
    #[arg(long, default_value_t = 1)]
    seed: u32,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("voxelise: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), String> {
    let loaded = load::load(&options.mesh).map_err(|error| error.to_string())?;
    if loaded.place != load::Place::default() {
        return Err("the mesh is too far from the origin, or too large or small".to_owned());
    }
    let Primitives::Triangles(mesh) = Primitives::of(&loaded.scene) else {
        return Err("there are no triangles".to_owned());
    };
    let Options { size, cuts, noise, seed, .. } = *options;
    let settings = Settings { size: size as usize, cuts: cuts as usize, noise, seed };
    let place = voxels::place(&mesh, settings.size).ok_or("the mesh has no extent")?;
    let mut report = Report::default();
    let written = output::write(&options.volume, |file| {
        let mut file = BufWriter::new(file);
        header(&mut file, &options.mesh, &place)?;
        let mut bytes = Vec::new();
        report = voxels::voxelise(&mesh, &place, &settings, |slice| {
            bytes.clear();
            bytes.extend(slice.iter().flat_map(|voxel| voxel.to_le_bytes()));
            file.write_all(&bytes)
        })?;
        file.flush()
    });
    written.map_err(|error| format!("{}: {error}", options.volume.display()))?;
    let [x, y, z] = place.dims;
    let Report { rows, odd, inside } = report;
    let part = 100.0 * inside / (x * y * z) as f64;
    println!("{x} x {y} x {z} voxels, {part:.2} % inside; {odd} of {rows} rows are at holes; surface at {SURFACE}");
    Ok(())
}

fn header(file: &mut impl Write, mesh: &Path, place: &voxels::Place) -> io::Result<()> {
    let name = mesh.file_name().unwrap_or_default().to_string_lossy();
    let ([x, y, z], [ox, oy, oz], s) = (place.dims, place.origin, place.spacing);
    write!(
        file,
        "NRRD0004\n# voxels of {name}: {OUTSIDE} outside, {INSIDE} inside\ntype: uint16\ndimension: 3\nspace dimension: 3\n\
         sizes: {x} {y} {z}\nspace directions: ({s},0,0) (0,{s},0) (0,0,{s})\nspace origin: ({ox},{oy},{oz})\n\
         endian: little\nencoding: raw\n\n"
    )
}
