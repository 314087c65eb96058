//! Numbers in the buffers of a document (glTF 2.0, section 3.6): every access is within them.

use std::borrow::Cow;
use std::path::Path;

use gltf::accessor::{DataType, sparse::IndexType};
use gltf::{Accessor, Document, buffer};

use super::container::fetch;

/// The buffers of a document, as far as they are there.
pub(super) struct Buffers<'a> {
    list: Vec<Result<Cow<'a, [u8]>, String>>,
}

/// An accessor without bytes, which are zero then, has at most so many elements for each byte of the document.
const ZEROS: usize = 64;

impl<'a> Buffers<'a> {
    /// Reads them all; `binary` is the part of a GLB file behind the document.
    pub(super) fn read(file: &Path, document: &Document, binary: Option<&'a [u8]>) -> Self {
        let read = |buffer: buffer::Buffer<'_>| match buffer.source() {
            buffer::Source::Bin => binary.map(Cow::Borrowed).ok_or_else(|| "the binary part is not there".to_owned()),
            buffer::Source::Uri(uri) => fetch(file, uri).map(Cow::Owned),
        };
        Self { list: document.buffers().map(read).collect() }
    }

    /// The bytes of a view.
    pub(super) fn view(&self, view: &buffer::View<'_>) -> Result<&[u8], String> {
        let bytes = match &self.list[view.buffer().index()] {
            Ok(bytes) => bytes,
            Err(problem) => return Err(problem.clone()),
        };
        let end = view.offset().checked_add(view.length());
        let part = end.and_then(|end| bytes.get(view.offset()..end));
        part.ok_or_else(|| format!("buffer view {} reaches beyond its buffer", view.index()))
    }

    /// The first `N` components of each element. Whole numbers that are normalized become -1 to 1 or 0 to 1.
    pub(super) fn numbers<const N: usize>(&self, accessor: &Accessor<'_>) -> Result<Vec<[f32; N]>, String> {
        let components = accessor.dimensions().multiplicity();
        if components < N {
            return Err(format!("accessor {} has {components} components instead of {N}", accessor.index()));
        }
        let kind = accessor.data_type();
        let scale = if accessor.normalized() { greatest(kind) } else { 1.0 };
        let number = |bytes: &[u8]| (decode(kind, bytes) / scale).max(if scale > 1.0 { -1.0 } else { f64::MIN }) as f32;
        let size = kind.size();
        self.elements(accessor, [0.0; N], |bytes| std::array::from_fn(|i| number(&bytes[i * size..])))
    }

    /// Whole numbers, such as indices.
    pub(super) fn indices(&self, accessor: &Accessor<'_>) -> Result<Vec<u32>, String> {
        let kind = accessor.data_type();
        self.elements(accessor, 0, |bytes| decode(kind, bytes) as u32)
    }

    /// Every element, from its bytes.
    fn elements<T: Copy>(&self, accessor: &Accessor<'_>, zero: T, from: impl Fn(&[u8]) -> T) -> Result<Vec<T>, String> {
        let (count, size) = (accessor.count(), accessor.size());
        let mut all = match accessor.view() {
            Some(view) => {
                let stride = view.stride().unwrap_or(size);
                rows(self.view(&view)?, accessor.offset(), count, size, stride)
                    .ok_or_else(|| format!("accessor {} reaches beyond its buffer view", accessor.index()))?
                    .map(&from)
                    .collect()
            }
            None => {
                let known: usize = self.list.iter().flatten().map(|bytes| bytes.len()).sum();
                if count > known.saturating_add(1 << 10).saturating_mul(ZEROS) {
                    return Err(format!("accessor {} has {count} elements, and no bytes", accessor.index()));
                }
                vec![zero; count]
            }
        };
        if let Some(sparse) = accessor.sparse() {
            let (indices, values) = (sparse.indices(), sparse.values());
            let (kind, width) = match indices.index_type() {
                IndexType::U8 => (DataType::U8, 1),
                IndexType::U16 => (DataType::U16, 2),
                IndexType::U32 => (DataType::U32, 4),
            };
            let (index_view, value_view) = (indices.view(), values.view());
            let places = rows(self.view(&index_view)?, indices.offset(), sparse.count(), width, width);
            let values = rows(self.view(&value_view)?, values.offset(), sparse.count(), size, size);
            let (Some(places), Some(values)) = (places, values) else {
                return Err(format!("sparse accessor {} reaches beyond its buffer view", accessor.index()));
            };
            for (place, value) in places.zip(values) {
                let place = all.get_mut(decode(kind, place) as usize);
                *place.ok_or_else(|| format!("accessor {} has a sparse index out of range", accessor.index()))? =
                    from(value);
            }
        }
        Ok(all)
    }
}

/// So many pieces of bytes, `stride` apart, if they are all there.
fn rows(
    bytes: &[u8],
    offset: usize,
    count: usize,
    size: usize,
    stride: usize,
) -> Option<impl Iterator<Item = &[u8]> + use<'_>> {
    let stride = stride.max(1);
    let end = match count.checked_sub(1) {
        Some(last) => last.checked_mul(stride)?.checked_add(size)?.checked_add(offset)?,
        None => offset,
    };
    let bytes = bytes.get(offset..end)?;
    Some((0..count).map(move |i| &bytes[i * stride..i * stride + size]))
}

/// The number that 1 is written as, if whole numbers are normalized.
fn greatest(kind: DataType) -> f64 {
    match kind {
        DataType::I8 => f64::from(i8::MAX),
        DataType::U8 => f64::from(u8::MAX),
        DataType::I16 => f64::from(i16::MAX),
        DataType::U16 => f64::from(u16::MAX),
        DataType::U32 => f64::from(u32::MAX),
        DataType::F32 => 1.0,
    }
}

/// The number that the first bytes are.
#[inline(always)]
fn decode(kind: DataType, bytes: &[u8]) -> f64 {
    let two = || bytes.first_chunk().copied().unwrap_or_default();
    let four = || bytes.first_chunk().copied().unwrap_or_default();
    match kind {
        DataType::I8 => f64::from(bytes[0] as i8),
        DataType::U8 => f64::from(bytes[0]),
        DataType::I16 => f64::from(i16::from_le_bytes(two())),
        DataType::U16 => f64::from(u16::from_le_bytes(two())),
        DataType::U32 => f64::from(u32::from_le_bytes(four())),
        DataType::F32 => f64::from(f32::from_le_bytes(four())),
    }
}
