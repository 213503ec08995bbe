//! Sweeps: one file per varied parameter, with the others fixed as given.

#[cfg(test)]
mod accuracy;
pub(crate) mod directions;
pub(crate) mod precision;
pub(crate) mod rim;
pub(crate) mod run;
pub(crate) mod solver;

use super::compare::{Errors, compare, overshoot};
use super::engine::{self, Layers};
use super::reference::{self, Edges, Field, Operator};
use super::surface::Surface;
use super::weight::Weight;
use crate::Result;
use crate::frame::{Frame, Plane, Vector2Planes};
use crate::params::{Scale, ShapeParams};
use serde::Serialize;

/// Errors of the edge weights, rounding included; each weight is 0..1.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct EdgeErrors {
    /// Silhouettes.
    pub silhouette: Errors,
    /// Creases.
    pub crease: Errors,
    /// Conductance.
    pub conductance: Errors,
}

/// A frame with the double-precision reference of its edges and of its undiffused gradient.
pub(crate) struct Measuring<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// The parameters for finding its shape, except for the one that a sweep varies.
    pub shape: ShapeParams,
    /// Errors of the engine's edge weights.
    pub(crate) edges: EdgeErrors,
    /// Conductance used by the reference's diffusion.
    pub conductance: Plane<f64>,
    /// The gradient before diffusion.
    pub gradient: Field,
    /// Its largest length, which all errors of slopes are relative to.
    pub steepest: f64,
    operator: Operator,
}

impl<'a> Measuring<'a> {
    /// The reference of `frame` itself, for the engine's edges.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for a parameter outside its range.
    pub(crate) fn new(frame: &'a Frame, shape: ShapeParams) -> Result<Self> {
        Self::from(frame, &Surface::of(frame), shape)
    }

    /// The reference of the `surface` that `frame` was made from.
    ///
    /// # Errors
    /// As [`Measuring::new`].
    pub(crate) fn from(frame: &'a Frame, surface: &Surface, shape: ShapeParams) -> Result<Self> {
        let undiffused = ShapeParams {
            scale: Scale::Iterations(0),
            ..shape
        };
        let found = engine::layers(frame, undiffused)?;
        Ok(Self::beside(&found, frame, surface, shape))
    }

    /// The reference for edges from any source.
    fn beside(found: &Layers, frame: &'a Frame, surface: &Surface, shape: ShapeParams) -> Self {
        let edges = Edges::of(frame, surface, &shape);
        let conductance = edges.conductance_near(&found.conductance);
        let gradient = reference::depth_gradient(frame, surface, &shape);
        let steepest = reference::largest(&gradient);
        let errors = |found: &Plane, exact: &Plane<Weight>| {
            let exact = exact.map(|weight| weight.exact);
            compare([found], [&exact], &frame.mask, 1.0).in_window(frame.data_window)
        };
        Self {
            frame,
            shape,
            edges: EdgeErrors {
                silhouette: errors(&found.silhouette, &edges.silhouette),
                crease: errors(&found.crease, &edges.crease),
                conductance: errors(&found.conductance, &edges.conductance),
            },
            operator: Operator::new(&conductance),
            // Without slopes there are no errors of slopes either.
            steepest: if steepest > 0.0 { steepest } else { 1.0 },
            conductance,
            gradient,
        }
    }

    /// The reference gradient at `scale`.
    pub(crate) fn diffused(&self, scale: Scale) -> Field {
        let shape = ShapeParams {
            scale,
            ..self.shape
        };
        self.operator.diffused(&self.gradient, &shape)
    }

    /// The reference trace of a gradient.
    pub(crate) fn trace(&self, gradient: &Field) -> Plane<f64> {
        reference::trace(gradient, &self.conductance, &self.frame.mask)
    }

    /// Errors of a diffused gradient.
    pub(crate) fn gradient_errors(&self, found: &Vector2Planes, exact: &Field) -> Errors {
        let (found, exact) = ([&found.x, &found.y], exact.each_ref());
        let errors = compare(found, exact, &self.frame.mask, self.steepest);
        errors.in_window(self.frame.data_window)
    }

    /// The largest overshoot of the two components of a diffused gradient.
    pub(crate) fn overshoot(&self, found: &Vector2Planes) -> f64 {
        let mask = &self.frame.mask;
        let of = |plane: &Plane, start: &Plane<f64>| {
            overshoot(plane, reference::range(start, mask), mask, self.steepest)
        };
        of(&found.x, &self.gradient[0]).max(of(&found.y, &self.gradient[1]))
    }
}

/// A scale in words.
pub(crate) fn named(scale: Scale) -> String {
    match scale {
        Scale::Iterations(1) => "1 step".into(),
        Scale::Iterations(count) => format!("{count} steps"),
        Scale::Sigma(sigma) => format!("sigma {sigma} px"),
        Scale::Mixed([a, b]) => format!("sigma {a} and {b} px"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::params::SoftThreshold;
    use crate::report::scenes::Scene;

    /// Largest errors of silhouette, crease and conductance, gradient and trace, for shape computed with `found` and
    /// judged against `asked`.
    fn errors(frame: &Frame, found: ShapeParams, asked: ShapeParams) -> [f64; 5] {
        let layers = engine::layers(frame, found).unwrap();
        let measuring = Measuring::beside(&layers, frame, &Surface::of(frame), asked);
        let exact = measuring.diffused(asked.scale);
        let trace = measuring.trace(&exact);
        let traces = compare([&layers.trace()], [&trace], &frame.mask, measuring.steepest);
        let EdgeErrors {
            silhouette,
            crease,
            conductance,
        } = measuring.edges;
        let gradient = measuring.gradient_errors(&layers.gradient, &exact);
        [silhouette, crease, conductance, gradient, traces].map(|errors| errors.max)
    }

    #[test]
    fn errors_of_edge_weights_are_seen() {
        let scene = Scene::barriers(200, 150);
        let asked = ShapeParams {
            scale: Scale::Sigma(6.0),
            tolerance: 1e-6,
            ..ShapeParams::default()
        };
        // 2e-4: the rounding of a depth of 8, in pixels, over a ramp of one; 2e-6: the tolerance and rounding.
        let limits = [2e-4, 1e-6, 2e-4, 3e-6, 1e-4];
        let right = errors(&scene.frame, asked, asked);
        assert!(
            right.iter().zip(limits).all(|(e, limit)| *e < limit),
            "{right:?}"
        );
        // Thresholds a tenth too high.
        let off = |SoftThreshold { lo, hi }| SoftThreshold {
            lo: 1.1 * lo,
            hi: 1.1 * hi,
        };
        let silhouettes = ShapeParams {
            silhouette: off(asked.silhouette),
            ..asked
        };
        let creases = ShapeParams {
            crease: off(asked.crease),
            ..asked
        };
        for (kind, planted) in [(0, silhouettes), (1, creases)] {
            let seen = errors(&scene.frame, planted, asked);
            // The weight itself, conductance, gradient and trace, but not the other weight.
            for i in [kind, 2, 3, 4] {
                assert!(seen[i] > 30.0 * limits[i], "{kind}: {seen:?}");
            }
            assert_eq!(seen[1 - kind], right[1 - kind], "{kind}");
        }
    }

    #[test]
    fn an_error_of_conductance_alone_is_seen() {
        let scene = Scene::barriers(200, 150);
        let shape = ShapeParams {
            scale: Scale::Sigma(6.0),
            ..ShapeParams::default()
        };
        let mut layers = engine::layers(&scene.frame, shape).unwrap();
        // Squared, as in another paper's formula.
        layers.conductance = layers.conductance.map(|c| c * c);
        let measuring = Measuring::beside(&layers, &scene.frame, &Surface::of(&scene.frame), shape);
        let right = Measuring::new(&scene.frame, shape).unwrap();
        assert!(measuring.edges.conductance.max > 0.2);
        assert_eq!(measuring.edges.silhouette, right.edges.silhouette);
        // The effect of the error on the gradient is measured relative to the correct conductance.
        let squared = layers.conductance.map(f64::from);
        let wrong = Operator::new(&squared).diffused(&measuring.gradient, &shape);
        let wrong = wrong.map(|plane| plane.map(|v| v as f32));
        let [x, y] = wrong;
        let wrong = Vector2Planes { x, y };
        let exact = measuring.diffused(shape.scale);
        assert!(measuring.gradient_errors(&wrong, &exact).max > 0.01);
    }
}
