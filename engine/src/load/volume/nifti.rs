//! NIfTI-1 and NIfTI-2 files, after <https://nifti.nimh.nih.gov>: header and voxels in one file (`.nii`). The fourth dimension is time;
//! x points to the right, y to the front, z up.

use std::io::Read;
use std::path::Path;

use glam::{DMat3, DQuat, DVec3};

use super::filling::filling;
use super::header::{self, Header, check_place};
use super::layout::Layout;
use super::nifti_header::{Magic, Name, RawHeader};
use super::source::Source;
use super::{VoxelType, read};
use crate::load::input::Input;
use crate::load::lines::Fault;
use crate::load::loaded::Loaded;
use crate::load::{LoadError, Options};
use crate::view::Up;
use crate::volume::GridPlace;

/// Does the start of a file look like NIfTI?
pub(crate) fn looks_like(start: &[u8]) -> bool {
    let header = RawHeader::size(start).and_then(|(size, _)| start.get(..size));
    match header {
        Some(header) => matches!(RawHeader::of(header.to_vec()), Some((_, Magic::Single | Magic::Pair))),
        // More than the start is needed for the larger header, but not for its magic.
        None => RawHeader::size(start).is_some() && start.get(4..7) == Some(b"n+2"),
    }
}

/// Loads a NIfTI file.
pub(crate) fn load(file: &Path, mut input: Input, options: &Options) -> Result<Loaded, LoadError> {
    let mut source = Source::of(file, &mut input);
    let raw = read_header(&mut source)?;
    let (header, offset) = understand(&raw).map_err(|fault| LoadError::new(file, fault.problem, fault.remedy))?;

    let bytes = header.layout.bytes(header.kind);
    input.allow(bytes.saturating_add(offset));
    source.skip_bytes(offset - raw.len() as u64)?;
    let mut filling = filling(header.kind, &header.layout);
    read::binary(&mut source, &header, &mut *filling, bytes)?;
    let warnings = source.rest()?.into_iter().chain(input.warning(file)).collect();
    let format = match (raw.len(), input.gzip) {
        (348, false) => "NIfTI-1",
        (348, true) => "NIfTI-1, gzip",
        (_, false) => "NIfTI-2",
        (_, true) => "NIfTI-2, gzip",
    };
    header::scene(file, format, &header, filling.finish(), options, warnings)
}

fn read_header(source: &mut Source) -> Result<RawHeader, LoadError> {
    let file = source.file().to_owned();
    let size = RawHeader::size(source.peek()?);
    let mut bytes = Vec::new();
    let wanted = size.map_or(0, |(size, _)| size);
    let read = (&mut *source).take(wanted as u64).read_to_end(&mut bytes);
    read.map_err(|error| source.error(&error))?;
    if size.is_some() && bytes.len() < wanted {
        let problem = format!("its header has {} bytes instead of {wanted}", bytes.len());
        return Err(LoadError::new(&file, problem, "the file is truncated: fetch it again"));
    }
    match RawHeader::of(bytes) {
        Some((header, Magic::Single)) => Ok(header),
        Some((_, Magic::Pair)) => {
            let problem = "its voxels are in a file of their own (.hdr and .img), which is not supported";
            Err(LoadError::new(&file, problem, "write both as one .nii file"))
        }
        Some((_, Magic::Analyze)) => {
            let problem = "an Analyze file, or a NIfTI file without the mark n+1";
            Err(LoadError::new(&file, problem, "write it as a .nii file"))
        }
        None => {
            let problem = "not a NIfTI file: it does not start with the size of its header, 348 or 540";
            Err(LoadError::new(&file, problem, "check that it is what its name says"))
        }
    }
}

/// What a header says, and where voxels start.
fn understand(raw: &RawHeader) -> Result<(Header, u64), Fault> {
    const REMEDY: &str = "check how it was written";
    let count = raw.get(Name::Dim, 0);
    if !(1.0..=7.0).contains(&count) {
        return Err(Fault::new(format!("it has {count} dimensions, not 1 to 7"), REMEDY));
    }
    if count < 3.0 {
        let problem = format!("it has {count} dimensions: a volume has three");
        return Err(Fault::new(problem, "pictures and lines cannot be loaded"));
    }
    let size = |i: usize| if i as f64 > count { 1.0 } else { raw.get(Name::Dim, i) };
    let sizes: [f64; 7] = std::array::from_fn(|i| size(i + 1));
    if let Some(negative) = sizes.iter().find(|&&size| size < 0.0) {
        return Err(Fault::new(format!("a dimension has {negative} samples"), REMEDY));
    }
    let [x, y, z, time, rest @ ..] = sizes.map(|size| size as u64);
    if rest.iter().any(|&size| size > 1) {
        let problem = "more than four dimensions are not supported: a voxel must be one number";
        return Err(Fault::new(problem, "write each component into a file of its own"));
    }
    let layout = Layout::new([x, y, z], time, 3)?;
    let place = place(raw)?;
    check_place(&place)?;
    let [slope, intercept] = [Name::Slope, Name::Intercept].map(|name| raw.get(name, 0));
    if !(slope.is_finite() && intercept.is_finite()) {
        let problem = format!("its voxels are to be scaled by {slope} and {intercept}, which are not finite");
        return Err(Fault::new(problem, REMEDY));
    }
    let scale = if slope == 0.0 { [1.0, 0.0] } else { [slope, intercept] };
    let offset = raw.get(Name::VoxOffset, 0);
    // Four bytes behind the header say whether something else follows.
    let least = raw.len() as f64;
    let offset = if offset == 0.0 { least + 4.0 } else { offset };
    if !(least..1e15).contains(&offset) || offset.fract() != 0.0 {
        return Err(Fault::new(format!("its voxels start at byte {offset}, which is not behind the header"), REMEDY));
    }
    let kind = voxel_type(raw.get(Name::DataType, 0))?;
    let header = Header { layout, kind, big_endian: raw.big_endian, place, scale, up: Some(Up::Z) };
    Ok((header, offset as u64))
}

/// Where samples are: what the first says that is there of a matrix, a rotation, and the spacing.
fn place(raw: &RawHeader) -> Result<GridPlace, Fault> {
    if raw.get(Name::SformCode, 0) > 0.0 {
        let [x, y, z] = [Name::SformX, Name::SformY, Name::SformZ].map(|row| raw.several::<4>(row, 0));
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        return Ok(GridPlace { origin: column(3), axes: [column(0), column(1), column(2)] });
    }
    let spacing: [f64; 3] = raw.several(Name::PixDim, 1);
    if spacing.iter().any(|&x| !(x.is_finite() && x != 0.0)) {
        let [x, y, z] = spacing;
        let problem = format!("the spacing {x} x {y} x {z} is not above 0");
        return Err(Fault::new(problem, "check how it was written"));
    }
    let spacing = spacing.map(f64::abs);
    if raw.get(Name::QformCode, 0) <= 0.0 {
        return Ok(GridPlace::with_spacing(spacing));
    }
    let [b, c, d] = raw.several(Name::Quaternion, 0);
    let rest = 1.0 - (b * b + c * c + d * d);
    // Rounded numbers may be a bit too long.
    let rotation = DQuat::from_xyzw(b, c, d, rest.max(0.0).sqrt()).normalize();
    if !(rotation.is_finite() && rest > -1e-2) {
        return Err(Fault::new("its rotation is no unit quaternion", "check how it was written"));
    }
    let turned = if raw.get(Name::PixDim, 0) < 0.0 { -1.0 } else { 1.0 };
    let rotation = DMat3::from_quat(rotation);
    let axes = [rotation.x_axis * spacing[0], rotation.y_axis * spacing[1], rotation.z_axis * spacing[2] * turned];
    Ok(GridPlace { origin: DVec3::from(raw.several::<3>(Name::QformOffset, 0)), axes })
}

/// The type of a number.
fn voxel_type(number: f64) -> Result<VoxelType, Fault> {
    let other = match number as i64 {
        2 => return Ok(VoxelType::U8),
        4 => return Ok(VoxelType::I16),
        8 => return Ok(VoxelType::I32),
        16 => return Ok(VoxelType::F32),
        64 => return Ok(VoxelType::F64),
        256 => return Ok(VoxelType::I8),
        512 => return Ok(VoxelType::U16),
        768 => return Ok(VoxelType::U32),
        1 => "single bits",
        32 | 1792 | 2048 => "complex numbers",
        128 | 2304 => "colours",
        1024 | 1280 => "integers of 64 bits",
        1536 => "floats of 128 bits",
        _ => return Err(Fault::new(format!("voxels of type {number} are not known"), "check how it was written")),
    };
    Err(Fault::new(
        format!("voxels that are {other} are not supported"),
        "write it with voxels of 16 bits, or as float",
    ))
}
