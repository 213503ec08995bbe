//! Gaps between the surfaces of neighbouring pixels: where one hides another.
//!
//! Theory: [LW] section 4.4 takes the Sobel magnitude of depth. Departs from it: a depth may be as steep as one likes
//! on a floor seen at a grazing angle, so its slope tells nothing. The distance of a point from the tangent plane of
//! its neighbour does: on a smooth surface of curvature kappa it is at most kappa / 2 times the square of a chord, under a
//! pixel up to the very rim, whatever the distance, the camera and the unit. So the gap between two pixels is the
//! larger of the distances of each one's point from the other's tangent plane, in pixels at the nearer one's distance.

pub(crate) mod noise;
pub(crate) mod of_frame;
pub(crate) mod pair;
pub(crate) mod rows;
pub(crate) mod scale;

/// Pixels that the silhouettes of gaps read to each side: the next gap, the depths beside it, and the noise around it.
pub(crate) const GAP_REACH: usize = 3 + noise::NOISE_REACH;
