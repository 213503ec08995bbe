//! From layers to a picture.

use crate::frame::{ColorPlanes, Plane};

/// Black layers, told by how much of the paper each covers, 0..1, over one another on white paper.
pub fn on_paper(layers: &[&Plane]) -> ColorPlanes {
    let (first, rest) = layers.split_first().expect("a drawing has a layer");
    let mut white = first.map(|ink| 1.0 - ink);
    for layer in rest {
        let samples = white.samples_mut().iter_mut().zip(layer.samples());
        samples.for_each(|(white, ink)| *white *= 1.0 - ink);
    }
    ColorPlanes {
        r: white.clone(),
        g: white.clone(),
        b: white,
    }
}
