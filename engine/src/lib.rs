//! The engine of Mobula: a parallel pipeline around a rendering stack of interchangeable components, after Bigler, Stephens
//! and Parker, "Design for Parallel Interactive Ray Tracing Systems" (2006). The crate's binary is the `mobula` command.
//!
//! | paper | module |
//! |---|---|
//! | 5.2 the pipeline, its barrier and stages | [`pipeline`], [`display`], [`image`] |
//! | 5.3 transactions and callbacks | [`pipeline`] |
//! | 5.4 the rendering stack | [`stack`] has the traits; [`traverse`], [`balance`], [`sampler`], [`camera`], [`renderer`], [`accel`], [`material`], [`light`], [`background`] the components |
//! | what is rendered | [`scene`], [`load`], [`generate`], [`builtin`] |
//! | all of it behind one call, or taken apart | [`app`], [`prelude`] |
//!
//! Ray packets and kernels are [`mobula_core`]'s, lanes and levels [`mobula_simd`]'s. A whole frame:
//!
//! ```
//! use mobula::app::{self, Settings};
//! use mobula::image::Size;
//!
//! let settings = Settings { size: Size::new(40, 30)?, threads: 2, ..Settings::default() };
//! let mut pipeline = app::pipeline(&mobula::builtin::scene(), &settings)?;
//! pipeline.run(1)?;
//! let (_, picture) = pipeline.picture(0).unwrap();
//! assert_eq!(picture.to_rgba8().len(), 40 * 30 * 4);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod accel;
pub mod app;
pub mod background;
pub mod balance;
pub mod builtin;
pub mod camera;
pub mod choice;
pub mod color;
pub mod display;
pub mod generate;
pub mod geometry;
pub mod image;
#[cfg(feature = "kernels")]
pub mod kernels;
pub mod light;
pub mod load;
pub mod material;
pub mod math;
pub mod packet;
pub mod pipeline;
pub mod prelude;
pub mod renderer;
pub mod sampler;
pub mod scale;
pub mod scene;
mod scratch;
pub mod shading;
pub mod stack;
pub mod traverse;
pub mod view;
