//! The values of a grid in the type that they came in.

use std::fmt;
use std::ops::Deref;

/// Values of one type.
#[derive(Clone)]
pub struct Samples<V>(Vec<V>);

impl<V> Deref for Samples<V> {
    type Target = [V];

    fn deref(&self) -> &[V] {
        &self.0
    }
}

impl<V> From<Vec<V>> for Samples<V> {
    fn from(values: Vec<V>) -> Self {
        Self(values)
    }
}

impl<V> fmt::Debug for Samples<V> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} values", self.len())
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

        $(impl From<Vec<$type>> for Voxels {
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
