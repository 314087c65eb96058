//! The engine.
pub mod camera;
pub mod generate;
pub mod load;
pub mod scene;
// pub mod stack;
