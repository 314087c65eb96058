//! A clear sky with the sun: A. J. Preetham, Peter Shirley and Brian Smits, "A Practical Analytic Model for Daylight", SIGGRAPH 1999.

use std::sync::{Arc, OnceLock};

use glam::Vec3;

use crate::light::{Environment, Hemisphere, Sun, direction, luminance};
use crate::math::normalize;
use crate::packet::{SubPacket, set_vec3, vec3};
use crate::stack::{Background, Context, SkyLight};
use crate::view::Up;

/// A clear sky with the sun and a grey ground, which light the scene. So bright that a white surface is about as bright as white can be,
/// where it is level under a high sun, or faces a low one half.
#[derive(Clone, Debug)]
pub struct Daylight {
    elevation: f32,
    azimuth: f32,
    turbidity: f32,
    /// Towards the sun, with y up and north at negative z.
    sun: Vec3,
    /// What a white surface across its light scatters of that.
    sunlight: Vec3,
    /// The colour of the sky at the zenith (luminance, and chromaticity x and y), over what the five numbers of Perez say there.
    zenith: [f64; 3],
    /// Those of luminance and of chromaticity.
    perez: [[f64; 5]; 3],
    /// Below the horizon.
    ground: Vec3,
    /// Its light, once it was asked for.
    light: OnceLock<Option<Environment>>,
}

/// The part of the light that the ground scatters.
const ALBEDO: f32 = 0.3;
/// Columns and rows of the table by which the sky lights: the rows of its upper half are as high as the sun.
const TABLE: [usize; 2] = [512, 256];
/// The sun is seen no brighter than this: what is sharpened beside it would be black, and what mirrors a little of it all white.
const BRIGHTEST: f32 = 100.0;
/// Within this height below the horizon the sky becomes the ground.
const HAZE: f32 = 0.03;
/// The illuminance of the sun outside of the air, in kilolux.
const SUN: f64 = 128.0;
/// Red, green and blue, as wavelengths in micrometres.
const WAVES: [f64; 3] = [0.610, 0.550, 0.465];

impl Default for Daylight {
    /// A clear morning or afternoon, with the sun to the left, on the side of the usual view.
    fn default() -> Self {
        Self::new(45.0, 215.0, 3.0)
    }
}

impl Daylight {
    /// The elevations of the sun that there are: degrees.
    pub const ELEVATIONS: std::ops::RangeInclusive<f32> = 0.0..=90.0;
    /// How hazy the air may be: from clear to hazy.
    pub const TURBIDITIES: std::ops::RangeInclusive<f32> = 1.8..=10.0;

    /// With the sun at this elevation and azimuth (clockwise from north, which is negative z where y is up, and y where z is), in degrees; and
    /// of this turbidity. Limited to what there is; a NaN is the least.
    pub fn new(elevation: f32, azimuth: f32, turbidity: f32) -> Self {
        let within = |x: f32, range: std::ops::RangeInclusive<f32>| {
            if x > *range.start() { x.min(*range.end()) } else { *range.start() }
        };
        let (elevation, turbidity) = (within(elevation, Self::ELEVATIONS), within(turbidity, Self::TURBIDITIES));
        let azimuth = if azimuth.is_finite() { azimuth % 360.0 } else { 0.0 };
        let (height, turn) = (elevation.to_radians(), azimuth.to_radians());
        let (level, rise) = (libm::cosf(height), libm::sinf(height));
        let sun = Vec3::new(level * libm::sinf(turn), rise, -level * libm::cosf(turn));
        let t = f64::from(turbidity);
        let theta = f64::from(90.0 - elevation).to_radians();
        let perez = coefficients(t);
        let mut zenith = zenith(t, theta);
        for (zenith, c) in zenith.iter_mut().zip(&perez) {
            *zenith /= relative(c, 1.0, theta, libm::cos(theta));
        }
        let mut sky = Self {
            elevation,
            azimuth,
            turbidity,
            sun,
            sunlight: Vec3::ZERO,
            zenith,
            perez,
            ground: Vec3::ZERO,
            light: OnceLock::new(),
        };
        // In kilocandela per square metre; then over what a white surface sends out.
        let sunlight = transmitted(t, f64::from(elevation)).map(|part| (part * SUN / std::f64::consts::PI) as f32);
        let of_sky = sky.scattered();
        let facing = Vec3::from(sunlight) * rise.max(std::f32::consts::FRAC_1_SQRT_2) + of_sky;
        let scale = 1.0 / luminance(facing);
        sky.zenith[0] *= f64::from(scale);
        sky.sunlight = Vec3::from(sunlight) * scale;
        sky.ground = (sky.sunlight * rise + of_sky * scale) * ALBEDO;
        sky
    }

    /// Elevation and azimuth of the sun, in degrees, and turbidity: what it was made of.
    pub fn parameters(&self) -> [f32; 3] {
        [self.elevation, self.azimuth, self.turbidity]
    }

    /// The radiance of the sky in a direction of unit length, with y up, at the horizon or above; linear RGB.
    pub fn sky(&self, direction: Vec3) -> Vec3 {
        let height = f64::from(direction.y.max(0.01));
        let cosine = f64::from(direction.dot(self.sun).clamp(-1.0, 1.0));
        let gamma = libm::acos(cosine);
        let value = |i: usize| self.zenith[i] * relative(&self.perez[i], height, gamma, cosine);
        to_rgb([value(0), value(1), value(2)])
    }

    /// What a white, level surface scatters of the light of the sky, without the sun.
    fn scattered(&self) -> Vec3 {
        let [columns, rows] = [64, 16];
        let mut sum = Vec3::ZERO;
        for row in 0..rows {
            // As much of the hemisphere, by the cosine, in each row.
            let y = ((row as f32 + 0.5) / rows as f32).sqrt();
            let across = (1.0 - y * y).sqrt();
            for column in 0..columns {
                let angle = std::f32::consts::TAU * (column as f32 + 0.5) / columns as f32;
                sum += self.sky(Vec3::new(across * libm::sinf(angle), y, across * libm::cosf(angle)));
            }
        }
        sum / (columns * rows) as f32
    }

    /// What is seen in a direction of any length, with y up.
    fn at(&self, direction: Vec3) -> Vec3 {
        let direction = normalize(direction);
        if direction.y < -HAZE {
            return self.ground;
        }
        let sky = self.sky(direction);
        if direction.y < 0.0 {
            let part = -direction.y / HAZE;
            return sky + (self.ground - sky) * (part * part * (3.0 - 2.0 * part));
        }
        let half = libm::sinf((Sun::ANGLE * 0.25).to_radians());
        let within = 1.0 - direction.dot(self.sun) <= 2.0 * half * half;
        if within { sky + self.disk() } else { sky }
    }

    /// The radiance of the sun's disk, as far as it is shown.
    fn disk(&self) -> Vec3 {
        let sine = libm::sinf((Sun::ANGLE * 0.5).to_radians());
        let disk = self.sunlight / (sine * sine);
        disk * (BRIGHTEST / disk.max_element().max(BRIGHTEST))
    }

    /// The table by which the sky lights: without the ground, whose light needs no samples.
    fn table(&self) -> Vec<Vec3> {
        let [columns, rows] = TABLE;
        let texel = |i: usize| {
            let (column, row) = (i % columns, i / columns);
            let way = direction((column as f32 + 0.5) / columns as f32, (row as f32 + 0.5) / rows as f32);
            if way.y > 0.0 { self.sky(way) } else { Vec3::ZERO }
        };
        (0..columns * rows).map(texel).collect()
    }
}

impl Background for Daylight {
    fn shade(&self, context: &Context<'_>, misses: &mut SubPacket<'_>) {
        let up = context.scene.up;
        let count = misses.len();
        let (directions, mut colors) = misses.directions_and_colors();
        for i in 0..count {
            set_vec3(&mut colors, i, self.at(up.to_y_up(vec3(&directions, i))));
        }
    }

    /// The sky by a table, the sun, and the ground as what surfaces get that face down.
    fn light(&self, up: Up) -> Option<SkyLight> {
        let sun = Sun { direction: up.from_y_up(self.sun), color: self.sunlight, angle: Sun::ANGLE };
        let sky = self.light.get_or_init(|| Environment::new(TABLE[0], &self.table())).clone()?;
        let ambient = Hemisphere { above: Vec3::ZERO, below: self.ground };
        Some(SkyLight { lights: vec![Arc::new(sun), Arc::new(sky)], ambient: Arc::new(ambient) })
    }
}

/// The five numbers of Perez for luminance and chromaticity (appendix A.2).
fn coefficients(t: f64) -> [[f64; 5]; 3] {
    [
        [0.1787 * t - 1.4630, -0.3554 * t + 0.4275, -0.0227 * t + 5.3251, 0.1206 * t - 2.5771, -0.0670 * t + 0.3703],
        [-0.0193 * t - 0.2592, -0.0665 * t + 0.0008, -0.0004 * t + 0.2125, -0.0641 * t - 0.8989, -0.0033 * t + 0.0452],
        [-0.0167 * t - 0.2608, -0.0950 * t + 0.0092, -0.0079 * t + 0.2102, -0.0441 * t - 1.6537, -0.0109 * t + 0.0529],
    ]
}

/// Luminance (in kilocandela per square metre) and chromaticity of the zenith, for the angle of the sun from there (appendix A.2).
fn zenith(t: f64, theta: f64) -> [f64; 3] {
    let chi = (4.0 / 9.0 - t / 120.0) * (std::f64::consts::PI - 2.0 * theta);
    let luminance = (4.0453 * t - 4.9710) * libm::tan(chi) - 0.2155 * t + 2.4192;
    let cubic = |c: [f64; 4]| ((c[0] * theta + c[1]) * theta + c[2]) * theta + c[3];
    let chromaticity = |rows: [[f64; 4]; 3]| {
        let [a, b, c] = rows.map(cubic);
        (a * t + b) * t + c
    };
    let x = chromaticity([
        [0.001_66, -0.003_75, 0.002_09, 0.0],
        [-0.029_03, 0.063_77, -0.032_02, 0.003_94],
        [0.116_93, -0.211_96, 0.060_52, 0.258_86],
    ]);
    let y = chromaticity([
        [0.002_75, -0.006_10, 0.003_17, 0.0],
        [-0.042_14, 0.089_70, -0.041_53, 0.005_16],
        [0.153_46, -0.267_56, 0.066_70, 0.266_88],
    ]);
    [luminance.max(0.01), x, y]
}

/// The formula of Perez, for the cosine of the angle from the zenith, and the angle from the sun with its cosine.
fn relative(&[a, b, c, d, e]: &[f64; 5], height: f64, gamma: f64, cosine: f64) -> f64 {
    (1.0 + a * libm::exp(b / height)) * (1.0 + c * libm::exp(d * gamma) + e * cosine * cosine)
}

/// Linear RGB (ITU-R BT.709) of a luminance and a chromaticity.
fn to_rgb([luminance, x, y]: [f64; 3]) -> Vec3 {
    let (big_x, big_z) = (luminance * x / y, luminance * (1.0 - x - y) / y);
    let red = 3.2406 * big_x - 1.5372 * luminance - 0.4986 * big_z;
    let green = -0.9689 * big_x + 1.8758 * luminance + 0.0415 * big_z;
    let blue = 0.0557 * big_x - 0.2040 * luminance + 1.0570 * big_z;
    Vec3::new(red as f32, green as f32, blue as f32).max(Vec3::ZERO)
}

/// The part of the sun's light that comes through the air, for red, green and blue: scattered by molecules (Rayleigh) and by dust (Angstrom,
/// appendix A.1; ozone and water, which change less, are left out), along the relative air mass of Kasten 1965.
fn transmitted(t: f64, elevation: f64) -> [f64; 3] {
    let mass = 1.0 / (libm::sin(elevation.to_radians()) + 0.15 * libm::pow(3.885 + elevation, -1.253));
    let beta = 0.046_08 * t - 0.045_86;
    WAVES.map(|wave| {
        let molecules = 0.008_735 * libm::pow(wave, -4.08);
        let dust = beta * libm::pow(wave, -1.3);
        libm::exp(-(molecules + dust) * mass)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_white_surface_in_full_daylight_is_white() {
        for elevation in [45.0, 60.0, 90.0] {
            let sky = Daylight::new(elevation, 0.0, 3.0);
            let level = sky.sunlight * sky.sun.y + sky.scattered();
            assert!((luminance(level) - 1.0).abs() < 1e-3, "{elevation}: {level}");
        }
        for (elevation, least) in [(0.0, 0.0), (5.0, 0.05), (20.0, 0.4)] {
            let sky = Daylight::new(elevation, 0.0, 3.0);
            let level = luminance(sky.sunlight * sky.sun.y + sky.scattered());
            assert!(level > least && level <= 1.0, "{elevation}: {level}");
        }
    }

    #[test]
    fn the_table_lights_as_much_as_the_sky() {
        let sky = Daylight::default();
        let [columns, rows] = TABLE;
        let mut sum = Vec3::ZERO;
        for (i, color) in sky.table().into_iter().enumerate() {
            let height = |row: usize| libm::cosf(std::f32::consts::PI * row as f32 / rows as f32);
            let (above, below) = (height(i / columns), height(i / columns + 1));
            // Over pi: the cosine times the solid angle, of the texel.
            sum += color * ((above * above - below * below) / columns as f32);
        }
        let expected = sky.scattered();
        assert!(((sum - expected) / expected).abs().max_element() < 0.01, "{sum} for {expected}");
    }

    #[test]
    fn skies_of_all_parameters_are_finite_and_look_like_skies() {
        for elevation in [0.0, 1.0, 20.0, 45.0, 89.9, 90.0, f32::NAN] {
            for turbidity in [1.8, 3.0, 6.0, 10.0, f32::INFINITY] {
                let sky = Daylight::new(elevation, 77.0, turbidity);
                for i in 0..500 {
                    let way = direction((i % 25) as f32 / 25.0, i as f32 / 500.0);
                    let color = sky.at(way);
                    assert!(color.is_finite() && color.min_element() >= 0.0, "{sky:?} at {way}: {color}");
                }
            }
        }
        let sky = Daylight::default();
        let (zenith, away) = (sky.sky(Vec3::Y), sky.sky(normalize(Vec3::new(-sky.sun.x, 0.6, -sky.sun.z))));
        assert!(zenith.z > zenith.y && zenith.y > zenith.x, "the zenith is blue: {zenith}");
        assert!(away.z > away.x, "and so is the rest: {away}");
        let near = sky.sky(normalize(sky.sun + Vec3::Y * 0.1));
        assert!(luminance(near) > 3.0 * luminance(zenith), "bright around the sun: {near}");
        let low = Daylight::new(5.0, 0.0, 3.0).sunlight;
        assert!(low.x > 1.5 * low.z, "a low sun is reddish: {low}");
        assert!(sky.at(sky.sun).max_element() > 50.0 && sky.at(Vec3::NEG_Y) == sky.ground);
    }
}
