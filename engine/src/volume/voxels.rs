//! The values of a grid in the type that they came in.

use std::fmt;
use std::ops::{Deref, Range};
use std::sync::Arc;

use bytemuck::Pod;
use memmap2::Mmap;

/// Values of one type: in memory, or in a file that is read where they are looked at.
#[derive(Clone)]
pub struct Samples<V>(Kept<V>);

#[derive(Clone)]
enum Kept<V> {
    Memory(Vec<V>),
    File(Arc<Mmap>, Range<usize>),
}

impl<V: Pod> Samples<V> {
    /// The values that some bytes of a mapped file are, in the order of this machine; `None` if they are not there, or not aligned for
    /// the type.
    pub fn mapped(map: Arc<Mmap>, bytes: Range<usize>) -> Option<Self> {
        bytemuck::try_cast_slice::<u8, V>(map.get(bytes.clone())?).ok()?;
        Some(Self(Kept::File(map, bytes)))
    }
}

impl<V: Pod> Deref for Samples<V> {
    type Target = [V];

    #[inline]
    fn deref(&self) -> &[V] {
        match &self.0 {
            Kept::Memory(values) => values,
            Kept::File(map, bytes) => bytemuck::cast_slice(&map[bytes.clone()]),
        }
    }
}

impl<V> From<Vec<V>> for Samples<V> {
    fn from(values: Vec<V>) -> Self {
        Self(Kept::Memory(values))
    }
}

impl<V: Pod> fmt::Debug for Samples<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = if matches!(self.0, Kept::File(..)) { " in a file" } else { "" };
        write!(f, "{} values{place}", self.len())
    }
}

macro_rules! voxels {
    ($($variant:ident $type:ident,)+) => {
        /// Values of any of the types that grids come in.
        #[derive(Clone, Debug)]
        pub enum Voxels {
            $(#[doc = concat!("`", stringify!($type), "`")] $variant(Samples<$type>),)+
        }

        impl Voxels {
            /// The name of the type.
            pub fn type_name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => stringify!($type),)+
                }
            }

            /// Bytes of one value.
            pub fn bytes_each(&self) -> usize {
                match self {
                    $(Self::$variant(_) => size_of::<$type>(),)+
                }
            }

            /// How many there are.
            pub fn len(&self) -> usize {
                match self {
                    $(Self::$variant(values) => values.len(),)+
                }
            }

            /// Are there none?
            pub fn is_empty(&self) -> bool {
                self.len() == 0
            }

            /// Value `i`.
            pub fn get(&self, i: usize) -> f64 {
                match self {
                    $(Self::$variant(values) => values[i] as f64,)+
                }
            }
        }

        $(impl From<Samples<$type>> for Voxels {
            fn from(values: Samples<$type>) -> Self {
                Self::$variant(values)
            }
        }

        impl From<Vec<$type>> for Voxels {
            fn from(values: Vec<$type>) -> Self {
                Self::$variant(values.into())
            }
        })+
    };
}

voxels! {
    U8 u8,
    I8 i8,
    U16 u16,
    I16 i16,
    U32 u32,
    I32 i32,
    F32 f32,
    F64 f64,
}

/// Does something with the values of [`Voxels`], a slice of whatever type they are: `with_voxels!(voxels, |values| ...)`.
macro_rules! with_voxels {
    ($voxels:expr, |$values:ident| $body:expr) => {
        match $voxels {
            $crate::volume::Voxels::U8($values) => $body,
            $crate::volume::Voxels::I8($values) => $body,
            $crate::volume::Voxels::U16($values) => $body,
            $crate::volume::Voxels::I16($values) => $body,
            $crate::volume::Voxels::U32($values) => $body,
            $crate::volume::Voxels::I32($values) => $body,
            $crate::volume::Voxels::F32($values) => $body,
            $crate::volume::Voxels::F64($values) => $body,
        }
    };
}
pub(crate) use with_voxels;
