//! The values at a pixel.

use crate::engine::cpu::outcome::Outcome;
use crate::frame::{ColorPlanes, Frame, Plane, Vector2Planes};
use crate::shape::curvature::{mapped_curvature, principal_curvatures};

/// A quantity by its name in the layers that `shape` writes, and its components.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Value {
    pub(super) name: &'static str,
    pub(super) numbers: Vec<f32>,
}

/// All that is known at a pixel of `frame`; nothing outside it.
pub(super) fn values(frame: &Frame, outcome: &Outcome, [x, y]: [usize; 2]) -> Vec<Value> {
    if x >= frame.mask.width() || y >= frame.mask.height() {
        return Vec::new();
    }
    let mut values = Vec::new();
    let mut say = |name, numbers: Vec<f32>| values.push(Value { name, numbers });
    let at = |plane: &Plane| plane.at(x, y);
    let colors = |c: &ColorPlanes| vec![at(&c.r), at(&c.g), at(&c.b)];
    let vector = |v: &Vector2Planes| vec![at(&v.x), at(&v.y)];
    if let Some(color) = &frame.color {
        say("picture", colors(color));
    }
    if let Some(color) = &outcome.color {
        say("result", colors(color));
    }
    if let Some(alpha) = &frame.alpha {
        say("alpha", vec![at(alpha)]);
    }
    if !frame.mask.at(x, y) {
        return values;
    }
    let n = &frame.normal;
    say("normal", vec![at(&n.x), at(&n.y), at(&n.z)]);
    if let Some(depth) = &frame.depth {
        say("depth", vec![at(depth)]);
    }
    let shape = &outcome.shape;
    let weights = [
        ("weights.silhouette", &shape.silhouette),
        ("weights.crease", &shape.crease),
        ("weights.conductance", &shape.conductance),
    ];
    for (name, weight) in weights {
        if let Some(weight) = weight {
            say(name, vec![at(weight)]);
        }
    }
    if let Some(gradient) = &shape.gradient {
        say("gradient", vector(gradient));
    }
    let trace = shape.trace.as_ref().map(at);
    if let Some(hessian) = &shape.hessian {
        let entries = [&hessian.xx, &hessian.xy, &hessian.yy].map(at);
        say("curvature.u, v", principal_curvatures(entries).to_vec());
    }
    let mean = shape.curvatures.as_ref().map(|c| at(&c.mean));
    if let Some(mean) = mean.or(trace.map(|trace| 0.5 * trace)) {
        say("curvature.mean", vec![mean]);
        if let Some(gain) = outcome.gain {
            let kappa = mapped_curvature(2.0 * mean, gain);
            say("curvature.kappa", vec![kappa]);
        }
    }
    if let Some(direction) = &shape.direction {
        say("direction", vector(direction));
    }
    if let Some(drawing) = &outcome.drawing {
        say("ink", vec![at(&drawing.hatching)]);
    }
    values
}
