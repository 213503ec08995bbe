//! All stages, in the order of execution, and the plan that they make of a request.

mod available;
#[cfg(feature = "gpu")]
pub(crate) mod kernels;
pub(crate) mod resolve;

use crate::light::layers::stage::{AMBIENT_OCCLUSION, LIGHT_GROUPS, LIGHT_LOBES};
use crate::light::radiance_scaling::stage::RADIANCE_SCALING;
use crate::light::relight::stage::RELIGHT;
use crate::light::white_level::AUTO_WHITE;
use crate::line::background::stage::BACKGROUND;
use crate::line::contours::stage::CONTOURS;
use crate::line::direction_field::stage::DIRECTION_FIELD;
use crate::line::drawing::LINES_ONLY;
use crate::line::hatching::stage::HATCHING;
use crate::line::interior::stage::INTERIOR;
use crate::line::normal_rays::stage::NORMAL_RAYS;
use crate::line::shape_tone::stage::SHAPE_TONE;
use crate::line::specular::stage::SPECULAR_TRACE;
use crate::line::stippling::stage::STIPPLING;
use crate::line::streamlines::stage::STREAMLINES;
use crate::line::texture_coordinates::stage::TEXTURE_COORDINATES;
use crate::line::tonal_art_map::stage::TONAL_ART_MAP;
use crate::plan::stage::Stage;
use crate::shape::auto_levels::stage::AUTO_GAIN;
use crate::shape::curvature::stage::{CURVATURE, MAPPED_CURVATURE};
use crate::shape::curvature_display::stage::CURVATURE_DISPLAY;
use crate::shape::diffusion::stage::DIFFUSION;
use crate::shape::edges::stage::EDGES;
use crate::shape::height::stage::HEIGHT;
use crate::shape::occlusion::stage::OCCLUSION;

/// Those that find the shape come first, then those that make a picture, and those that draw it.
static STAGES: [&Stage; 27] = [
    &EDGES,
    &HEIGHT,
    &OCCLUSION,
    &DIFFUSION,
    &CURVATURE,
    &NORMAL_RAYS,
    &AUTO_GAIN,
    &MAPPED_CURVATURE,
    &AUTO_WHITE,
    &RADIANCE_SCALING,
    &LIGHT_LOBES,
    &LIGHT_GROUPS,
    &AMBIENT_OCCLUSION,
    &CURVATURE_DISPLAY,
    &RELIGHT,
    &SPECULAR_TRACE,
    &BACKGROUND,
    &SHAPE_TONE,
    &CONTOURS,
    &INTERIOR,
    &DIRECTION_FIELD,
    &TEXTURE_COORDINATES,
    &TONAL_ART_MAP,
    &HATCHING,
    &STREAMLINES,
    &STIPPLING,
    &LINES_ONLY,
];

/// All stages.
pub(crate) fn stages() -> impl DoubleEndedIterator<Item = &'static Stage> {
    STAGES.iter().copied()
}
