//! The engine of Mobula: a parallel pipeline around a rendering stack of interchangeable components, after Bigler, Stephens
//! and Parker, "Design for Parallel Interactive Ray Tracing Systems" (2006). The crate's binary is the `mobula` command.
//!
//! The paper's section 5.2 and 5.3 (the pipeline, its barrier and stages, transactions and callbacks) are in [`pipeline`], 5.4 (the rendering
//! stack) in [`stack`], which has the traits, and in the modules of its components.
//!
//! Ray packets and kernels are [`mobula_core`]'s, lanes and levels [`mobula_core::simd`]'s. A whole frame:
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
//!
//! # Map
//!
//! Each module uses only what stands below it in this table.
//!
//! | module | idea |
//! |---|---|
//! | [`prelude`] | what a program with components of its own names |
//! | `kernels` | the `mobula kernels` command: with the features `cli` and `kernels` |
//! | [`scale`] | how rendering scales: measured, and projected to more processors |
//! | [`display`] | where pictures go: files, two eyes in one picture, a window |
//! | [`app`] | from a scene description to a pipeline that renders it |
//! | [`load`] | files from strangers become scene descriptions |
//! | [`builtin`], [`generate`] | scenes from no file |
//! | [`scene`] | what is in a scene, and the scene made ready to be rendered |
//! | [`renderer`] | what is computed for a packet of rays |
//! | [`sampler`] | which rays a pixel gets, and in which packets |
//! | [`camera`] | rays from image coordinates |
//! | [`material`] | what colours the rays that hit something |
//! | [`background`] | what colours the rays that hit nothing, and may light the rest |
//! | [`light`] | what reaches points |
//! | [`shading`] | how hits are coloured: what lights them, shadows, rays that go on |
//! | [`medium`] | what is between surfaces |
//! | [`stack`] | the traits of the rendering stack, and the scene that they meet |
//! | [`lighting`] | points to light, and what arrives there |
//! | [`geometry`] | what rays can hit, one file a kind; the structures that find hits |
//! | `scratch` | packets and columns that a thread uses again |
//! | [`packet`] | packets whose width is a number, and the table of widths |
//! | [`accel`] | which acceleration structure is built, and by which threads |
//! | [`traverse`] | image traversers: in which order the parts of a picture are rendered |
//! | [`pipeline`] | threads, stages, transactions, callbacks; knows nothing of rays |
//! | [`balance`] | load balancers: who gets which part of a frame's work |
//! | [`image`] | frame buffers |
//! | [`layers`] | linear colours, and what is behind each pixel |
//! | [`output`] | files that are whole or not there |
//! | [`particles`] | points with scalar attributes |
//! | [`volume`] | scalar values on regular grids |
//! | [`texture`] | pictures on surfaces |
//! | [`color`] | from linear colours to bytes |
//! | [`progress`] | how far long work has come |
//! | [`view`] | where a camera stands and looks |
//! | [`tone`] | from the light that arrives to what a screen can show |
//! | [`choice`] | components that are chosen by name |
//! | `sequence` | points that fill a square evenly, for what is chosen at random |
//! | `warp` | points of a square moved to disks and directions |
//! | `lanes` | vectors of three, a lane a ray |
//! | [`math`] | arithmetic whose bits depend on no platform |

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
#[cfg(all(feature = "cli", feature = "kernels"))]
pub mod kernels;
mod lanes;
pub mod layers;
pub mod light;
pub mod lighting;
pub mod load;
pub mod material;
pub mod math;
pub mod medium;
pub mod output;
pub mod packet;
pub mod particles;
pub mod pipeline;
pub mod prelude;
pub mod progress;
pub mod renderer;
pub mod sampler;
pub mod scale;
pub mod scene;
mod scratch;
mod sequence;
pub mod shading;
pub mod stack;
pub mod texture;
pub mod tone;
pub mod traverse;
pub mod view;
pub mod volume;
mod warp;
