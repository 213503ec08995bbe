//! relievo brings out the shape of surfaces in pictures.

pub mod backend;
pub mod cli;
pub mod error;
pub mod frame;
pub mod io;
pub mod light;
pub mod params;
pub mod plan;
pub mod shape;

pub use error::{Error, Result};
