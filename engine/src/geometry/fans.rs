//! Which corners of triangles are at one point. Meshes of millions of triangles should not wait for this, so nothing is allocated for each
//! point: the corners at each are a run of one list, sorted by counting.

use super::Mesh;
use super::weld::Weld;

/// The corners at each point: corner `k` of triangle `i` is `3 i + k`, as numbers of 32 bits.
pub(super) struct Fans {
    corners: Vec<u32>,
    /// Where the run of each point ends.
    ends: Vec<u32>,
}

impl Fans {
    /// Sorts the corners of all triangles that count, which must have theirs in range. Corners of equal positions are at one point,
    /// whatever their indices.
    pub(super) fn of(mesh: &Mesh, counts: impl Fn(usize) -> bool) -> Self {
        let points = equal_positions(&mesh.positions);
        let corners = || {
            let triangles = mesh.triangles.iter().enumerate().filter(|&(i, _)| counts(i));
            triangles.flat_map(|(i, corners)| (0..3).map(move |k| (3 * i as u32 + k, corners[k as usize])))
        };
        let mut ends = vec![0; mesh.positions.len()];
        corners().for_each(|(_, position)| ends[points[position as usize] as usize] += 1);
        // Where each run starts; it moves on to its end as corners are put there.
        let mut start = 0;
        for count in &mut ends {
            (*count, start) = (start, start + *count);
        }
        let mut sorted = vec![0; start as usize];
        for (corner, position) in corners() {
            let next = &mut ends[points[position as usize] as usize];
            sorted[*next as usize] = corner;
            *next += 1;
        }
        Self { corners: sorted, ends }
    }

    /// The corners at each point that has any, in their order.
    pub(super) fn iter(&self) -> impl Iterator<Item = &[u32]> {
        let mut start = 0;
        let run = move |&end: &u32| &self.corners[std::mem::replace(&mut start, end as usize)..end as usize];
        self.ends.iter().map(run).filter(|corners| !corners.is_empty())
    }
}

/// For each position the first that is equal. Zeros are, of either sign.
fn equal_positions(positions: &[[f32; 3]]) -> Vec<u32> {
    let words = |position: [f32; 3]| {
        let [x, y, z] = position.map(|x| u64::from((x + 0.0).to_bits()));
        [x << 32 | y, z]
    };
    let mut weld = Weld::with_capacity(positions.len());
    let find = |(number, &position): (usize, &[f32; 3])| {
        weld.find(words(position), number as u32, |number| words(positions[number as usize]))
    };
    positions.iter().enumerate().map(find).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_at_equal_positions_are_together() {
        let [a, b, c] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let positions = vec![a, b, c, [-0.0, 0.0, -0.0], b, [9.0; 3]];
        let mesh = Mesh { positions, triangles: vec![[0, 1, 2], [5, 5, 5], [2, 4, 3]], ..Mesh::default() };
        let fans = Fans::of(&mesh, |i| i != 1);
        assert_eq!(fans.iter().collect::<Vec<_>>(), [[0, 8], [1, 7], [2, 6]]);
    }
}
