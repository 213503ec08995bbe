//! relievo brings out the shape of surfaces in pictures.

pub mod error;
pub mod frame;
pub mod io;

pub use error::{Error, Result};
