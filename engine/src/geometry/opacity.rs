//! How opaque particles are: all alike, or as the values of an attribute say.

/// How opaque particles are.
#[derive(Clone, Debug, PartialEq)]
pub enum Opacity {
    /// All alike: the fraction of the light that each stops, 0 to 1.
    All(f32),
    /// As an attribute says.
    By {
        /// Its name; where there is none, no particle is shown.
        attribute: String,
        /// The opacities of its values.
        curve: OpacityCurve,
    },
}

/// Opacities of values: straight from point to point, and beyond the first and the last as there. What is NaN has none.
#[derive(Clone, Debug, PartialEq)]
pub struct OpacityCurve {
    /// Values, which do not fall, and their opacities; at least one.
    points: Vec<[f32; 2]>,
}

/// Points are no opacities of values. They are counted from 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum OpacityError {
    /// There is none.
    #[error("there is no point")]
    Empty,
    /// A value is infinite or NaN.
    #[error("the value of point {0} is not finite")]
    Value(usize),
    /// A value is below the one before.
    #[error("the value of point {0} is below the one before")]
    Order(usize),
    /// An opacity is out of range or NaN.
    #[error("the opacity of point {0} is not from 0 to 1")]
    Opacity(usize),
}

impl Opacity {
    /// May anything be seen through any particle?
    pub fn is_translucent(&self) -> bool {
        match self {
            Self::All(opacity) => *opacity < 1.0,
            Self::By { curve, .. } => curve.points.iter().any(|[_, opacity]| *opacity < 1.0),
        }
    }
}

impl OpacityCurve {
    /// Through these points, each a value and its opacity. Of points of one value the first ends what is below it, and the last begins
    /// what is from it on.
    ///
    /// # Errors
    /// If there are none, values fall or are not finite, or opacities are not from 0 to 1.
    pub fn new(points: Vec<[f32; 2]>) -> Result<Self, OpacityError> {
        if points.is_empty() {
            return Err(OpacityError::Empty);
        }
        let mut least = f32::NEG_INFINITY;
        for (number, &[value, opacity]) in (1..).zip(&points) {
            if !value.is_finite() {
                return Err(OpacityError::Value(number));
            }
            if value < least {
                return Err(OpacityError::Order(number));
            }
            if !(0.0..=1.0).contains(&opacity) {
                return Err(OpacityError::Opacity(number));
            }
            least = value;
        }
        Ok(Self { points })
    }

    /// From 0 for the first value to 1 for the second, which is not less.
    pub fn rising([low, high]: [f32; 2]) -> Self {
        Self { points: vec![[low, 0.0], [high, 1.0]] }
    }

    /// With all opacities multiplied by a factor from 0 to 1.
    pub fn scaled(&self, factor: f32) -> Self {
        Self { points: self.points.iter().map(|[value, opacity]| [*value, opacity * factor]).collect() }
    }

    /// The points.
    pub fn points(&self) -> &[[f32; 2]] {
        &self.points
    }

    /// The opacity of a value.
    #[inline]
    pub fn opacity(&self, value: f32) -> f32 {
        if value.is_nan() {
            return 0.0;
        }
        let next = self.points.partition_point(|[known, _]| *known <= value);
        let (Some(&[from, low]), Some(&[to, high])) =
            (next.checked_sub(1).and_then(|before| self.points.get(before)), self.points.get(next))
        else {
            return self.points.get(next).or(self.points.last()).map_or(0.0, |[_, opacity]| *opacity);
        };
        // Halved, so that the difference of two values is finite.
        let part = (value * 0.5 - from * 0.5) / (to * 0.5 - from * 0.5);
        (low + (high - low) * part).clamp(0.0, 1.0)
    }

    /// The values that are not wholly transparent, from least to greatest, with ends that may be.
    pub fn visible(&self) -> Vec<[f32; 2]> {
        let (Some(&[_, first]), Some(&[_, last])) = (self.points.first(), self.points.last()) else {
            return Vec::new();
        };
        let all = [&[[f32::NEG_INFINITY, first]], &self.points[..], &[[f32::INFINITY, last]]].concat();
        let mut ranges: Vec<[f32; 2]> = Vec::new();
        for pair in all.windows(2).filter(|pair| pair[0][1] > 0.0 || pair[1][1] > 0.0) {
            let [from, to] = [pair[0][0], pair[1][0]];
            match ranges.last_mut().filter(|before| before[1] == from) {
                Some(before) => before[1] = to,
                None => ranges.push([from, to]),
            }
        }
        ranges
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[[f32; 2]]) -> OpacityCurve {
        OpacityCurve::new(points.to_vec()).unwrap()
    }

    #[test]
    fn opacities_are_straight_between_points() {
        let ramp = curve(&[[1.0, 0.25], [3.0, 0.75], [3.0, 0.0], [4.0, 1.0]]);
        for (value, expected) in [
            (f32::NEG_INFINITY, 0.25),
            (1.0, 0.25),
            (2.0, 0.5),
            (3.0, 0.0),
            (3.5, 0.5),
            (4.0, 1.0),
            (f32::INFINITY, 1.0),
            (f32::NAN, 0.0),
        ] {
            assert_eq!(ramp.opacity(value), expected, "{value}");
        }
        assert_eq!(ramp.scaled(0.5).opacity(2.0), 0.25);
        assert_eq!(curve(&[[-f32::MAX, 0.0], [f32::MAX, 1.0]]).opacity(0.0), 0.5);
        // Opaque means it, whatever rounding does.
        let opaque = curve(&[[0.0, 1.0], [0.3, 1.0]]);
        assert!((0..100).all(|i| opaque.opacity(0.003 * i as f32) == 1.0));
    }

    #[test]
    fn what_is_wholly_transparent_is_not_visible() {
        let all = [f32::NEG_INFINITY, f32::INFINITY];
        assert_eq!(curve(&[[0.0, 1.0], [1.0, 0.5]]).visible(), [all]);
        assert_eq!(curve(&[[0.0, 0.0]]).visible(), [[0.0; 2]; 0]);
        let hills = curve(&[[0.0, 0.0], [1.0, 0.5], [2.0, 0.0], [3.0, 0.0], [3.0, 1.0], [4.0, 1.0], [4.0, 0.0]]);
        assert_eq!(hills.visible(), [[0.0, 2.0], [3.0, 4.0]]);
        assert_eq!(curve(&[[0.0, 0.0], [1.0, 1.0]]).visible(), [[0.0, f32::INFINITY]]);
    }

    #[test]
    fn what_is_no_opacity_is_refused() {
        for (points, error) in [
            (&[][..], OpacityError::Empty),
            (&[[0.0, 0.5], [f32::NAN, 0.5]], OpacityError::Value(2)),
            (&[[f32::INFINITY, 0.5]], OpacityError::Value(1)),
            (&[[1.0, 0.5], [0.0, 0.5]], OpacityError::Order(2)),
            (&[[1.0, 1.5]], OpacityError::Opacity(1)),
            (&[[1.0, -0.1]], OpacityError::Opacity(1)),
            (&[[1.0, f32::NAN]], OpacityError::Opacity(1)),
        ] {
            assert_eq!(OpacityCurve::new(points.to_vec()), Err(error), "{points:?}");
        }
    }
}
