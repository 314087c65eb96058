//! Chemical elements: their symbols, how large their atoms are, and in which colours chemists model them.

use crate::color::from_srgb8;
use crate::volume::{TransferError, TransferFunction};

/// Symbols by atomic number, from 1.
const SYMBOLS: [&str; 118] = [
    "H", "He", "Li", "Be", "B", "C", "N", "O", "F", "Ne", "Na", "Mg", "Al", "Si", "P", "S", "Cl", "Ar", "K", "Ca",
    "Sc", "Ti", "V", "Cr", "Mn", "Fe", "Co", "Ni", "Cu", "Zn", "Ga", "Ge", "As", "Se", "Br", "Kr", "Rb", "Sr", "Y",
    "Zr", "Nb", "Mo", "Tc", "Ru", "Rh", "Pd", "Ag", "Cd", "In", "Sn", "Sb", "Te", "I", "Xe", "Cs", "Ba", "La", "Ce",
    "Pr", "Nd", "Pm", "Sm", "Eu", "Gd", "Tb", "Dy", "Ho", "Er", "Tm", "Yb", "Lu", "Hf", "Ta", "W", "Re", "Os", "Ir",
    "Pt", "Au", "Hg", "Tl", "Pb", "Bi", "Po", "At", "Rn", "Fr", "Ra", "Ac", "Th", "Pa", "U", "Np", "Pu", "Am", "Cm",
    "Bk", "Cf", "Es", "Fm", "Md", "No", "Lr", "Rf", "Db", "Sg", "Bh", "Hs", "Mt", "Ds", "Rg", "Cn", "Nh", "Fl", "Mc",
    "Lv", "Ts", "Og",
];

/// Van der Waals radii in angstrom by atomic number: Bondi, "van der Waals Volumes and Radii", J. Phys. Chem. 68 (1964), and for the
/// other main groups Mantina et al., "Consistent van der Waals Radii for the Whole Main Group", J. Phys. Chem. A 113 (2009).
const RADII: [(u8, f32); 54] = [
    (1, 1.1),
    (2, 1.4),
    (3, 1.81),
    (4, 1.53),
    (5, 1.92),
    (6, 1.7),
    (7, 1.55),
    (8, 1.52),
    (9, 1.47),
    (10, 1.54),
    (11, 2.27),
    (12, 1.73),
    (13, 1.84),
    (14, 2.1),
    (15, 1.8),
    (16, 1.8),
    (17, 1.75),
    (18, 1.88),
    (19, 2.75),
    (20, 2.31),
    (28, 1.63),
    (29, 1.4),
    (30, 1.39),
    (31, 1.87),
    (32, 2.11),
    (33, 1.85),
    (34, 1.9),
    (35, 1.83),
    (36, 2.02),
    (37, 3.03),
    (38, 2.49),
    (46, 1.63),
    (47, 1.72),
    (48, 1.58),
    (49, 1.93),
    (50, 2.17),
    (51, 2.06),
    (52, 2.06),
    (53, 1.98),
    (54, 2.16),
    (55, 3.43),
    (56, 2.68),
    (78, 1.75),
    (79, 1.66),
    (80, 1.55),
    (81, 1.96),
    (82, 2.02),
    (83, 2.07),
    (84, 1.97),
    (85, 2.02),
    (86, 2.2),
    (87, 3.48),
    (88, 2.83),
    (92, 1.86),
];
/// The radius of atoms of which none is known.
const UNKNOWN: f32 = 2.0;

/// The atomic number that a word means: a number, a symbol, or the name of an atom that starts with one, such as `OW1`; 0: none.
pub(crate) fn atomic_number(word: &str) -> u8 {
    if let Ok(number) = word.parse::<u8>() {
        return if usize::from(number) <= SYMBOLS.len() { number } else { 0 };
    }
    let letters: &str = &word[..word.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(word.len())];
    let of = |symbol: &str| SYMBOLS.iter().position(|known| known.eq_ignore_ascii_case(symbol));
    let found = of(letters).or_else(|| of(letters.get(..1)?));
    found.map_or(0, |at| at as u8 + 1)
}

/// How large an atom is, in angstrom.
pub(crate) fn radius(atomic_number: u8) -> f32 {
    RADII.iter().find(|(number, _)| *number == atomic_number).map_or(UNKNOWN, |&(_, radius)| radius)
}

/// The symbol of an element; of what is none, its number.
pub(crate) fn symbol(atomic_number: u8) -> String {
    let at = usize::from(atomic_number).checked_sub(1);
    at.and_then(|at| SYMBOLS.get(at)).map_or_else(|| atomic_number.to_string(), |symbol| (*symbol).to_owned())
}

/// Atomic numbers and colours, as bytes of sRGB: after Corey, Pauling and Koltun, with those of Jmol for the rest.
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
    fn words_mean_elements() {
        for (word, number) in [
            ("H", 1),
            ("Cl", 17),
            ("CL", 17),
            ("OW1", 8),
            ("u", 92),
            ("Og", 118),
            ("79", 79),
            ("200", 0),
            ("X", 0),
            ("", 0),
            ("\u{e9}", 0),
        ] {
            assert_eq!(atomic_number(word), number, "{word}");
        }
        assert_eq!([8, 26, 0].map(radius), [1.52, 2.0, 2.0]);
        assert_eq!([1, 17, 0, 200].map(symbol), ["H", "Cl", "0", "200"]);
    }

    #[test]
    fn elements_have_their_colours() {
        let map = ColorMap::new(&element_colors().unwrap(), [0.0, 118.0]);
        for (number, [r, g, b]) in [(8, [235, 40, 30]), (6, [120, 120, 120]), (26, [224, 102, 51]), (100, OTHER)] {
            let (found, expected) = (map.color(number as f32), from_srgb8([r, g, b]).to_array());
            assert!((0..3).all(|k| (found[k] - expected[k]).abs() < 1e-6), "{number}: {found:?}");
        }
    }
}
