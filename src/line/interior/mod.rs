//! Interior lines: valleys, ridges and suggestive contours, the lines inside a surface that tell of its form.
//!
//! Theory: the view-dependent curvature of apparent ridges (Judd, Durand and Adelson, "Apparent ridges for line drawing",
//! 2007) is how fast the normal turns from pixel to pixel, `q`, the largest singular value of dn/d(x, y); lines run where it
//! is largest across them. Suggestive contours (DeCarlo, Finkelstein, Rusinkiewicz and Santella, "Suggestive contours for
//! conveying shape", 2003) run where a surface all but turns away: minima of n.v toward the viewer. Changes: both are found
//! in the picture, from normals diffused by the silhouettes' conductance to a scale that is a share of the picture; valleys
//! count more than ridges, since full sets of ridges double every lip. Practice: `level` diffuses, `turning` and
//! `facing` measure, `crests` finds maxima to a part of a pixel, `chains` makes lines of them, `choice` takes the plainest,
//! and `drawn` gives them widths.

mod chains;
mod choice;
pub(crate) mod cpu;
mod crests;
mod drawn;
mod facing;
mod level;
mod shadows;
mod sizes;
pub(crate) mod stage;
#[cfg(test)]
mod tests;
mod turning;
