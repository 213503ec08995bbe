//! Beyond the visible surface, from images alone: sight lines bent by mirrors and lenses, and what they meet.
//!
//! Theory: [LA] section 5.2. A sight line is mirrored at the visible surface, or refracted there and again where
//! it leaves through the back faces; then it is followed through a distance map around the object, or through the
//! picture of what lies behind. Changes: every texel stands for the tangent plane of its surface and not for a
//! point, so that walls are met exactly whatever the resolution; and a ray that passes behind something goes on,
//! where a height field would stop it. Practice: a [`Tracer`] per frame; [`Tracer::path`] bends the sight
//! line of a pixel, [`Tracer::hit`] follows any ray.

mod distance_map;
mod search;
mod seen_surface;
mod texels;
mod tracer;

pub use distance_map::DistanceMap;
pub use search::first_crossing;
pub use seen_surface::{SeenSurface, VisibleSurface};
pub use tracer::{Hit, Met, Path, Tracer};
