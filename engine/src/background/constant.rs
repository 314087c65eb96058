//! The same colour everywhere.

use glam::Vec3;

use crate::packet::SubPacket;
use crate::stack::{Background, Context};

/// The same colour everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Constant {
    /// The colour, linear RGB.
    pub color: Vec3,
}

impl Background for Constant {
    fn shade(&self, _context: &Context<'_>, misses: &mut SubPacket<'_>) {
        misses.fill_color(self.color);
    }
}
