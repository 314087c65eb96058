//! The engine.
pub mod balance;
pub mod camera;
pub mod generate;
pub mod image;
pub mod load;
pub mod pipeline;
pub mod scene;
pub mod traverse;
// pub mod stack;
