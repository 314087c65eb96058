//! A number of each particle, in the type that it came in.

use std::borrow::Cow;

/// A number that each particle has.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// What its file calls it.
    pub name: String,
    /// One value a particle.
    pub values: Values,
}

/// Values of one type.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Measures.
    F32(Vec<f32>),
    /// Kinds, elements, parts of colours.
    U8(Vec<u8>),
}

impl Values {
    /// The name of the type.
    pub fn type_name(&self) -> &'static str {
        match self {
            Self::F32(_) => "f32",
            Self::U8(_) => "u8",
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(values) => values.len(),
            Self::U8(values) => values.len(),
        }
    }

    /// Are there none?
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Value `i`; NaN if there is none.
    pub fn get(&self, i: usize) -> f32 {
        match self {
            Self::F32(values) => values.get(i).copied().unwrap_or(f32::NAN),
            Self::U8(values) => values.get(i).map_or(f32::NAN, |&value| f32::from(value)),
        }
    }

    /// All of them as `f32`.
    pub fn to_f32(&self) -> Cow<'_, [f32]> {
        match self {
            Self::F32(values) => Cow::Borrowed(values),
            Self::U8(values) => Cow::Owned(values.iter().map(|&value| f32::from(value)).collect()),
        }
    }

    /// Keeps those of particles for which `keep` is true.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        match self {
            Self::F32(values) => retain(values, keep),
            Self::U8(values) => retain(values, keep),
        }
    }

    /// So many times all of them, one list after the other.
    pub(super) fn repeated(&self, times: usize) -> Self {
        match self {
            Self::F32(values) => Self::F32(values.repeat(times)),
            Self::U8(values) => Self::U8(values.repeat(times)),
        }
    }
}

/// Keeps values for which `keep` is true.
pub(super) fn retain<T>(values: &mut Vec<T>, keep: &[bool]) {
    let mut keep = keep.iter();
    values.retain(|_| keep.next().is_none_or(|keep| *keep));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_of_either_type() {
        for mut values in [Values::F32(vec![1.0, 2.0, 3.0]), Values::U8(vec![1, 2, 3])] {
            assert_eq!((values.len(), values.get(1)), (3, 2.0));
            assert!(values.get(3).is_nan());
            values.retain(&[true, false, true]);
            assert_eq!(*values.to_f32(), [1.0, 3.0]);
            assert_eq!(*values.repeated(2).to_f32(), [1.0, 3.0, 1.0, 3.0]);
        }
    }
}
