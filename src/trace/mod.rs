//! Sight lines bent by mirrors and lenses, traced beyond the visible surface, using images only.
//!
//! Theory: [LA] section 5.2. A sight line is mirrored at the visible surface, or refracted there and again where it
//! leaves through the back faces; then it is traced through a distance map around the object, or through the picture of
//! the scene behind. Changes: every texel represents the tangent plane of its surface rather than a point, so that
//! walls are hit exactly at any resolution; a ray that passes behind something continues, where a height field would
//! stop it; and where it ends unseen, the surface it was last seen in front of is extended. Practice: a [`Tracer`] per
//! frame; [`Tracer::path`] bends the sight line of a pixel, [`Tracer::hit`] traces any ray.

mod bounds;
mod distance_map;
mod search;
mod seen_surface;
mod texels;
mod tracer;

pub(crate) use distance_map::DistanceMap;
pub(crate) use seen_surface::{SeenSurface, VisibleSurface};
pub(crate) use texels::Reached;
pub use tracer::{Hit, HitSurface, Path, Tracer};
