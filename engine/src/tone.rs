//! From the light that arrives to what a screen can show: exposure, and a curve for what is too bright.

use glam::Vec3;
use mobula_core::simd::{F32Lanes, Scalar, Token};

use crate::choice::choice;
use crate::lanes::{add, scale, select3};

choice! {
    /// What becomes of light that is brighter than a screen.
    "tone curve" Curve {
        /// It is cut off: colours are what they are, and white where they are too bright.
        Linear = "linear",
        /// What is below 0.8 stays as it is; from there on it approaches white, without a change of hue at first (as the PBR Neutral tone
        /// mapper of Khronos, 2024, without its correction of dark colours).
        Neutral = "neutral",
        /// The curve of film: more contrast, soft ends (Narkowicz's fit to the reference transform of ACES, 2016).
        Filmic = "filmic",
    }
}

/// How light becomes colours of a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tone {
    /// What becomes of what is too bright.
    pub curve: Curve,
    /// What light is multiplied with before, as a power of 2.
    pub exposure: f32,
}

impl Default for Tone {
    /// Light as it is.
    fn default() -> Self {
        Self { curve: Curve::Linear, exposure: 0.0 }
    }
}

/// Where [`Curve::Neutral`] begins to bend.
const SHOULDER: f32 = 0.8;
/// How fast it loses colour.
const FADING: f32 = 0.15;

impl Tone {
    /// The most exposure, either way.
    pub const MOST_EXPOSURE: f32 = 32.0;

    /// Colours of a screen for light, linear both; the same bits at every level.
    #[inline(always)]
    pub(crate) fn map<T: Token>(self, token: T, light: [T::F32; 3]) -> [T::F32; 3] {
        let light = if self.exposure == 0.0 { light } else { scale(light, token.splat(libm::exp2f(self.exposure))) };
        match self.curve {
            Curve::Linear => light,
            Curve::Neutral => neutral(token, light),
            Curve::Filmic => [filmic(token, light[0]), filmic(token, light[1]), filmic(token, light[2])],
        }
    }

    /// The colour of a screen for one light.
    pub fn of(self, light: Vec3) -> Vec3 {
        let token = Scalar::new();
        let mapped = self.map(token, light.to_array().map(|channel| token.splat(channel)));
        let mut out = [[0.0]; 3];
        for (out, channel) in out.iter_mut().zip(mapped) {
            channel.store(out, 0);
        }
        Vec3::from(out.map(|[channel]| channel))
    }
}

#[inline(always)]
fn neutral<T: Token>(token: T, light: [T::F32; 3]) -> [T::F32; 3] {
    let one = token.splat(1.0);
    // What is brighter than this is white in any case, and must not overflow.
    let most = token.splat(1e6);
    let light = [light[0].min(most), light[1].min(most), light[2].min(most)];
    let peak = light[0].max(light[1]).max(light[2]);
    let bend = token.splat(1.0 - SHOULDER);
    let new_peak = one - bend * bend / (peak + bend - token.splat(SHOULDER));
    let kept = one / ((peak - new_peak) * token.splat(FADING) + one);
    let dimmed = scale(light, new_peak / peak * kept);
    let grey = new_peak * (one - kept);
    let bent = add(dimmed, [grey; 3]);
    let bends = peak.gt(token.splat(SHOULDER));
    select3(bends, bent, light)
}

#[inline(always)]
fn filmic<T: Token>(token: T, light: T::F32) -> T::F32 {
    let x = light.max(token.splat(0.0)).min(token.splat(1e6));
    let above = x * (x * token.splat(2.51) + token.splat(0.03));
    let below = x * (x * token.splat(2.43) + token.splat(0.59)) + token.splat(0.14);
    above / below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neutral_leaves_what_a_screen_can_show_and_keeps_the_order_of_the_rest() {
        let tone = Tone { curve: Curve::Neutral, exposure: 0.0 };
        for dim in [Vec3::ZERO, Vec3::new(0.1, 0.8, 0.3), Vec3::splat(0.8)] {
            assert_eq!(tone.of(dim), dim);
        }
        let mut before = Vec3::splat(0.8);
        for step in 1..200 {
            let found = tone.of(Vec3::splat(0.8 + 0.1 * step as f32));
            assert!(found.cmpgt(before).all() && found.cmplt(Vec3::ONE).all(), "{found}");
            before = found;
        }
        let red = tone.of(Vec3::new(4.0, 1.0, 1.0));
        assert!(red.x < 1.0 && red.y > 0.25 * red.x && red.y < red.x, "a little paler: {red}");
        assert_eq!(tone.of(Vec3::splat(f32::INFINITY)).map(|x| (x * 255.0).round()), Vec3::splat(255.0));
    }

    #[test]
    fn filmic_goes_from_black_to_white_and_exposure_doubles() {
        let tone = Tone { curve: Curve::Filmic, exposure: 0.0 };
        assert_eq!(tone.of(Vec3::ZERO), Vec3::ZERO);
        let [low, middle, high] = [0.18, 0.5, 4.0].map(|x| tone.of(Vec3::splat(x)).x);
        assert!(low > 0.2 && low < middle && middle < high && high > 0.9, "{low} {middle} {high}");
        let brighter = Tone { curve: Curve::Linear, exposure: 2.0 };
        assert_eq!(brighter.of(Vec3::new(0.1, 0.2, 0.0)), Vec3::new(0.4, 0.8, 0.0));
    }
}
