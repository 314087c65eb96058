//! Transfer functions by name. Tables have colours as sRGB, as they are published.

use super::transfer::{Scale, TransferFunction, joined};
use crate::choice::choice;
use crate::color::from_srgb;

choice! {
    /// A transfer function.
    "transfer function" Preset {
        /// Bone, for CT in Hounsfield units and millimetres; soft tissue is nearly clear.
        Bone = "bone",
        /// Bone behind translucent skin, for CT.
        Skin = "skin",
        /// Muscle and bone, for CT.
        Muscle = "muscle",
        /// A glowing body: the greater a value, the hotter and the denser.
        Fire = "fire",
        /// What is far from the middle: below blue, above red (Moreland's diverging map).
        CoolWarm = "cool-warm",
        /// From dark blue to yellow, all but the lowest tenth (van der Walt and Smith's map).
        Viridis = "viridis",
        /// From black over red to pale yellow, all but the lowest tenth (Smith and van der Walt's map).
        Inferno = "inferno",
        /// A rainbow of even steps, all but the lowest tenth (Mikhailov's map).
        Turbo = "turbo",
    }
}

impl Preset {
    /// Are volumes lit by it, as bodies are? Else they glow.
    pub fn is_lit(self) -> bool {
        matches!(self, Self::Bone | Self::Skin | Self::Muscle)
    }

    /// The function, for a volume whose least and greatest value are given: what is made for CT becomes relative if they are not in
    /// Hounsfield units.
    pub fn function(self, range: [f64; 2]) -> TransferFunction {
        match self {
            Self::Bone => ct(self, &BONE, range),
            Self::Skin => ct(self, &SKIN, range),
            Self::Muscle => ct(self, &MUSCLE, range),
            Self::Fire => relative(self, &fire(), &FIRE_EXTINCTION),
            Self::CoolWarm => relative(self, &COOL_WARM, &[(0.0, 25.0), (0.45, 0.0), (0.55, 0.0), (1.0, 25.0)]),
            Self::Viridis => relative(self, &VIRIDIS, &[(0.1, 0.0), (1.0, 20.0)]),
            Self::Inferno => relative(self, &even(&INFERNO), &[(0.1, 0.0), (1.0, 20.0)]),
            Self::Turbo => relative(self, &even(&TURBO), &[(0.1, 0.0), (1.0, 20.0)]),
        }
    }
}

/// A value, its colour as sRGB.
type Color = (f64, [f64; 3]);
/// A value in Hounsfield units, its colour as sRGB, its extinction in a millimetre.
type Tissue = (f64, [f64; 3], f64);

/// Solid within 3 mm from 400 on; soft tissue at 40 lets 97 % through each centimetre.
const BONE: [Tissue; 7] = [
    (-200.0, [0.76, 0.45, 0.36], 0.0),
    (40.0, [0.76, 0.45, 0.36], 0.003),
    (120.0, [0.82, 0.55, 0.42], 0.006),
    (200.0, [0.88, 0.70, 0.54], 0.12),
    (400.0, [0.95, 0.89, 0.76], 1.2),
    (1000.0, [0.98, 0.96, 0.90], 2.0),
    (1500.0, [1.0, 1.0, 1.0], 2.5),
];

/// Skin is what is between air and fat, some millimetres that let half of the light through.
const SKIN: [Tissue; 9] = [
    (-550.0, [0.91, 0.72, 0.61], 0.0),
    (-200.0, [0.91, 0.72, 0.61], 0.28),
    (-50.0, [0.88, 0.60, 0.48], 0.06),
    (20.0, [0.80, 0.42, 0.35], 0.02),
    (100.0, [0.80, 0.42, 0.35], 0.02),
    (180.0, [0.90, 0.78, 0.64], 0.1),
    (300.0, [0.95, 0.89, 0.76], 1.2),
    (1000.0, [0.98, 0.96, 0.90], 2.0),
    (1500.0, [1.0, 1.0, 1.0], 2.5),
];

/// Muscle is at 10 to 60; fat is clear.
const MUSCLE: [Tissue; 7] = [
    (-30.0, [0.80, 0.52, 0.38], 0.0),
    (20.0, [0.62, 0.20, 0.16], 0.25),
    (60.0, [0.66, 0.22, 0.17], 0.6),
    (120.0, [0.72, 0.36, 0.28], 0.8),
    (250.0, [0.92, 0.82, 0.68], 1.2),
    (1000.0, [0.98, 0.96, 0.90], 2.0),
    (1500.0, [1.0, 1.0, 1.0], 2.5),
];

/// Where volumes without Hounsfield units are taken to have air and dense bone.
const UNITS: [f64; 2] = [-1000.0, 1500.0];
/// The longest side that they are taken to have, in millimetres.
const LONGEST_SIDE: f64 = 250.0;

/// Does the range of a volume look like Hounsfield units: is there something like air, and something like bone?
fn in_hounsfield_units([low, high]: [f64; 2]) -> bool {
    low <= -500.0 && high >= 500.0
}

fn ct(preset: Preset, tissues: &[Tissue], range: [f64; 2]) -> TransferFunction {
    let absolute = in_hounsfield_units(range);
    let value = |value: f64| if absolute { value } else { (value - UNITS[0]) / (UNITS[1] - UNITS[0]) };
    let length = if absolute { 1.0 } else { LONGEST_SIDE };
    let colors: Vec<_> = tissues.iter().map(|tissue| (value(tissue.0), tissue.1)).collect();
    let extinctions: Vec<_> = tissues.iter().map(|tissue| (value(tissue.0), tissue.2 * length)).collect();
    let scale = if absolute { Scale::Absolute } else { Scale::Relative };
    function(preset, &colors, &extinctions, scale)
}

fn relative(preset: Preset, colors: &[Color], extinctions: &[(f64, f64)]) -> TransferFunction {
    function(preset, colors, extinctions, Scale::Relative)
}

fn function(preset: Preset, colors: &[Color], extinctions: &[(f64, f64)], scale: Scale) -> TransferFunction {
    let colors: Vec<_> = colors.iter().map(|&(value, srgb)| (value, from_srgb(srgb).to_array())).collect();
    TransferFunction { name: preset.name().into(), points: joined(&colors, extinctions), values: scale, lengths: scale }
}

/// Temperatures: a value, how bright that is in linear light, and the colour of a black body as bytes of sRGB (Charity, "What color
/// is a blackbody?"), of 1000, 1500, 2000, 2500, 3000, 4000, 5000 and 6500 K.
const FIRE: [(f64, f64, [u8; 3]); 9] = [
    (0.0, 0.0, [255, 56, 0]),
    (0.15, 0.15, [255, 56, 0]),
    (0.3, 0.4, [255, 109, 0]),
    (0.4, 0.6, [255, 137, 18]),
    (0.5, 0.75, [255, 161, 72]),
    (0.6, 0.9, [255, 180, 107]),
    (0.75, 1.0, [255, 209, 163]),
    (0.9, 1.0, [255, 228, 206]),
    (1.0, 1.0, [255, 249, 253]),
];
const FIRE_EXTINCTION: [(f64, f64); 4] = [(0.05, 0.0), (0.3, 2.0), (0.6, 10.0), (1.0, 40.0)];

fn fire() -> Vec<Color> {
    // Dimmed in linear light: the curve is close to a power of 1 / 2.2.
    let dim = |brightness: f64, byte: u8| f64::from(byte) / 255.0 * libm::pow(brightness, 1.0 / 2.2);
    FIRE.iter().map(|&(value, brightness, bytes)| (value, bytes.map(|byte| dim(brightness, byte)))).collect()
}

/// Pieces that are linear in linear RGB, fitted to the 256 colours of the map: 0.8/255 at most from any of them as sRGB.
const VIRIDIS: [Color; 17] = [
    (0.0, [0.2676, 0.0018, 0.3289]),
    (12.0 / 255.0, [0.2813, 0.0704, 0.3970]),
    (28.0 / 255.0, [0.2837, 0.1528, 0.4711]),
    (49.0 / 255.0, [0.2575, 0.2531, 0.5296]),
    (82.0 / 255.0, [0.1929, 0.3924, 0.5583]),
    (121.0 / 255.0, [0.1333, 0.5381, 0.5564]),
    (144.0 / 255.0, [0.1176, 0.6254, 0.5351]),
    (158.0 / 255.0, [0.1471, 0.6764, 0.5072]),
    (170.0 / 255.0, [0.2050, 0.7186, 0.4734]),
    (181.0 / 255.0, [0.2785, 0.7553, 0.4328]),
    (193.0 / 255.0, [0.3748, 0.7920, 0.3779]),
    (205.0 / 255.0, [0.4840, 0.8243, 0.3116]),
    (218.0 / 255.0, [0.6133, 0.8532, 0.2270]),
    (231.0 / 255.0, [0.7494, 0.8753, 0.1402]),
    (240.0 / 255.0, [0.8452, 0.8874, 0.0967]),
    (247.0 / 255.0, [0.9159, 0.8961, 0.0977]),
    (1.0, [0.9930, 0.9061, 0.1409]),
];

/// As [`VIRIDIS`], of Moreland's map.
const COOL_WARM: [Color; 17] = [
    (0.0, [0.2281, 0.2962, 0.7534]),
    (15.0 / 255.0, [0.2971, 0.3975, 0.8403]),
    (33.0 / 255.0, [0.3866, 0.5143, 0.9234]),
    (53.0 / 255.0, [0.4923, 0.6326, 0.9820]),
    (72.0 / 255.0, [0.5959, 0.7278, 1.0000]),
    (91.0 / 255.0, [0.6978, 0.8015, 0.9876]),
    (112.0 / 255.0, [0.8000, 0.8529, 0.9323]),
    (129.0 / 255.0, [0.8735, 0.8653, 0.8570]),
    (151.0 / 255.0, [0.9458, 0.8041, 0.7271]),
    (171.0 / 255.0, [0.9709, 0.7165, 0.6035]),
    (190.0 / 255.0, [0.9617, 0.6097, 0.4865]),
    (207.0 / 255.0, [0.9256, 0.4966, 0.3863]),
    (223.0 / 255.0, [0.8703, 0.3763, 0.2984]),
    (237.0 / 255.0, [0.8061, 0.2573, 0.2284]),
    (249.0 / 255.0, [0.7411, 0.1234, 0.1744]),
    (252.0 / 255.0, [0.7232, 0.0660, 0.1632]),
    (1.0, [0.7057, 0.0151, 0.1501]),
];

/// Ten colours at even distances, as bytes of sRGB.
const INFERNO: [[u8; 3]; 10] = [
    [0, 0, 4],
    [27, 12, 66],
    [75, 12, 107],
    [120, 28, 109],
    [165, 44, 96],
    [207, 68, 70],
    [237, 105, 37],
    [251, 154, 6],
    [247, 208, 60],
    [252, 255, 164],
];

/// As [`INFERNO`].
const TURBO: [[u8; 3]; 10] = [
    [48, 18, 59],
    [70, 98, 215],
    [54, 170, 249],
    [26, 228, 182],
    [114, 254, 94],
    [199, 239, 52],
    [250, 186, 57],
    [246, 107, 25],
    [203, 42, 4],
    [122, 4, 3],
];

/// Colours at even distances, with others between them that are even as sRGB.
fn even(colors: &[[u8; 3]]) -> Vec<Color> {
    /// Parts between two colours.
    const PARTS: usize = 4;
    let last = (colors.len() - 1) * PARTS;
    let at = |i: usize| {
        let (from, part) = (i / PARTS, (i % PARTS) as f64 / PARTS as f64);
        let to = (from + 1).min(colors.len() - 1);
        let channel = |k: usize| f64::from(colors[from][k]) * (1.0 - part) + f64::from(colors[to][k]) * part;
        (i as f64 / last as f64, [0, 1, 2].map(|k| channel(k) / 255.0))
    };
    (0..=last).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::volume::TransferPoint;

    /// What a value looks like.
    fn at(points: &[TransferPoint], value: f64) -> TransferPoint {
        let next = points.partition_point(|point| point.value < value);
        let (Some(a), Some(&b)) = (next.checked_sub(1).map(|i| points[i]), points.get(next)) else {
            return points[next.min(points.len() - 1)];
        };
        let part = (value - a.value) / (b.value - a.value);
        let color = [0, 1, 2].map(|k| a.color[k] * (1.0 - part) as f32 + b.color[k] * part as f32);
        TransferPoint { value, color, extinction: a.extinction * (1.0 - part) + b.extinction * part }
    }

    fn srgb(linear: [f32; 3]) -> [f64; 3] {
        linear
            .map(|v| if v <= 0.003_130_8 { 12.92 * f64::from(v) } else { 1.055 * f64::from(v).powf(1.0 / 2.4) - 0.055 })
    }

    #[test]
    fn all_are_sound() {
        for preset in Preset::ALL {
            for range in [[-1024.0, 3071.0], [0.0, 255.0], [0.0, 0.0], [f64::MIN, f64::MAX]] {
                let TransferFunction { name, points, values, lengths } = preset.function(range);
                assert_eq!(
                    TransferFunction::new(name, points, values, lengths).map(|_| ()),
                    Ok(()),
                    "{preset} {range:?}"
                );
            }
        }
    }

    /// Entries of the published maps: their places of 255 and their colours.
    #[test]
    fn maps_are_those_that_are_published() {
        let viridis = [
            (0, [0.267004, 0.004874, 0.329415]),
            (13, [0.280894, 0.078907, 0.402329]),
            (40, [0.270595, 0.214069, 0.507052]),
            (64, [0.229739, 0.322361, 0.545706]),
            (100, [0.166617, 0.463708, 0.558119]),
            (128, [0.127568, 0.566949, 0.550556]),
            (150, [0.128087, 0.647749, 0.523491]),
            (191, [0.360741, 0.785964, 0.387814]),
            (230, [0.741388, 0.873449, 0.149561]),
            (250, [0.945636, 0.899815, 0.112838]),
            (255, [0.993248, 0.906157, 0.143936]),
        ];
        let cool_warm = [
            (0, [0.2298057, 0.29871797, 0.75368315]),
            (64, [0.55431187, 0.69009701, 0.99551555]),
            (128, [0.86742764, 0.8643766, 0.86260246]),
            (192, [0.95665321, 0.59803382, 0.47730229]),
            (255, [0.70567316, 0.01555616, 0.15023281]),
        ];
        for (preset, entries) in [(Preset::Viridis, &viridis[..]), (Preset::CoolWarm, &cool_warm[..])] {
            let points = preset.function([0.0, 1.0]).points;
            for &(place, published) in entries {
                let found = srgb(at(&points, f64::from(place) / 255.0).color);
                let most = (0..3).map(|k| (found[k] - published[k]).abs() * 255.0).fold(0.0, f64::max);
                assert!(most < 1.0, "{preset} {place}: {found:?} for {published:?}");
            }
        }
    }

    #[test]
    fn tissues_are_seen_as_they_should() {
        let through = |preset: Preset, value, millimetres: f64| {
            let function = preset.function([-1000.0, 2000.0]);
            assert_eq!((function.values, function.lengths), (Scale::Absolute, Scale::Absolute));
            (-at(&function.points, value).extinction * millimetres).exp()
        };
        for preset in [Preset::Bone, Preset::Skin, Preset::Muscle] {
            assert!(through(preset, 400.0, 3.0) < 0.05, "{preset}: bone is solid");
            assert_eq!(through(preset, -1000.0, 1000.0), 1.0, "{preset}: air is clear");
        }
        assert!(through(Preset::Bone, 40.0, 10.0) > 0.95);
        assert!((0.4..0.7).contains(&through(Preset::Skin, -200.0, 3.0)));
        assert!(through(Preset::Skin, 40.0, 10.0) > 0.8);
        assert!(through(Preset::Muscle, 50.0, 5.0) < 0.1);
    }

    #[test]
    fn without_hounsfield_units_they_are_relative() {
        for range in [[0.0, 4095.0], [-1000.0, 400.0], [0.0, 1.0]] {
            let function = Preset::Bone.function(range);
            assert_eq!((function.values, function.lengths), (Scale::Relative, Scale::Relative));
            let [low, high] = range;
            // What 400 becomes of -1000 to 1500: solid within 3 mm of 250.
            let points = function.resolve(range, 1.0);
            let bone = at(&points, low + 0.56 * (high - low));
            assert!((bone.extinction - 1.2 * 250.0).abs() < 1e-6, "{bone:?}");
        }
    }

    #[test]
    fn relative_functions_leave_out_what_they_say() {
        let extinction = |preset: Preset, value| at(&preset.function([0.0, 1.0]).points, value).extinction;
        for (preset, value) in [(Preset::Viridis, 0.1), (Preset::CoolWarm, 0.5), (Preset::Fire, 0.05)] {
            assert_eq!(extinction(preset, value), 0.0);
            assert!(extinction(preset, value + 0.2) > 0.0);
        }
        let rising = (0..100).map(|i| f64::from(i) / 100.0);
        assert!(
            rising.into_iter().all(|value| extinction(Preset::Fire, value + 0.01) >= extinction(Preset::Fire, value))
        );
        assert_eq!(extinction(Preset::CoolWarm, 0.2), extinction(Preset::CoolWarm, 0.8));
    }
}
