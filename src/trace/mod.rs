//! Sight lines bent by mirrors and lenses, traced beyond the visible surface in images alone.
//!
//! Theory: [LA] section 5.2. A sight line is mirrored at the visible surface, or refracted there and again where
//! it leaves through the back faces; then it is followed through a distance map around the object, or through the
//! picture of what lies behind. Changes: every texel stands for the tangent plane of its surface and not for a
//! point, so that walls are met exactly whatever the resolution; a ray that passes behind something goes on, where
//! a height field would stop it; and where it ends unseen, the surface that it was last seen in front of is
//! taken to go on. Practice: a [`Tracer`] per frame; [`Tracer::path`] bends the sight
//! line of a pixel, [`Tracer::hit`] follows any ray.

mod distance_map;
mod search;
mod seen_surface;
mod texels;
mod tracer;

pub(crate) use distance_map::DistanceMap;
pub(crate) use seen_surface::{SeenSurface, VisibleSurface};
pub(crate) use texels::Reached;
pub use tracer::{Hit, HitSurface, Path, Tracer};
