//! The backgrounds that there are, by name.

use std::sync::Arc;

use glam::Vec3;

use super::{Constant, Gradient};
use crate::choice::choice;
use crate::color;
use crate::stack::Background;

choice! {
    /// A background.
    "background" BackgroundKind -> Background {
        /// A pale sky over a warm floor.
        Sky = "sky" => Gradient::default(),
        /// Nothing.
        Black = "black" => Constant { color: Vec3::ZERO },
        /// Paper.
        White = "white" => Constant { color: Vec3::ONE },
    }
}

/// A background in words: the name of a kind, or a [colour](color::parse).
pub fn parse(text: &str) -> Option<Arc<dyn Background>> {
    match text.parse::<BackgroundKind>() {
        Ok(kind) => Some(kind.build()),
        Err(_) => color::parse(text).map(|color| Arc::new(Constant { color }) as _),
    }
}
