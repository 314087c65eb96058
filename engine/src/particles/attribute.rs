//! A number of each particle, in the type that it came in.

pub use mobula_core::cloud::Values;

/// A number that each particle has.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// What its file calls it.
    pub name: String,
    /// One value a particle.
    pub values: Values,
}

impl Attribute {
    /// The name of the type of the values.
    pub fn type_name(&self) -> &'static str {
        match self.values {
            Values::F32(_) => "f32",
            Values::U8(_) => "u8",
        }
    }

    /// Keeps the values of particles for which `keep` is true.
    pub(super) fn retain(&mut self, keep: &[bool]) {
        match &mut self.values {
            Values::F32(values) => retain(values, keep),
            Values::U8(values) => retain(values, keep),
        }
    }

    /// So many times all of them, one list after the other.
    pub(super) fn repeated(&self, times: usize) -> Self {
        let values = match &self.values {
            Values::F32(values) => Values::F32(values.repeat(times)),
            Values::U8(values) => Values::U8(values.repeat(times)),
        };
        Self { name: self.name.clone(), values }
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
        for values in [Values::F32(vec![1.0, 2.0, 3.0]), Values::U8(vec![1, 2, 3])] {
            let mut attribute = Attribute { name: "x".to_owned(), values };
            assert_eq!((attribute.values.len(), attribute.values.get(1)), (3, 2.0));
            assert!(attribute.values.get(3).is_nan());
            attribute.retain(&[true, false, true]);
            assert_eq!(*attribute.values.to_f32(), [1.0, 3.0]);
            assert_eq!(*attribute.repeated(2).values.to_f32(), [1.0, 3.0, 1.0, 3.0]);
        }
    }
}
