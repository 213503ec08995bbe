//! The planes of one role as they were read.

use crate::frame::coverage::sanitise;
use crate::frame::normals::is_written;
use crate::frame::{ColorPlanes, Plane, Vector3Planes, Window};
use crate::io::judge::borders::Borders;
use crate::io::photo::StoredPhoto;
use crate::io::roles::{Match, Role};
use crate::io::srgb;

/// The planes of one role: one or three, and the coverage stored with them.
pub(crate) struct RolePlanes {
    pub(crate) planes: Vec<Plane>,
    pub(crate) alpha: Option<Plane>,
    /// The pixels they hold.
    pub(crate) window: Window,
    /// Whether borders of vectors in coarse codes continue each other: as stored, before their steps were removed.
    pub(crate) borders: Option<Borders>,
}

impl RolePlanes {
    /// The planes of a photo; the last one is alpha if it has any.
    pub(crate) fn of_photo(photo: &StoredPhoto, mut planes: Vec<Plane>, window: Window) -> Self {
        let alpha = photo.header.has_alpha().then(|| planes.pop()).flatten();
        Self {
            planes,
            alpha,
            window,
            borders: None,
        }
    }

    /// The planes of a layer of an EXR, its alpha last.
    pub(crate) fn of_layer(layer: &Match, mut planes: Vec<Plane>, window: Window) -> Self {
        Self {
            alpha: layer.alpha.and_then(|_| planes.pop()),
            planes,
            window,
            borders: None,
        }
    }

    /// Multiplies colours by their coverage.
    pub(crate) fn premultiply(&mut self) {
        let Some(alpha) = &self.alpha else {
            return;
        };
        for plane in &mut self.planes {
            plane.each_with(alpha, |sample, alpha| *sample *= alpha);
        }
    }

    /// Makes colours linear that were encoded by the sRGB curve and then multiplied by their coverage.
    pub(crate) fn decode(&mut self) {
        let decoded = |v: f32| srgb::decoded(v.into()) as f32;
        for plane in &mut self.planes {
            match &self.alpha {
                None => *plane = plane.map(decoded),
                Some(alpha) => plane.each_with(alpha, |v, a| {
                    if a > 0.0 {
                        *v = a * decoded(*v / a);
                    }
                }),
            }
        }
    }

    /// Crops the planes of `role` to a window, or pads them: with NaN, as not covered, if coverage is read from the role,
    /// else with 0.
    pub(crate) fn fit_to(&mut self, role: Role, window: Window) {
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
    }

    /// Decodes the first two planes, of codes; NaN where nothing was written.
    pub(crate) fn decode_pair(&mut self) {
        if let [x, y, ..] = &mut self.planes[..] {
            for (x, y) in x.samples_mut().iter_mut().zip(y.samples_mut()) {
                let is_written = is_written([*x, *y, 0.0]);
                for v in [x, y] {
                    *v = if is_written { 2.0 * *v - 1.0 } else { f32::NAN };
                }
            }
        }
    }

    /// A vector of three components; those of a single plane are equal, and of two the third is 0.
    pub(crate) fn into_vector(mut self) -> Vector3Planes {
        if let [x, _] = &self.planes[..] {
            self.planes.push(Plane::filled(x.width(), x.height(), 0.0));
        }
        Vector3Planes::of(self.planes)
    }

    /// One plane: the mean of three.
    pub(crate) fn into_scalar(self) -> Plane {
        grey(self.planes)
    }

    /// A picture; one plane makes a grey one.
    pub(crate) fn into_color(self) -> ColorPlanes {
        ColorPlanes::of(self.planes)
    }

    /// Replaces non-finite samples; returns their number.
    pub(crate) fn sanitise(&mut self) -> usize {
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
