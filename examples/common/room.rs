//! A photographer's room by formula: walls, a soft box, a window. Something for surfaces to mirror.

use glam::Vec3;
use relievo::light::environment::Environment;

/// The room as a map of this many columns.
pub(crate) fn room(width: usize) -> Environment {
    let height = width / 2;
    // Only the map knows the directions of its pixels.
    let blank = Environment::from_fn(width, height, |_, _| [0.0; 3]);
    Environment::from_fn(width, height, |x, y| radiance(blank.direction(x, y)).into())
}

/// Radiance from the unit `direction`: x right, y up, z toward the viewer.
fn radiance(direction: Vec3) -> Vec3 {
    let ceiling = smooth((direction.y + 0.6) / 1.2);
    let walls = Vec3::new(0.09, 0.06, 0.04).lerp(Vec3::new(0.13, 0.16, 0.21), ceiling);
    let floor = Vec3::new(0.06, 0.04, 0.03);
    let walls = floor.lerp(walls, smooth((direction.y + 0.45) * 12.0));
    let soft_box = Panel {
        center: Vec3::new(-0.6, 0.55, 0.58).normalize(),
        half_size: [0.55, 0.40],
        bars: 0,
    };
    let window = Panel {
        center: Vec3::new(0.93, 0.2, -0.2).normalize(),
        half_size: [0.45, 0.60],
        bars: 1,
    };
    walls
        + soft_box.cover(direction) * Vec3::new(5.5, 5.0, 4.2)
        + window.cover(direction) * Vec3::new(1.6, 2.2, 3.2)
}

/// An upright rectangle of light at a distance of 1.
struct Panel {
    center: Vec3,
    half_size: [f32; 2],
    /// Panes to either side of the middle, parted by dark bars; 0 for one pane in all.
    bars: u32,
}

impl Panel {
    /// Coverage of `direction`, 0..1.
    fn cover(&self, direction: Vec3) -> f32 {
        let ahead = direction.dot(self.center);
        if ahead <= 0.0 {
            return 0.0;
        }
        let right = Vec3::Y.cross(self.center).normalize();
        let up = self.center.cross(right);
        let across = [direction.dot(right), direction.dot(up)].map(|v| v / ahead);
        let inside = |i: usize| smooth((self.half_size[i] - across[i].abs()) * 16.0);
        let pane = |i: usize| {
            let turns = across[i] / self.half_size[i] * self.bars as f32;
            smooth((turns - turns.round()).abs() * 6.0)
        };
        let panes = if self.bars == 0 {
            1.0
        } else {
            pane(0) * pane(1)
        };
        inside(0) * inside(1) * panes
    }
}

fn smooth(t: f32) -> f32 {
    let t = t.clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
