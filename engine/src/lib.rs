//! The engine.
// pub mod stack;
