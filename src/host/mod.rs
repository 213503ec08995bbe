//! The commands on frames in memory, for programs that offer them in turn, as the Python module does: settings under the
//! names of recipes, frames from arrays or files, results as planes.
//!
//! ```
//! use relievo::engine::{Engine, Run};
//! use relievo::host::{Given, LoadedScene, Work};
//!
//! # fn main() -> relievo::Result<()> {
//! let normals = [[0.6_f32, 0.0, 0.8]; 64].concat();
//! let color = [0.5_f32; 3 * 64];
//! let given = Given {
//!     color: Some((&color[..]).into()),
//!     ..Given::of_normals([8, 8], (&normals[..]).into())
//! };
//! let work = Work::new("enhance", &[("scaling".into(), "0".into())], None)?;
//! let made = work.run(&Engine::cpu(), &given.scene(&work)?, &Run::new())?;
//! let picture = made.picture().expect("enhancing gives a picture");
//! assert_eq!(picture.r.view()[[4, 4]], 0.5);
//! # Ok(())
//! # }
//! ```

mod arrays;
mod fault;
mod from_depth;
mod given;
mod made;
mod making;
mod scene;
mod sequence;
mod thumbnail;
mod work;

/// The most threads that an engine may have.
pub const MOST_THREADS: u16 = crate::command::args::MOST_THREADS;

pub use crate::command::setting::{Setting, SettingKind, settings_of};
pub use fault::without_fault;
pub use given::Given;
pub use made::{Made, MadeLayer};
pub use scene::{File, LoadedScene};
pub use sequence::{chosen_for_all, frames_of};
pub use thumbnail::thumbnail;
pub use work::Work;

/// The commands that make something of a frame. `normals` is not among them: it is `map` of the map called so.
pub const COMMANDS: &[&str] = crate::command::commands::COMMANDS.split_at(5).0;
