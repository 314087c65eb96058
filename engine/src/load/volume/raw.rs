//! Files of nothing but voxels, of which somebody else says how many there are and of which type.

use std::path::Path;

use super::filling::filling;
use super::header::{self, Header, check_place};
use super::layout::Layout;
use super::read;
use super::source::Source;
use crate::load::input::Input;
use crate::load::loaded::Loaded;
use crate::load::{LoadError, Options, Raw};
use crate::volume::GridPlace;

/// Loads a file of voxels.
pub(crate) fn load(file: &Path, mut input: Input, raw: &Raw, options: &Options) -> Result<Loaded, LoadError> {
    let place = GridPlace::with_spacing(raw.spacing);
    let layout = Layout::new(raw.dims, raw.steps, 3);
    let layout = layout.and_then(|layout| check_place(&place).map(|()| layout));
    let layout = layout.map_err(|fault| LoadError::new(file, fault.problem, fault.remedy))?;
    let Raw { kind, big_endian, .. } = *raw;
    let header = Header { layout, kind, big_endian, place, scale: [1.0, 0.0], up: None };

    let mut filling = filling(kind, &layout);
    let mut source = Source::of(file, &mut input);
    input.allow(layout.bytes(kind));
    read::binary(&mut source, &header, &mut *filling, layout.bytes(kind))?;
    let warnings = source.rest()?.into_iter().chain(input.warning(file)).collect();
    let format = if input.gzip { "raw voxels, gzip" } else { "raw voxels" };
    header::scene(file, format, &header, filling.finish(), options, warnings)
}
