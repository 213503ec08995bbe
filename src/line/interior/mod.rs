//! Interior lines: valleys, ridges and suggestive contours, the lines inside a surface that show its form.
//!
//! Theory: the view-dependent curvature of apparent ridges (Judd, Durand and Adelson, "Apparent ridges for line drawing",
//! 2007) is how fast the normal turns from pixel to pixel, `q`, the largest singular value of dn/d(x, y); lines run where it
//! is largest across them. Suggestive contours (DeCarlo, Finkelstein, Rusinkiewicz and Santella, "Suggestive contours for
//! conveying shape", 2003) run where a surface all but turns away: minima of n.v toward the viewer. Changes: both are found
//! in the picture, from normals diffused by the silhouettes' conductance to a scale that is a share of the picture; valleys
//! count more than ridges, since full sets of ridges double every lip. Practice: `level` diffuses, `turning` and
//! `facing` measure, `crests` finds maxima to a part of a pixel, `chains` makes lines of them, `choice` takes the plainest,
//! and `drawn` gives them widths.
//!
//! A line is drawn or it is not, by thresholds. In a sequence such a line would be there in one frame and gone in the next;
//! there `fade` lets its width begin at nothing where a threshold would drop it, and grow with what exceeds that.

use crate::frame::Plane;
use crate::line::contours::Contour;
use crate::params::LineLevels;

mod chains;
mod choice;
pub(crate) mod cpu;
mod crests;
mod drawn;
mod facing;
mod fade;
mod level;
mod shadows;
mod sizes;
pub(crate) mod stage;
#[cfg(test)]
mod tests;
mod turning;

/// Lines inside the surfaces of a frame.
#[derive(Debug, Clone)]
pub(crate) struct InteriorLayer {
    /// How much of the paper they cover, 0..1.
    pub(crate) covered: Plane,
    /// The lines themselves.
    pub(crate) lines: Vec<Contour>,
    /// The levels that their widths were fit to, if there are lines.
    pub(crate) levels: Option<[f32; LineLevels::COUNT]>,
}
