//! Files of nothing but numbers, of which somebody else says what each particle has.

use std::path::Path;

use super::columns::{Columns, Storage};
use super::frames::{Frame, Frames};
use crate::load::binary::{decode, fill};
use crate::load::input::{self, Input};
use crate::load::loaded::Loaded;
use crate::load::text::counted;
use crate::load::{LoadError, Options, RawParticles, VoxelType};

/// Loads a file of numbers.
pub(in crate::load) fn load(
    file: &Path,
    mut input: Input,
    raw: &RawParticles,
    options: &Options,
) -> Result<Loaded, LoadError> {
    let wanted: Vec<(usize, &String)> =
        raw.columns.iter().enumerate().filter_map(|(at, name)| Some((at, name.as_ref()?))).collect();
    let storage = match raw.kind {
        VoxelType::U8 => Storage::U8,
        VoxelType::F64 | VoxelType::I32 | VoxelType::U32 => Storage::F64,
        _ => Storage::F32,
    };
    let columns = Columns::new(wanted.iter().map(|(_, name)| ((*name).clone(), storage)).collect());
    let mut columns = columns.map_err(|fault| LoadError::new(file, fault.problem, fault.remedy))?;

    let width = raw.kind.bytes();
    let mut row = vec![0; raw.columns.len() * width];
    let described = || {
        let each = counted(row_bytes(raw), "byte");
        format!("each particle takes {each}: {} of type {}", counted(raw.columns.len() as u64, "number"), raw.kind)
    };
    if let Some(length) = input.length {
        if length % row_bytes(raw) != 0 {
            let problem = format!("{} are no whole number of particles; {}", counted(length, "byte"), described());
            return Err(LoadError::new(file, problem, "check --raw-layout and --raw-type"));
        }
        columns.reserve((length / row_bytes(raw)) as usize);
    }
    loop {
        match fill(&mut *input.reader, &mut row) {
            Ok(0) => break,
            Ok(count) if count < row.len() => {
                let problem = format!("the last particle is cut; {}", described());
                return Err(LoadError::new(file, problem, "check --raw-layout and --raw-type"));
            }
            Ok(_) => {}
            Err(error) => {
                let (problem, remedy) = input::explain(&error, input.gzip);
                return Err(LoadError::new(file, problem, remedy));
            }
        }
        columns.make_room().map_err(|fault| LoadError::new(file, fault.problem, fault.remedy))?;
        for (column, (at, _)) in wanted.iter().enumerate() {
            columns.push(column, decode(raw.kind, raw.big_endian, &row[at * width..]));
        }
    }
    let mut frames = Frames::new(file, options);
    let added = frames.add(Frame { columns, cell: None, radii: Vec::new() });
    added.map_err(|fault| LoadError::new(file, fault.problem, fault.remedy))?;
    frames.finish(if input.gzip { "raw particles, gzip" } else { "raw particles" }, input.warning(file))
}

/// Bytes of a particle.
fn row_bytes(raw: &RawParticles) -> u64 {
    (raw.columns.len() * raw.kind.bytes()).max(1) as u64
}
