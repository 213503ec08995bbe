//! What hatching can be told.

mod field;

pub use field::{Fallback, FieldParams, MAX_FIELD_PASSES, StrokeDirections};
