//! The backgrounds that there are, by name.

use std::sync::Arc;

use glam::Vec3;

use super::{Constant, Daylight, Gradient};
use crate::choice::choice;
use crate::color;
use crate::stack::Background;

choice! {
    /// A background.
    "background" BackgroundKind -> Background {
        /// A pale sky over a warm floor.
        Sky = "sky" => Gradient::default(),
        /// A clear sky with the sun, which light the scene.
        Daylight = "daylight" => Daylight::default(),
        /// Nothing.
        Black = "black" => Constant { color: Vec3::ZERO },
        /// Paper.
        White = "white" => Constant { color: Vec3::ONE },
    }
}

/// A background in words: the name of a kind, a [colour](color::parse), or `daylight:` with the elevation of the sun, perhaps its azimuth,
/// and perhaps the turbidity.
pub fn parse(text: &str) -> Option<Arc<dyn Background>> {
    match (text.parse::<BackgroundKind>(), text.split_once(':')) {
        (Ok(kind), _) => Some(kind.build()),
        (Err(_), Some((kind, numbers))) if kind.parse() == Ok(BackgroundKind::Daylight) => {
            daylight(numbers).map(|sky| Arc::new(sky) as _)
        }
        (Err(_), _) => color::parse(text).map(|color| Arc::new(Constant { color }) as _),
    }
}

fn daylight(numbers: &str) -> Option<Daylight> {
    let numbers: Option<Vec<f32>> = numbers.split(',').map(|number| number.trim().parse().ok()).collect();
    let [_, azimuth, turbidity] = Daylight::default().parameters();
    let (elevation, azimuth, turbidity) = match numbers?[..] {
        [elevation] => (elevation, azimuth, turbidity),
        [elevation, azimuth] => (elevation, azimuth, turbidity),
        [elevation, azimuth, turbidity] => (elevation, azimuth, turbidity),
        _ => (f32::NAN, azimuth, turbidity),
    };
    let sound = Daylight::ELEVATIONS.contains(&elevation) && azimuth.is_finite();
    (sound && Daylight::TURBIDITIES.contains(&turbidity)).then(|| Daylight::new(elevation, azimuth, turbidity))
}
