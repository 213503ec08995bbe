//! Content of a file: parts, channels, and types of samples.

use super::compression::dwa_spoils;
use crate::frame::Window;

/// One part of a file: a picture with its own window, channels and compression.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Its name; only files with several parts must have one.
    pub name: Option<String>,
    /// The view it belongs to, such as "left".
    pub view: Option<String>,
    /// The pixels that are stored.
    pub window: Window,
    /// The compression, in lower case: "none", "zip", "dwaa".
    pub compression: String,
    /// Whether the pixels are stored in tiles instead of rows.
    pub tiled: bool,
    /// The channels, in alphabetical order.
    pub channels: Vec<Channel>,
    /// Meaning of the colours by `colorInteropID`, such as "lin_rec709_scene" or "data".
    pub color_interop_id: Option<String>,
}

/// One channel of a part.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Channel {
    /// The full name, such as "ViewLayer.Normal.X".
    pub name: String,
    /// Type of the stored samples.
    pub sample_type: SampleType,
}

/// Type of stored samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum SampleType {
    /// 16-bit floating point.
    Half,
    /// 32-bit floating point.
    Float,
    /// 32-bit unsigned integer.
    Uint,
}

/// A channel by its place in the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ChannelId {
    /// Index into [`ExrFile::parts`](super::ExrFile::parts).
    pub part: usize,
    /// Index into [`Part::channels`].
    pub channel: usize,
}

impl Part {
    /// Whether the compression changed the samples of the channel at index `channel`.
    ///
    /// DWA decides by the last token of the name: in a vector X, Y, Z it spoils only Y.
    pub fn is_lossy(&self, channel: usize) -> bool {
        let Channel { name, sample_type } = &self.channels[channel];
        match self.compression.as_str() {
            "pxr24" => *sample_type == SampleType::Float,
            "b44" | "b44a" => *sample_type == SampleType::Half,
            "dwaa" | "dwab" => *sample_type != SampleType::Uint && dwa_spoils(name),
            _ => false,
        }
    }
}
