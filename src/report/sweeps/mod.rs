//! The sweeps: one file per thing that is varied, the rest held at what was asked for.

pub mod directions;
pub mod precision;
pub mod rim;
pub mod run;
pub mod solver;

use super::reference::{self, Field, Operator};
use super::timing;
use crate::Result;
use crate::engine::cpu;
use crate::frame::{Frame, Plane};
use crate::params::{Scale, ShapeParams};
use crate::plan::Goal;

/// A frame with the double-precision reference of its undiffused gradient.
pub struct Measuring<'a> {
    /// The frame.
    pub frame: &'a Frame,
    /// How its shape is found, but for what a sweep varies.
    pub shape: ShapeParams,
    /// The conductance that the backend found.
    pub conductance: Plane,
    /// The gradient before diffusion.
    pub gradient: Field,
    /// Its largest length: all errors of a slope are told relative to it.
    pub steepest: f64,
    operator: Operator,
}

impl<'a> Measuring<'a> {
    /// Finds the conductance and the reference gradient of `frame`.
    ///
    /// # Errors
    /// [`crate::Error::BadParameter`] for a parameter outside its range.
    pub fn new(frame: &'a Frame, shape: ShapeParams) -> Result<Self> {
        let undiffused = ShapeParams {
            scale: Scale::Iterations(0),
            ..shape
        };
        let outcome = cpu::run(&timing::plan(Goal::Layers, frame, undiffused)?, frame);
        let conductance = outcome
            .shape
            .conductance
            .expect("layers hold the conductance");
        let gradient = reference::depth_gradient(frame, &shape);
        let steepest = reference::largest(&gradient);
        Ok(Self {
            frame,
            shape,
            operator: Operator::new(&conductance),
            // A frame without slopes has no errors of them either.
            steepest: if steepest > 0.0 { steepest } else { 1.0 },
            conductance,
            gradient,
        })
    }

    /// The reference gradient at `scale`.
    pub fn diffused(&self, scale: Scale) -> Field {
        self.operator.diffused(
            &self.gradient,
            &ShapeParams {
                scale,
                ..self.shape
            },
        )
    }

    /// The reference trace of a gradient.
    pub fn trace(&self, gradient: &Field) -> Plane<f64> {
        reference::trace(gradient, &self.conductance, &self.frame.mask)
    }

    /// The largest overshoot of the two components of a diffused gradient.
    pub fn overshoot(&self, found: &crate::frame::Vector2Planes) -> f64 {
        let mask = &self.frame.mask;
        let of = |plane: &Plane, start: &Plane<f64>| {
            super::compare::overshoot(plane, reference::range(start, mask), mask, self.steepest)
        };
        of(&found.x, &self.gradient[0]).max(of(&found.y, &self.gradient[1]))
    }
}

/// A scale in words.
pub fn named(scale: Scale) -> String {
    match scale {
        Scale::Iterations(1) => "1 step".into(),
        Scale::Iterations(count) => format!("{count} steps"),
        Scale::Sigma(sigma) => format!("sigma {sigma} px"),
    }
}
