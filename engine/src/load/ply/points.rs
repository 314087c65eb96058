//! Vertices of a PLY file that are particles: each property is a column.

use super::header::{Element, Header};
use super::rows::{Row, Rows};
use crate::load::loaded::Loaded;
use crate::load::particles::{Columns, Frame, Frames, Storage, axes, of_comment};
use crate::load::text::quoted;
use crate::load::{LoadError, Options, VoxelType};

/// Loads the vertices of a file without faces.
pub(super) fn load(mut rows: Rows<'_>, header: &Header, options: &Options) -> Result<Loaded, LoadError> {
    let Some(element) = points(header) else {
        let names: Vec<_> = header.elements.iter().map(|element| &*element.name).collect();
        let problem = format!("there is no element 'vertex', only {}", quoted(&names.join(" ")));
        return Err(LoadError::new(rows.file(), problem, "name the particles `vertex`").at(header.lines));
    };
    let mut frames = Frames::new(rows.file(), options);
    let scalars: Vec<usize> = (0..element.properties.len()).filter(|&i| element.properties[i].list.is_none()).collect();
    if scalars.len() < element.properties.len() {
        frames.warn(&format!(":{}: lists of vertices are left out", element.line));
    }
    let column = |&i: &usize| {
        let property = &element.properties[i];
        let storage = match property.kind {
            VoxelType::U8 | VoxelType::I8 => Storage::U8,
            VoxelType::U32 | VoxelType::I32 | VoxelType::F64 => Storage::F64,
            VoxelType::U16 | VoxelType::I16 | VoxelType::F32 => Storage::F32,
        };
        (property.name.clone(), storage)
    };
    let at_element =
        |fault: crate::load::lines::Fault| LoadError::new(rows.file(), fault.problem, fault.remedy).at(element.line);
    let mut columns = Columns::new(scalars.iter().map(column).collect()).map_err(at_element)?;
    if rows.is_sure() {
        columns.reserve(element.count as usize);
    }
    for before in header.elements.iter().take_while(|before| !std::ptr::eq(*before, element)) {
        rows.skip(before)?;
    }
    let mut row = Row::default();
    for number in 0..element.count {
        rows.next(element, number, None, &mut row)?;
        for (column, &at) in scalars.iter().enumerate() {
            columns.push(column, row.scalars[at]);
        }
    }
    let cell = header.comments.iter().find_map(|comment| of_comment(comment));
    let added = frames.add(Frame { columns, cell, radii: Vec::new() });
    added.map_err(|fault| rows.fault(fault, element, None))?;
    frames.finish("PLY", None)
}

/// The element whose rows are particles.
fn points(header: &Header) -> Option<&Element> {
    let named = |name: &str| header.elements.iter().find(|element| element.name == name);
    let has_axes = |element: &&Element| {
        let names: Vec<_> = element.properties.iter().map(|property| &property.name).collect();
        axes(&names).is_some()
    };
    named("vertex").or_else(|| header.elements.iter().find(has_axes))
}
