//! The engine.
pub mod camera;
pub mod scene;
// pub mod stack;
