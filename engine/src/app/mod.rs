//! From a scene description to a pipeline that renders it: what the command uses, and programs that embed Mobula.
//!
//! The [`State`] holds the components themselves: a transaction can change any of them.
//!
//! ```
//! use mobula::app::{self, Settings};
//! use mobula::image::Size;
//! use mobula::pipeline::{Display, DisplayStage, Picture, Shown};
//!
//! struct Brightest;
//!
//! impl Display for Brightest {
//!     fn name(&self) -> &str {
//!         "brightest pixel"
//!     }
//!     fn show(&mut self, picture: &Picture<'_>) -> Result<Shown, Box<dyn std::error::Error + Send + Sync>> {
//!         println!("frame {}: {:?}", picture.frame, picture.buffer.pixels().max());
//!         Ok(Shown::Continue)
//!     }
//! }
//!
//! let scene = mobula::generate::generate("gen:terr20k").unwrap();
//! let settings = Settings { size: Size::new(32, 24)?, threads: 2, ..Settings::default() };
//! let mut pipeline = app::pipeline(&scene, &settings)?;
//! pipeline.add_stage(DisplayStage::new().with(0, Brightest));
//!
//! // Any thread may change the state at any time; it happens between two frames.
//! pipeline.handle().send("no shadows", |state: &mut app::State| state.stack.scene.shadows = false);
//! let report = pipeline.run(3)?;
//! assert_eq!(report.frames, 3);
//! assert_eq!(pipeline.state().rays().primary, 3 * 32 * 24);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod components;
mod particles;
mod pick;
mod refinement;
mod settings;
mod state;
mod streamer;
mod volumes;

pub use components::Components;
pub use particles::{ShownAttribute, ShownParticles};
pub use pick::Picked;
pub use refinement::ShownSamples;
pub use settings::{AppError, Settings, pipeline, pipeline_with_geometry};
pub use state::{Chosen, RayCounts, RenderFrames, State};
pub use streamer::Streamer;
pub use volumes::Volumes;

pub use crate::packet::{PacketWidth, UnknownWidth};
