//! WGSL source with constants from Rust.

use std::fmt::{self, Display, Formatter};

/// The text of a WGSL file.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Wgsl {
    pub(crate) text: &'static str,
    /// The Rust constants it uses, by their WGSL names. No other part of a kernel declares them.
    pub(crate) numbers: &'static [(&'static str, Number)],
}

/// A constant that Rust and WGSL share; a colour is red, green and blue.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Number {
    U32(u32),
    I32(i32),
    F32(f32),
    Color([f32; 3]),
}

impl Number {
    /// Its declaration.
    pub(crate) fn declared(&self, name: &str) -> String {
        let kind = match self {
            Self::U32(_) => "u32",
            Self::I32(_) => "i32",
            Self::F32(_) => "f32",
            Self::Color(_) => "vec3<f32>",
        };
        format!("const {name}: {kind} = {self};\n")
    }
}

impl Display for Number {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self {
            Self::U32(value) => write!(f, "{value}u"),
            Self::I32(value) => write!(f, "{value}"),
            Self::F32(value) => write!(f, "{value:e}f"),
            Self::Color([r, g, b]) => write!(f, "vec3<f32>({r:e}f, {g:e}f, {b:e}f)"),
        }
    }
}

/// The WGSL of a neighbouring file, and the Rust constants it uses.
macro_rules! wgsl {
    ($file:literal) => {
        $crate::gpu::wgsl::wgsl!($file, [])
    };
    ($file:literal, $numbers:expr) => {
        $crate::gpu::wgsl::Wgsl {
            text: include_str!($file),
            numbers: &$numbers,
        }
    };
}

pub(crate) use wgsl;
