//! Interior lines: valleys, ridges and suggestive contours, the lines inside a surface that show its form.
//!
//! Theory: the view-dependent curvature of apparent ridges (Judd, Durand and Adelson, "Apparent ridges for line
//! drawing", 2007) is the rate at which the normal turns from pixel to pixel, `q`, the largest singular value of
//! dn/d(x, y); lines follow its maxima across them. Suggestive contours (DeCarlo, Finkelstein, Rusinkiewicz and
//! Santella, "Suggestive contours for conveying shape", 2003) follow a surface that nearly turns away: minima of n.v
//! toward the viewer. Changes: both are found in the picture, from normals diffused by the silhouettes' conductance to
//! a scale that is a share of the picture; valleys count more than ridges, since full sets of ridges double every lip.
//! Practice: `level` diffuses, `facing` and [`turning`](crate::line::turning) measure, `crests` finds maxima to a fraction of a pixel, `chains`
//! makes lines of them, `choice` takes the strongest, and `drawn` gives them widths.
//!
//! Thresholds decide whether a line is drawn. In a sequence such a line would appear in one frame and disappear in the
//! next; there `fade` starts its width at 0 at the threshold, and lets it grow with the excess.

use crate::frame::Plane;
use crate::line::contours::Contour;
use crate::params::LineLevels;

mod chains;
mod choice;
pub(crate) mod cpu;
pub(super) mod crests;
mod drawn;
mod facing;
mod fade;
mod level;
mod shadows;
mod sizes;
pub(crate) mod stage;
#[cfg(test)]
mod tests;

/// Lines inside the surfaces of a frame.
#[derive(Debug, Clone)]
pub(crate) struct InteriorLayer {
    /// Their coverage of the paper, 0..1.
    pub(crate) covered: Plane,
    /// The lines themselves.
    pub(crate) lines: Vec<Contour>,
    /// The levels their widths were fitted to, if there are lines.
    pub(crate) levels: Option<[f32; LineLevels::COUNT]>,
}
