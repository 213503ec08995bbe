//! The planes of one role as they were read.

use super::borders::Borders;
use super::photo::StoredPhoto;
use super::roles::{Match, Role};
use super::srgb;
use crate::frame::coverage::sanitise;
use crate::frame::{ColorPlanes, Plane, Vector3Planes, Window};

/// The planes of one role: one or three, and the coverage stored with them.
pub(super) struct RolePlanes {
    pub(super) planes: Vec<Plane>,
    pub(super) alpha: Option<Plane>,
    /// The pixels they hold.
    pub(super) window: Window,
    /// Whether borders of vectors in coarse codes continue each other: as stored, before their steps were removed.
    pub(super) borders: Option<Borders>,
    /// Whether all samples are known to be finite.
    is_finite: bool,
}

impl RolePlanes {
    /// The planes of a photo; the last one is alpha if it has any.
    pub(super) fn of_photo(photo: &StoredPhoto, mut planes: Vec<Plane>, window: Window) -> Self {
        let alpha = photo.header.has_alpha().then(|| planes.pop()).flatten();
        Self {
            planes,
            alpha,
            window,
            borders: None,
            is_finite: false,
        }
    }

    /// The planes of a layer of an EXR, its alpha last, each with whether all samples are finite.
    pub(super) fn of_layer(layer: &Match, checked: Vec<(Plane, bool)>, window: Window) -> Self {
        let is_finite = checked.iter().all(|(_, is_finite)| *is_finite);
        let mut planes: Vec<Plane> = checked.into_iter().map(|(plane, _)| plane).collect();
        Self {
            alpha: layer.alpha.and_then(|_| planes.pop()),
            planes,
            window,
            borders: None,
            is_finite,
        }
    }

    /// Multiplies colours by their coverage.
    pub(super) fn premultiply(&mut self) {
        let Some(alpha) = &self.alpha else {
            return;
        };
        for plane in &mut self.planes {
            let samples = plane.samples_mut().iter_mut().zip(alpha.samples());
            samples.for_each(|(sample, alpha)| *sample *= alpha);
        }
    }

    /// Makes colours linear that were encoded by the sRGB curve and then multiplied by their coverage.
    pub(super) fn decode(&mut self) {
        let decoded = |v: f32| srgb::decoded(v.into()) as f32;
        self.is_finite = false;
        for plane in &mut self.planes {
            let samples = plane.samples_mut().iter_mut();
            match &self.alpha {
                None => samples.for_each(|v| *v = decoded(*v)),
                Some(alpha) => samples.zip(alpha.samples()).for_each(|(v, &a)| {
                    if a > 0.0 {
                        *v = a * decoded(*v / a);
                    }
                }),
            }
        }
    }

    /// Crops the planes of `role` to a window, or pads them: with NaN, as not covered, if coverage is read from the role,
    /// else with 0.
    pub(super) fn fit_to(&mut self, role: Role, window: Window) {
        if self.window == window {
            return;
        }
        let outside = match role {
            Role::Normal | Role::Depth | Role::Position => f32::NAN,
            _ => 0.0,
        };
        for plane in self.planes.iter_mut().chain(&mut self.alpha) {
            *plane = plane.moved(self.window, window, outside);
        }
        self.window = window;
        self.is_finite &= outside == 0.0;
    }

    /// A vector of three components; those of a single plane are equal.
    pub(super) fn into_vector(self) -> Vector3Planes {
        Vector3Planes::of(self.planes)
    }

    /// One plane: the mean of three.
    pub(super) fn into_scalar(self) -> Plane {
        grey(self.planes)
    }

    /// A picture; one plane makes a grey one.
    pub(super) fn into_color(self) -> ColorPlanes {
        ColorPlanes::of(self.planes)
    }

    /// Replaces non-finite samples; returns their number.
    pub(super) fn sanitise(&mut self) -> usize {
        if self.is_finite {
            return 0;
        }
        self.is_finite = true;
        let planes = self.planes.iter_mut().chain(&mut self.alpha);
        planes.map(sanitise).sum()
    }
}

/// One plane of one or three: their mean.
fn grey(mut planes: Vec<Plane>) -> Plane {
    if planes.len() == 1 {
        return planes.remove(0);
    }
    let ColorPlanes { r, g, b } = ColorPlanes::of(planes);
    Plane::from_fn(r.width(), r.height(), |x, y| {
        (r.at(x, y) + g.at(x, y) + b.at(x, y)) / 3.0
    })
}
