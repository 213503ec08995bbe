//! The values at a pixel.

use crate::frame::{ColorPlanes, Frame, Plane};
use crate::plan::outcome::Outcome;
use crate::product::Product;
use crate::shape::curvature::{mapped_curvature, principal_curvatures};

/// A quantity named as in the layers of `shape`, and its components.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ProbedValue {
    pub(super) name: String,
    pub(super) numbers: Vec<f32>,
}

/// All values known at a pixel of `frame`; none outside it.
pub(super) fn values(frame: &Frame, outcome: &Outcome, [x, y]: [usize; 2]) -> Vec<ProbedValue> {
    if x >= frame.mask.width() || y >= frame.mask.height() {
        return Vec::new();
    }
    let mut values = Vec::new();
    let mut say = |name: String, numbers: Vec<f32>| values.push(ProbedValue { name, numbers });
    let at = |plane: &Plane| plane.at(x, y);
    let colors = |c: &ColorPlanes| vec![at(&c.r), at(&c.g), at(&c.b)];
    if let Some(color) = &frame.color {
        say("picture".into(), colors(color));
    }
    if let Some(color) = &outcome.color {
        say("result".into(), colors(color));
    }
    if let Some(alpha) = &frame.alpha {
        say("alpha".into(), vec![at(alpha)]);
    }
    if !frame.mask.at(x, y) {
        return values;
    }
    let n = &frame.normal;
    say("normal".into(), vec![at(&n.x), at(&n.y), at(&n.z)]);
    if let Some(depth) = &frame.depth {
        say("depth".into(), vec![at(depth)]);
    }
    for product in Product::all() {
        let planes = outcome.planes(product);
        let label = product.row().label().filter(|_| !planes.is_empty());
        if let Some(label) = label {
            say(label, planes.into_iter().map(at).collect());
        }
    }
    let shape = &outcome.shape;
    if shape.curvatures.is_none() {
        if let Some(hessian) = &shape.hessian {
            let entries = [&hessian.xx, &hessian.xy, &hessian.yy].map(at);
            say(
                "curvature.u, v".into(),
                principal_curvatures(entries).to_vec(),
            );
        }
        if let Some(trace) = shape.trace.as_ref().map(at) {
            say("curvature.mean".into(), vec![0.5 * trace]);
            if let Some(gain) = outcome.gain {
                say(
                    "curvature.kappa".into(),
                    vec![mapped_curvature(trace, gain)],
                );
            }
        }
    }
    if let Some(drawing) = &outcome.drawing {
        say("ink".into(), vec![at(&drawing.hatching)]);
    }
    values
}
