//! What is in geometry: bounds, counts by name, and what is left out.

use glam::Vec3;

/// Something that is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Its key, for programs: `degenerate_triangles`.
    pub key: &'static str,
    /// One of it, for people: `triangle without area`.
    pub one: &'static str,
    /// Several of it.
    pub many: &'static str,
    /// What it says.
    pub role: Role,
}

/// What a count says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// How many primitives there are, those left out included.
    Primitives,
    /// What they are made of.
    Detail,
    /// How many primitives are left out, for one reason.
    LeftOut,
}

impl Item {
    /// Primitives.
    pub const fn primitives(key: &'static str, one: &'static str, many: &'static str) -> Self {
        Self { key, one, many, role: Role::Primitives }
    }

    /// What primitives are made of.
    pub const fn detail(key: &'static str, one: &'static str, many: &'static str) -> Self {
        Self { key, one, many, role: Role::Detail }
    }

    /// Primitives that are left out.
    pub const fn left_out(key: &'static str, one: &'static str, many: &'static str) -> Self {
        Self { key, one, many, role: Role::LeftOut }
    }
}

/// What was found in geometry.
#[derive(Clone, Debug, PartialEq)]
pub struct Census {
    /// Least and greatest corner of what is not left out; `(inf, -inf)` if there is nothing.
    pub bounds: (Vec3, Vec3),
    counts: Vec<(Item, u64)>,
}

impl Default for Census {
    fn default() -> Self {
        Self { bounds: (Vec3::INFINITY, Vec3::NEG_INFINITY), counts: Vec::new() }
    }
}

impl Census {
    /// Adds to the count of an item.
    pub fn add(&mut self, item: Item, count: u64) {
        match self.counts.iter_mut().find(|(known, _)| known.key == item.key) {
            Some((_, so_far)) => *so_far += count,
            None => self.counts.push((item, count)),
        }
    }

    /// Sets the count of an item.
    pub fn set(&mut self, item: Item, count: u64) {
        self.counts.retain(|(known, _)| known.key != item.key);
        self.counts.push((item, count));
    }

    /// The count of the item with a key; 0 if there is none.
    pub fn count(&self, key: &str) -> u64 {
        self.counts.iter().find(|(item, _)| item.key == key).map_or(0, |(_, count)| *count)
    }

    /// All items that were counted, in the order in which they were added.
    pub fn items(&self) -> &[(Item, u64)] {
        &self.counts
    }

    /// How many primitives are left out.
    pub fn left_out(&self) -> u64 {
        self.counts.iter().filter(|(item, _)| item.role == Role::LeftOut).map(|(_, count)| count).sum()
    }

    /// The same with other bounds.
    pub fn within(self, bounds: (Vec3, Vec3)) -> Self {
        Self { bounds, ..self }
    }

    /// Makes the bounds hold all points within `radius` of `point` on each axis.
    #[inline(always)]
    pub fn include(&mut self, point: Vec3, radius: f32) {
        self.bounds = (self.bounds.0.min(point - radius), self.bounds.1.max(point + radius));
    }

    /// Adds what was found in other geometry.
    pub fn merge(&mut self, other: &Self) {
        self.bounds = (self.bounds.0.min(other.bounds.0), self.bounds.1.max(other.bounds.1));
        other.counts.iter().for_each(|&(item, count)| self.add(item, count));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BALL: Item = Item::primitives("balls", "ball", "balls");
    const FLAT: Item = Item::left_out("flat_balls", "flat ball", "flat balls");

    #[test]
    fn counts_add_up_by_key() {
        let mut one = Census::default();
        one.add(BALL, 3);
        one.include(Vec3::ONE, 1.0);
        let mut all = Census::default();
        all.add(FLAT, 2);
        all.merge(&one);
        all.merge(&one);
        assert_eq!([all.count("balls"), all.count("flat_balls"), all.count("cubes"), all.left_out()], [6, 2, 0, 2]);
        assert_eq!(all.bounds, (Vec3::ZERO, Vec3::splat(2.0)));
        all.set(BALL, 1);
        assert_eq!(all.count("balls"), 1);
    }
}
