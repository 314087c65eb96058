//! The engine.
pub mod balance;
pub mod image;
pub mod pipeline;
pub mod traverse;
