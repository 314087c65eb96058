//! The headers of NIfTI-1 (348 bytes) and NIfTI-2 (540 bytes), of any byte order: where their fields are.

/// A field: where it starts, and the type of its numbers.
type Spot = (usize, Number);

/// The type of a number.
#[derive(Clone, Copy, Debug)]
enum Number {
    I16,
    I32,
    I64,
    F32,
    F64,
}

/// Where the fields of a version are.
#[derive(Debug)]
struct Table {
    /// Bytes of the header, which are what its first number says.
    size: usize,
    magic: usize,
    fields: [(Name, Spot); 13],
}

/// The fields that matter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Name {
    /// How many dimensions there are, and the size of each.
    Dim,
    /// The type of voxels, by number.
    DataType,
    /// Whether the third axis is turned around, and the spacing of each.
    PixDim,
    /// Where voxels start.
    VoxOffset,
    /// What voxels are multiplied by.
    Slope,
    /// What is added then.
    Intercept,
    QformCode,
    SformCode,
    /// Three numbers of a unit quaternion.
    Quaternion,
    QformOffset,
    SformX,
    SformY,
    SformZ,
}

const TABLES: [Table; 2] = [
    Table {
        size: 348,
        magic: 344,
        fields: [
            (Name::Dim, (40, Number::I16)),
            (Name::DataType, (70, Number::I16)),
            (Name::PixDim, (76, Number::F32)),
            (Name::VoxOffset, (108, Number::F32)),
            (Name::Slope, (112, Number::F32)),
            (Name::Intercept, (116, Number::F32)),
            (Name::QformCode, (252, Number::I16)),
            (Name::SformCode, (254, Number::I16)),
            (Name::Quaternion, (256, Number::F32)),
            (Name::QformOffset, (268, Number::F32)),
            (Name::SformX, (280, Number::F32)),
            (Name::SformY, (296, Number::F32)),
            (Name::SformZ, (312, Number::F32)),
        ],
    },
    Table {
        size: 540,
        magic: 4,
        fields: [
            (Name::Dim, (16, Number::I64)),
            (Name::DataType, (12, Number::I16)),
            (Name::PixDim, (104, Number::F64)),
            (Name::VoxOffset, (168, Number::I64)),
            (Name::Slope, (176, Number::F64)),
            (Name::Intercept, (184, Number::F64)),
            (Name::QformCode, (344, Number::I32)),
            (Name::SformCode, (348, Number::I32)),
            (Name::Quaternion, (352, Number::F64)),
            (Name::QformOffset, (376, Number::F64)),
            (Name::SformX, (400, Number::F64)),
            (Name::SformY, (432, Number::F64)),
            (Name::SformZ, (464, Number::F64)),
        ],
    },
];

/// What the start of a file is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Magic {
    /// A header with voxels behind it.
    Single,
    /// A header whose voxels are in a file of their own.
    Pair,
    /// A header of Analyze 7.5, which came before NIfTI.
    Analyze,
}

/// A header.
#[derive(Debug)]
pub(super) struct RawHeader {
    table: &'static Table,
    bytes: Vec<u8>,
    /// Do numbers start with their most significant byte?
    pub(super) big_endian: bool,
}

impl RawHeader {
    /// How many bytes the header has that starts so, and whether it is big-endian; `None`: it is no header.
    pub(super) fn size(start: &[u8]) -> Option<(usize, bool)> {
        let first = *start.first_chunk()?;
        let [little, big] = [i32::from_le_bytes(first), i32::from_be_bytes(first)];
        let table = TABLES.iter().find(|table| [little, big].contains(&(table.size as i32)))?;
        Some((table.size, big == table.size as i32))
    }

    /// The header in these bytes, which are as many as its [`size`](Self::size); `None`: it is no header.
    pub(super) fn of(bytes: Vec<u8>) -> Option<(Self, Magic)> {
        let (size, big_endian) = Self::size(&bytes)?;
        let table = TABLES.iter().find(|table| table.size == size && bytes.len() == size)?;
        let magic = match (size, &bytes[table.magic..][..4]) {
            (348, b"n+1\0") | (540, b"n+2\0") => Magic::Single,
            (348, b"ni1\0") | (540, b"ni2\0") => Magic::Pair,
            (348, _) => Magic::Analyze,
            _ => return None,
        };
        Some((Self { table, bytes, big_endian }, magic))
    }

    /// Its bytes.
    pub(super) fn len(&self) -> usize {
        self.table.size
    }

    /// Number `i` of a field.
    pub(super) fn get(&self, name: Name, i: usize) -> f64 {
        let (_, (at, number)) = self.table.fields.iter().find(|(field, _)| *field == name).expect("all are there");
        macro_rules! read {
            ($type:ty) => {{
                let bytes = *self.bytes[at + i * size_of::<$type>()..].first_chunk().expect("inside of the header");
                let value = if self.big_endian { <$type>::from_be_bytes(bytes) } else { <$type>::from_le_bytes(bytes) };
                value as f64
            }};
        }
        match number {
            Number::I16 => read!(i16),
            Number::I32 => read!(i32),
            Number::I64 => read!(i64),
            Number::F32 => read!(f32),
            Number::F64 => read!(f64),
        }
    }

    /// Several numbers of a field, from number `i` on.
    pub(super) fn several<const N: usize>(&self, name: Name, i: usize) -> [f64; N] {
        std::array::from_fn(|k| self.get(name, i + k))
    }
}
