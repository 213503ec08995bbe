//! Scenes: frames, with what else a command has read.

use crate::command::chosen::Chosen;
use crate::frame::{Frame, Plane, SpecularScene};
use crate::io::Finding;
use crate::io::colorspace::Chromaticities;
use crate::work::source::FrameSource;
use std::path::PathBuf;

/// A file as input: a picture, or one frame of a sequence, whose name has a placeholder for the number.
#[derive(Debug, Clone, PartialEq)]
pub struct File {
    /// The render or photo.
    pub path: PathBuf,
    /// The number of the frame.
    pub number: Option<i32>,
}

/// A frame, with what else a command has read.
#[derive(Debug, Clone)]
pub struct LoadedScene {
    /// The frame.
    pub frame: Frame,
    /// Conclusions about the inputs.
    pub findings: Vec<Finding>,
    /// Warnings about the inputs.
    pub warnings: Vec<String>,
    /// A mask of 0..1: where and how far a picture is changed, or for other commands where a surface is, above one half.
    pub(super) mask: Option<Plane>,
    pub(super) specular: Option<SpecularScene>,
    /// The primaries of its picture, if a file names them.
    pub(super) primaries: Option<Chromaticities>,
    /// Choices made in reading it.
    pub(super) chosen: Chosen,
    /// What it was read from, if from files.
    pub(super) source: Option<FrameSource>,
}

impl LoadedScene {
    /// A scene of nothing but a frame.
    pub(super) fn of_frame(frame: Frame) -> Self {
        Self {
            frame,
            findings: Vec::new(),
            warnings: Vec::new(),
            mask: None,
            specular: None,
            primaries: None,
            chosen: Chosen::default(),
            source: None,
        }
    }
}
