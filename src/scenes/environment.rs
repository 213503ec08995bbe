//! An environment given by a formula: no files, and nothing random.

use crate::light::environment::Environment;
use glam::Vec3;

/// Columns of the environment: more pixels than lights of any test.
const COLUMNS: usize = 512;

/// A sky with a bright side, a small sun, some colour and a dark ground, 512x256 pixels.
pub fn environment() -> Environment {
    let (side, sun) = (Vec3::new(0.6, 0.5, 0.62), Vec3::new(-0.5, 0.6, 0.62));
    let (side, sun) = (side.normalize(), sun.normalize());
    let blank = Environment::from_fn(COLUMNS, COLUMNS / 2, |_, _| [0.0; 3]);
    Environment::from_fn(COLUMNS, COLUMNS / 2, |x, y| {
        let direction = blank.direction(x, y);
        let glow = (0.5 + 0.5 * direction.dot(side)).powi(4);
        // 1 - cos is half the squared angle: a Gaussian of 0.05 radians' standard deviation.
        let disc = 80.0 * ((direction.dot(sun) - 1.0) / (0.05 * 0.05)).exp();
        let up = 0.1 * (1.0 + direction.y);
        [
            0.05 + up + 1.2 * glow + disc,
            0.06 + 1.5 * up + 0.9 * glow + 0.9 * disc,
            0.08 + 2.5 * up + 0.5 * glow + 0.7 * disc,
        ]
    })
}
