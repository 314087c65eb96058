//! The types that voxels come in.

use std::fmt;
use std::str::FromStr;

/// A type of voxels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VoxelType {
    /// `u8`
    U8,
    /// `i8`
    I8,
    /// `u16`
    U16,
    /// `i16`
    I16,
    /// `u32`
    U32,
    /// `i32`
    I32,
    /// `f32`
    F32,
    /// `f64`
    F64,
}

impl VoxelType {
    /// All of them.
    pub const ALL: [Self; 8] = [Self::U8, Self::I8, Self::U16, Self::I16, Self::U32, Self::I32, Self::F32, Self::F64];

    /// The name of the type in Rust.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::I8 => "i8",
            Self::U16 => "u16",
            Self::I16 => "i16",
            Self::U32 => "u32",
            Self::I32 => "i32",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// Bytes of one voxel.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

impl fmt::Display for VoxelType {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The name of a type that voxels cannot have.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the types of voxels are u8, i8, u16, i16, u32, i32, f32 and f64")]
pub struct NoVoxelType;

impl FromStr for VoxelType {
    type Err = NoVoxelType;

    fn from_str(name: &str) -> Result<Self, NoVoxelType> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or(NoVoxelType)
    }
}
