//! What a program with components of its own names: `use mobula::prelude::*;`. The page of [`app`](crate::app) has one that
//! gets by without.

pub use std::sync::Arc;

pub use glam::Vec3;
pub use mobula_core::simd::AnyToken;

pub use crate::app::Components;
pub use crate::image::Size;
pub use crate::packet::{Packet, SubPacket, set_vec3, vec3};
pub use crate::pipeline::{Config, Display, DisplayStage, Handle, Picture, Pipeline, Shown, display};
pub use crate::scene::{Scene, SceneDescription};
pub use crate::stack::{Background, Camera, Context, Light, Lit, Material, PixelSampler, Renderer};
