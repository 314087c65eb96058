//! The colours of chemical elements, as chemists model them: after Corey, Pauling and Koltun, with those of Jmol for the rest.

use crate::color::from_srgb8;
use crate::volume::{TransferError, TransferFunction};

/// Atomic numbers and colours, as bytes of sRGB.
const COLORS: [(u8, [u8; 3]); 29] = [
    (0, [200, 200, 200]),
    (1, [255, 255, 255]),
    (2, [217, 255, 255]),
    (3, [204, 128, 255]),
    (4, [194, 255, 0]),
    (5, [255, 181, 181]),
    (6, [120, 120, 120]),
    (7, [48, 80, 248]),
    (8, [235, 40, 30]),
    (9, [144, 224, 80]),
    (10, [179, 227, 245]),
    (11, [171, 92, 242]),
    (12, [138, 220, 0]),
    (13, [191, 166, 166]),
    (14, [240, 200, 160]),
    (15, [255, 128, 0]),
    (16, [240, 220, 48]),
    (17, [31, 240, 31]),
    (18, [128, 209, 227]),
    (19, [143, 64, 212]),
    (20, [61, 235, 0]),
    (22, [191, 194, 199]),
    (26, [224, 102, 51]),
    (29, [200, 128, 51]),
    (30, [125, 128, 176]),
    (35, [166, 41, 41]),
    (47, [192, 192, 192]),
    (53, [148, 0, 148]),
    (79, [255, 209, 35]),
];
/// Of all others.
const OTHER: [u8; 3] = [235, 130, 180];

/// A colour for each atomic number.
///
/// # Errors
/// None: there are few elements.
pub fn element_colors() -> Result<TransferFunction, TransferError> {
    let color = |number: u8| COLORS.iter().find(|(known, _)| *known == number).map_or(OTHER, |(_, color)| *color);
    TransferFunction::steps("elements", (0..=118).map(|number| (number.into(), from_srgb8(color(number)).to_array())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::ColorMap;

    #[test]
    fn elements_have_their_colours() {
        let map = ColorMap::new(&element_colors().unwrap(), [0.0, 118.0]);
        for (number, [r, g, b]) in [(8, [235, 40, 30]), (6, [120, 120, 120]), (26, [224, 102, 51]), (100, OTHER)] {
            assert_eq!(map.color(number as f32), from_srgb8([r, g, b]).to_array(), "{number}");
        }
    }
}
