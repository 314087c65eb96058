//! Numbers by column, in the smallest type that holds them.

use std::collections::HashSet;

use super::names;
use crate::load::lines::Fault;
use crate::load::text::quoted;
use crate::particles::Values;

/// More columns are in no file of particles.
pub(in crate::load) const MOST_COLUMNS: usize = 256;

/// How numbers are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::load) enum Storage {
    /// Whole numbers from 0 to 255; the column becomes one of `f32` with the first number that is not.
    U8,
    F32,
    /// Of coordinates; anything else is `f32`.
    F64,
}

/// A column.
#[derive(Debug)]
struct Column {
    name: String,
    numbers: Numbers,
}

#[derive(Debug)]
enum Numbers {
    U8(Vec<u8>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// Columns of numbers, three of which are coordinates.
#[derive(Debug)]
pub(in crate::load) struct Columns {
    columns: Vec<Column>,
    axes: [usize; 3],
}

impl Columns {
    /// Columns of these names, without a number.
    pub(in crate::load) fn new(wanted: Vec<(String, Storage)>) -> Result<Self, Fault> {
        if wanted.len() > MOST_COLUMNS {
            let problem =
                format!("each particle has {} numbers, of which at most {MOST_COLUMNS} can be kept", wanted.len());
            return Err(Fault::new(problem, "leave some out"));
        }
        let mut seen = HashSet::new();
        if let Some((name, _)) = wanted.iter().find(|(name, _)| !seen.insert(name)) {
            return Err(Fault::new(format!("there are two columns {}", quoted(name)), "rename one of them"));
        }
        let all: Vec<&str> = wanted.iter().map(|(name, _)| &**name).collect();
        let Some(axes) = names::axes(&all) else {
            let all = quoted(&all.join(" "));
            let problem = format!("there are no columns x, y and z, only {all}");
            return Err(Fault::new(problem, "name the columns of the coordinates x, y and z"));
        };
        let column = |(at, (name, storage)): (usize, (String, Storage))| {
            let numbers = match storage {
                Storage::U8 => Numbers::U8(Vec::new()),
                Storage::F64 if axes.contains(&at) => Numbers::F64(Vec::new()),
                Storage::F32 | Storage::F64 => Numbers::F32(Vec::new()),
            };
            Column { name, numbers }
        };
        Ok(Self { columns: wanted.into_iter().enumerate().map(column).collect(), axes })
    }

    /// Adds a number to a column.
    #[inline]
    pub(in crate::load) fn push(&mut self, column: usize, number: f64) {
        let Some(Column { numbers, .. }) = self.columns.get_mut(column) else { return };
        match numbers {
            Numbers::F32(numbers) => numbers.push(number as f32),
            Numbers::F64(numbers) => numbers.push(number),
            Numbers::U8(bytes) if f64::from(number as u8) == number => bytes.push(number as u8),
            Numbers::U8(bytes) => {
                let wide = bytes.iter().map(|&byte| f32::from(byte)).chain([number as f32]).collect();
                *numbers = Numbers::F32(wide);
            }
        }
    }

    /// Room for one more particle, where as many numbers are added to each column.
    #[inline]
    pub(in crate::load) fn make_room(&mut self) -> Result<(), Fault> {
        fn room<T>(numbers: &mut Vec<T>) -> bool {
            numbers.len() < numbers.capacity() || numbers.try_reserve(numbers.len().max(64)).is_ok()
        }
        let mut all = self.columns.iter_mut().map(|column| match &mut column.numbers {
            Numbers::U8(numbers) => room(numbers),
            Numbers::F32(numbers) => room(numbers),
            Numbers::F64(numbers) => room(numbers),
        });
        if all.all(|there| there) {
            return Ok(());
        }
        Err(Fault::new(format!("there is no memory for more than {} particles", self.len()), "leave some out"))
    }

    /// Room for so many more numbers in each column, as far as there is memory.
    pub(in crate::load) fn reserve(&mut self, count: usize) {
        for column in &mut self.columns {
            // What cannot be reserved fails later, when it is needed.
            let _ = match &mut column.numbers {
                Numbers::U8(numbers) => numbers.try_reserve_exact(count),
                Numbers::F32(numbers) => numbers.try_reserve_exact(count),
                Numbers::F64(numbers) => numbers.try_reserve_exact(count),
            };
        }
    }

    /// Particles whose coordinates are complete.
    pub(super) fn len(&self) -> usize {
        self.axes.iter().map(|&axis| self.columns[axis].numbers.len()).min().unwrap_or(0)
    }

    /// The bytes in the column of a name; `None`: there is none, or they are wider.
    pub(super) fn bytes(&self, name: &str) -> Option<&[u8]> {
        self.columns.iter().find(|column| column.name == name).and_then(|column| match &column.numbers {
            Numbers::U8(bytes) => Some(&**bytes),
            _ => None,
        })
    }

    /// Where particle `i` is.
    pub(super) fn position(&self, i: usize) -> [f64; 3] {
        self.axes.map(|axis| self.columns[axis].numbers.get(i))
    }

    /// Changes all coordinates.
    pub(super) fn map_positions(&mut self, map: impl Fn([f64; 3]) -> [f64; 3]) {
        for i in 0..self.len() {
            let mapped = map(self.position(i));
            for (&axis, value) in self.axes.iter().zip(mapped) {
                self.columns[axis].numbers.set(i, value);
            }
        }
    }

    /// Names and values of all columns but the coordinates.
    pub(super) fn into_others(self) -> (Vec<String>, Vec<Values>) {
        let axes = self.axes;
        let others = self.columns.into_iter().enumerate().filter(|(at, _)| !axes.contains(at));
        let values = |numbers: Numbers| match numbers {
            Numbers::U8(values) => Values::U8(values),
            Numbers::F32(values) => Values::F32(values),
            Numbers::F64(values) => Values::F32(values.into_iter().map(|x| x as f32).collect()),
        };
        others.map(|(_, column)| (column.name, values(column.numbers))).unzip()
    }
}

impl Numbers {
    fn len(&self) -> usize {
        match self {
            Self::U8(numbers) => numbers.len(),
            Self::F32(numbers) => numbers.len(),
            Self::F64(numbers) => numbers.len(),
        }
    }

    fn get(&self, i: usize) -> f64 {
        match self {
            Self::U8(numbers) => numbers[i].into(),
            Self::F32(numbers) => numbers[i].into(),
            Self::F64(numbers) => numbers[i],
        }
    }

    fn set(&mut self, i: usize, value: f64) {
        match self {
            Self::U8(numbers) => numbers[i] = value as u8,
            Self::F32(numbers) => numbers[i] = value as f32,
            Self::F64(numbers) => numbers[i] = value,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn columns(names: &[&str], storage: Storage) -> Result<Columns, String> {
        let wanted = names.iter().map(|name| ((*name).to_owned(), storage)).collect();
        Columns::new(wanted).map_err(|fault| fault.problem)
    }

    #[test]
    fn bytes_become_wide_when_they_must() {
        let mut columns = columns(&["x", "y", "z", "kind", "type"], Storage::U8).unwrap();
        for row in [[0.0, 1.0, 2.0, 3.0, 4.0], [5.0, 6.0, -7.5, 8.0, 256.0]] {
            row.into_iter().enumerate().for_each(|(i, x)| columns.push(i, x));
        }
        assert_eq!((columns.len(), columns.position(1)), (2, [5.0, 6.0, -7.5]));
        let (names, values) = columns.into_others();
        assert_eq!(names, ["kind", "type"]);
        assert_eq!(values, [Values::U8(vec![3, 8]), Values::F32(vec![4.0, 256.0])]);
    }

    #[test]
    fn names_are_checked() {
        assert!(columns(&["a", "y", "z"], Storage::F32).unwrap_err().contains("only 'a y z'"));
        assert!(columns(&["x", "y", "z", "x"], Storage::F32).unwrap_err().contains("two columns 'x'"));
        let many: Vec<String> = (0..300).map(|i| i.to_string()).collect();
        let many: Vec<&str> = many.iter().map(|name| &**name).collect();
        assert!(columns(&many, Storage::F32).unwrap_err().contains("300 numbers"));
        let mut wide = columns(&["x", "y", "z", "a"], Storage::F64).unwrap();
        [0.1, 1e300, -2.0, 0.1].into_iter().enumerate().for_each(|(i, x)| wide.push(i, x));
        wide.map_positions(|[x, y, z]| [x * 2.0, y, z]);
        assert_eq!((wide.position(0), wide.into_others().1), ([0.2, 1e300, -2.0], vec![Values::F32(vec![0.1])]));
    }
}
