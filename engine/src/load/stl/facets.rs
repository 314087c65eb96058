//! What was read of an STL file: triangles that share corners where these are equal, with solids as groups.

use crate::color::from_srgb;
use crate::geometry::{Mesh, MeshGroup, NO_INDEX, Weld};
use crate::load::lines::Fault;
use crate::load::place::Place;

/// The bit of a colour that says that there is one; below it 5 bits each of red, green and blue.
pub(super) const COLORED: u16 = 1 << 15;

/// What was read.
pub(super) struct Facets {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) positions: Vec<[f64; 3]>,
    /// The colour of what has none of its own, from 0 to 1 on the sRGB curve.
    pub(super) color: [f64; 3],
    /// For each position the colour of its triangles, [`COLORED`] or 0: triangles of different colours share no corners.
    colors: Vec<u16>,
    weld: Weld<4>,
    groups: Vec<MeshGroup>,
}

impl Default for Facets {
    fn default() -> Self {
        Self {
            triangles: Vec::new(),
            positions: Vec::new(),
            color: [1.0; 3],
            colors: Vec::new(),
            weld: Weld::with_capacity(0),
            groups: Vec::new(),
        }
    }
}

impl Facets {
    /// Adds a triangle.
    pub(super) fn add(&mut self, corners: [[f64; 3]; 3], color: u16) -> Result<(), Fault> {
        if self.positions.len() >= NO_INDEX as usize - 3 || self.triangles.len() >= u32::MAX as usize {
            return Err(Fault::new("more corners than 32-bit indices reach", "split it"));
        }
        let Self { positions, colors, weld, .. } = self;
        self.triangles.push(corners.map(|corner| {
            let (new, words) = (positions.len() as u32, words(corner, color));
            let index =
                weld.find(words, new, |number| self::words(positions[number as usize], colors[number as usize]));
            if index == new {
                positions.push(corner);
                colors.push(color);
            }
            index
        }));
        Ok(())
    }

    /// From here on triangles are those of a solid.
    pub(super) fn begin(&mut self, solid: &str) {
        // One without triangles is nothing: a file may have millions of these.
        self.groups.pop_if(|last| last.first == self.triangles.len() as u32);
        self.groups.push(MeshGroup { name: solid.to_owned(), first: self.triangles.len() as u32, count: 0 });
    }

    pub(super) fn into_mesh(self, name: String, place: &Place) -> Mesh {
        let mut groups = self.groups;
        let mut end = self.triangles.len() as u32;
        for group in groups.iter_mut().rev() {
            group.count = end - group.first;
            end = group.first;
        }
        groups.retain(|group| group.count > 0);
        let part = |color: u16, bits: u16| f64::from(color >> bits & 31) / 31.0;
        let color_of = |&color: &u16| {
            let own = [10, 5, 0].map(|bits| part(color, bits));
            from_srgb(if color & COLORED == 0 { self.color } else { own }).to_array()
        };
        let plain = self.color == [1.0; 3] && self.colors.iter().all(|color| color & COLORED == 0);
        Mesh {
            name,
            positions: self.positions.iter().map(|&position| place.put(position)).collect(),
            colors: if plain { Vec::new() } else { self.colors.iter().map(color_of).collect() },
            triangles: self.triangles,
            groups,
            ..Mesh::default()
        }
    }
}

/// What corners are told apart by. Zeros are equal, of either sign.
fn words(position: [f64; 3], color: u16) -> [u64; 4] {
    let [x, y, z] = position.map(|x| (x + 0.0).to_bits());
    [x, y, z, color.into()]
}
