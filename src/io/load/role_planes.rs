//! The planes of one role as they were read.

use crate::frame::coverage::{sanitise, shares};
use crate::frame::normals::is_written;
use crate::frame::{ColorPlanes, Plane, Vector3Planes, Window};
use crate::io::exr::ReadSamples;
use crate::io::judge::borders::Borders;
use crate::io::judge::points::Points;
use crate::io::photo::StoredPhoto;
use crate::io::roles::{Match, Role};
use crate::io::srgb;
use half::f16;
use half::slice::HalfFloatSliceExt;
use rayon::prelude::*;

/// Samples converted by a task.
const SAMPLES_PER_TASK: usize = 1 << 16;

/// The planes of one role: one or three, and the coverage stored with them.
pub(crate) struct RolePlanes {
    pub(crate) planes: Vec<Plane>,
    /// Those of a picture or of positions in half floats, until they are needed as floats.
    halves: Vec<Plane<f16>>,
    pub(crate) alpha: Option<Plane>,
    /// The pixels they hold.
    pub(crate) window: Window,
    /// Whether borders of vectors in coarse codes continue each other: as stored, before their steps were removed.
    pub(crate) borders: Option<Borders>,
    /// Whether all samples are known to be finite.
    is_finite: bool,
}

impl RolePlanes {
    /// The planes of a photo; the last one is alpha if it has any.
    pub(crate) fn of_photo(photo: &StoredPhoto, mut planes: Vec<Plane>, window: Window) -> Self {
        let alpha = photo.header.has_alpha().then(|| planes.pop()).flatten();
        Self {
            planes,
            halves: Vec::new(),
            alpha,
            window,
            borders: None,
            is_finite: false,
        }
    }

    /// The planes of a layer of an EXR, its alpha last, in floats, each with whether all samples are finite.
    pub(crate) fn of_layer(
        layer: &Match,
        checked: Vec<(ReadSamples, bool)>,
        window: Window,
    ) -> Self {
        let is_finite = checked.iter().all(|(_, is_finite)| *is_finite);
        let (mut planes, mut halves) = (Vec::new(), Vec::new());
        for (samples, _) in checked {
            match samples {
                ReadSamples::Floats(plane) => planes.push(plane),
                ReadSamples::Halves(plane) => halves.push(plane),
            }
        }
        Self {
            alpha: layer.alpha.and_then(|_| planes.pop()),
            planes,
            halves,
            window,
            borders: None,
            is_finite,
        }
    }

    /// Converts half floats, in memory of `spare` planes where it is of that size.
    fn expand(&mut self, spare: &mut Vec<Plane>) {
        for half in std::mem::take(&mut self.halves) {
            let (width, height) = (half.width(), half.height());
            let spare = spare.pop().map(Plane::into_samples);
            let spare = spare.filter(|samples| samples.len() == width * height);
            let samples = spare.unwrap_or_else(|| vec![0.0; width * height]);
            self.planes.push(widened(&half, samples));
        }
    }

    /// Multiplies colours by their coverage.
    pub(crate) fn premultiply(&mut self) {
        let Some(alpha) = &self.alpha else {
            return;
        };
        for plane in &mut self.planes {
            let samples = plane.samples_mut().iter_mut().zip(alpha.samples());
            samples.for_each(|(sample, alpha)| *sample *= alpha);
        }
    }

    /// Makes colours linear that were encoded by the sRGB curve and then multiplied by their coverage.
    pub(crate) fn decode(&mut self) {
        let decoded = |v: f32| srgb::decoded(v.into()) as f32;
        self.is_finite = false;
        self.expand(&mut Vec::new());
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
    pub(crate) fn fit_to(&mut self, role: Role, window: Window) {
        if self.window == window {
            return;
        }
        self.expand(&mut Vec::new());
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
        self.expand(&mut Vec::new());
        if let [x, _] = &self.planes[..] {
            self.planes.push(Plane::filled(x.width(), x.height(), 0.0));
        }
        Vector3Planes::of(self.planes)
    }

    /// The planes in floats alone.
    pub(crate) fn into_planes(self) -> Vec<Plane> {
        self.planes
    }

    /// Positions, as they were read.
    pub(crate) fn points(&self) -> Points<'_> {
        fn three<T>(planes: &[T]) -> [&T; 3] {
            [0, 1, 2].map(|axis| &planes[axis.min(planes.len() - 1)])
        }
        match self.halves.is_empty() {
            true => Points::Floats(three(&self.planes)),
            false => Points::Halves(three(&self.halves)),
        }
    }

    /// One plane: the mean of three.
    pub(crate) fn into_scalar(mut self) -> Plane {
        self.expand(&mut Vec::new());
        grey(self.planes)
    }

    /// A picture; one plane makes a grey one.
    pub(crate) fn into_color(self) -> ColorPlanes {
        self.into_color_in(&mut Vec::new())
    }

    /// The same, in memory of `spare` planes where half floats are converted.
    pub(crate) fn into_color_in(mut self, spare: &mut Vec<Plane>) -> ColorPlanes {
        self.expand(spare);
        ColorPlanes::of(self.planes)
    }

    /// Takes out the coverage of a picture, 0..1.
    pub(crate) fn take_coverage(&mut self) -> Option<Plane> {
        self.alpha.take().map(shares)
    }

    /// Replaces non-finite samples; returns their number.
    pub(crate) fn sanitise(&mut self) -> usize {
        if self.is_finite {
            return 0;
        }
        self.is_finite = true;
        self.expand(&mut Vec::new());
        let planes = self.planes.iter_mut().chain(&mut self.alpha);
        planes.map(sanitise).sum()
    }
}

/// A plane of half floats as one of floats, in the memory of `samples`, of which there are as many.
fn widened(halves: &Plane<f16>, mut samples: Vec<f32>) -> Plane {
    let parts = samples.par_chunks_mut(SAMPLES_PER_TASK);
    let parts = parts.zip(halves.samples().par_chunks(SAMPLES_PER_TASK));
    parts.for_each(|(to, from)| from.convert_to_f32_slice(to));
    Plane::from_samples(halves.width(), halves.height(), samples)
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

#[cfg(test)]
mod tests {
    use super::*;

    /// Planes of halves: their number, the column and the row in each sample.
    fn of_halves() -> RolePlanes {
        let half = |k: usize| Plane::from_fn(4, 3, |x, y| f16::from_f32((k + x + 5 * y) as f32));
        RolePlanes {
            planes: Vec::new(),
            halves: (0..3).map(half).collect(),
            alpha: None,
            window: Window::from_size(4, 3),
            borders: None,
            is_finite: true,
        }
    }

    #[test]
    fn positions_of_halves_are_those_of_floats() {
        let floats = of_halves().into_vector();
        let halves = of_halves();
        let (halves, floats) = (halves.points(), Points::from(&floats));
        assert_eq!(halves.sizes(), floats.sizes());
        assert_eq!(halves.at(2, 1).to_array(), [7.0, 8.0, 9.0]);
        assert_eq!(halves.at(3, 2), floats.at(3, 2));
    }

    #[test]
    fn a_picture_of_halves_takes_the_memory_of_spare_planes_of_its_size() {
        let expected = of_halves().into_color();
        assert_eq!(expected.at(2, 1), [7.0, 8.0, 9.0]);
        let mut spare = vec![Plane::filled(2, 2, 9.0), Plane::filled(4, 3, 9.0)];
        let memory = spare[1].samples().as_ptr();
        let found = of_halves().into_color_in(&mut spare);
        assert_eq!(found, expected);
        assert_eq!(found.r.samples().as_ptr(), memory);
        assert!(spare.is_empty());
    }
}
