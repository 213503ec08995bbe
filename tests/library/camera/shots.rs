//! Pictures of small scenes, by cameras that are known.

use crate::prelude::*;
use half::f16;

/// Scene hit by the sight lines.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Scene {
    /// Two balls on a ground at height 0.
    Balls,
    /// The ground alone.
    Ground,
}

const BALLS: [(DVec3, f64); 2] = [
    (DVec3::new(0.0, 0.0, 1.0), 1.0),
    (DVec3::new(1.4, 0.9, 0.5), 0.5),
];

/// First hit of a sight line.
#[derive(Clone, Copy)]
pub(crate) struct Seen {
    pub(crate) point: DVec3,
    pub(crate) normal: DVec3,
    /// Distance in lengths of the sight line's vector.
    pub(crate) steps: f64,
    /// Distance.
    pub(crate) distance: f64,
}

impl Scene {
    fn seen(self, from: DVec3, along: DVec3) -> Option<Seen> {
        let down = -from.z / along.z;
        let near = (from + down * along).length() < 6.0;
        let mut hits: Vec<(f64, DVec3)> = near.then_some((down, DVec3::Z)).into_iter().collect();
        for (centre, radius) in BALLS.iter().filter(|_| self == Scene::Balls) {
            let to = from - *centre;
            let (a, b) = (along.length_squared(), to.dot(along));
            let root = b * b - a * (to.length_squared() - radius * radius);
            if root > 0.0 {
                let steps = -(b + root.sqrt()) / a;
                hits.push((steps, (to + steps * along) / *radius));
            }
        }
        hits.retain(|(steps, _)| *steps > 0.0);
        let first = hits.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        first.map(|(steps, normal)| Seen {
            point: from + steps * along,
            normal,
            steps,
            distance: steps * along.length(),
        })
    }
}

/// A picture of a scene, with the degradations of its layers.
#[derive(Clone)]
pub(crate) struct Shot {
    pub(crate) scene: Scene,
    pub(crate) camera: Camera,
    pub(crate) data: Window,
    pub(crate) display: Window,
    pub(crate) aspect: f64,
    /// Largest offset of a sample from its pixel's centre, in pixels.
    pub(crate) jitter: f64,
    /// Whether the layers are stored in half floats.
    pub(crate) half: bool,
    /// The scene's origin in the positions.
    pub(crate) offset: DVec3,
    /// Share of the positions that are mixed with others.
    pub(crate) mixed: f64,
    /// Whether depth is distance along the sight line.
    pub(crate) ray: bool,
    /// Rotates the normals into another space than the camera's.
    pub(crate) normals: DMat3,
}

impl Default for Shot {
    fn default() -> Self {
        let display = Window::from_size(320, 240);
        Shot {
            scene: Scene::Balls,
            camera: perspective(DVec3::new(1.0, -6.0, 2.5), 380.0, display, 1.0),
            data: display,
            display,
            aspect: 1.0,
            jitter: 0.0,
            half: false,
            offset: DVec3::ZERO,
            mixed: 0.0,
            ray: false,
            normals: DMat3::IDENTITY,
        }
    }
}

impl Shot {
    /// The usual one, with this change.
    pub(crate) fn with(change: impl FnOnce(&mut Self)) -> Self {
        default_but(change)
    }
}

/// The rotation and translation of an eye that looks at the balls with z up.
pub(crate) fn looking(eye: DVec3) -> DAffine3 {
    let back = (eye - DVec3::new(0.3, 0.2, 0.7)).normalize();
    let right = DVec3::Z.cross(back).normalize();
    let rotation = DMat3::from_cols(right, back.cross(right), back).transpose();
    DAffine3::from_mat3_translation(rotation, -(rotation * eye))
}

pub(crate) fn perspective(eye: DVec3, focal: f64, display: Window, aspect: f64) -> Camera {
    let [cx, cy] = middle(display).to_array();
    let (fx, fy) = (focal, focal * aspect);
    Camera {
        view_from_world: looking(eye),
        projection: Projection::Perspective { fx, fy, cx, cy },
    }
}

fn middle(window: Window) -> DVec2 {
    let Window { x0, y0, x1, y1 } = window;
    0.5 * DVec2::new((x0 + x1).into(), (y0 + y1).into())
}

impl Shot {
    /// Makes the picture this large.
    pub(crate) fn of_size(&mut self, width: usize, height: usize) {
        self.display = Window::from_size(width, height);
        self.data = self.display;
    }

    /// The scene in parallel sight lines, 60 pixel widths per unit.
    pub(crate) fn parallel(aspect: f64) -> Self {
        let mut shot = Shot::with(|shot| shot.aspect = aspect);
        let [cx, cy] = middle(shot.display).to_array();
        let (sx, sy) = (60.0, 60.0 * aspect);
        shot.camera.projection = Projection::Orthographic { sx, sy, cx, cy };
        shot
    }

    /// The hit of the pixel at a column and row of the data window: at its centre, offset by `off`.
    fn seen_at(&self, x: usize, y: usize, off: DVec2) -> Option<Seen> {
        let corner = DVec2::new(self.data.x0.into(), self.data.y0.into());
        let at = corner + DVec2::new(x as f64 + 0.5, y as f64 + 0.5) + off;
        let (from, along) = SightLines::new(self.camera.projection).line(at.x, at.y);
        let world = self.camera.view_from_world.inverse();
        let direction = world.transform_vector3(along);
        self.scene.seen(world.transform_point3(from), direction)
    }

    /// The hits at the centres of all pixels.
    pub(crate) fn seen(&self) -> Plane<Option<Seen>> {
        Plane::from_fn(self.data.width(), self.data.height(), |x, y| {
            self.seen_at(x, y, DVec2::ZERO)
        })
    }

    /// The hits of all pixels at random offsets within the jitter.
    pub(crate) fn seen_jittered(&self, numbers: &mut Numbers) -> Plane<Option<Seen>> {
        let mut off = || self.jitter * (2.0 * numbers.next() - 1.0);
        Plane::from_fn(self.data.width(), self.data.height(), |x, y| {
            self.seen_at(x, y, DVec2::new(off(), off()))
        })
    }

    /// A value rounded to the precision of its storage.
    pub(crate) fn stored(&self, value: f64) -> f64 {
        match self.half {
            true => f16::from_f64(value).to_f64(),
            false => value,
        }
    }
}

/// The balls seen all around by an eye, columns in longitude and rows in latitude.
pub(crate) fn panorama(width: usize, height: usize) -> Plane<Option<Seen>> {
    Plane::from_fn(width, height, |x, y| {
        let lon = (x as f64 + 0.5) / width as f64 * std::f64::consts::TAU;
        let lat = (0.5 - (y as f64 + 0.5) / height as f64) * std::f64::consts::PI;
        let along = DVec3::new(lat.cos() * lon.sin(), -lat.cos() * lon.cos(), lat.sin());
        Scene::Balls.seen(DVec3::new(0.5, -3.0, 1.3), along)
    })
}

/// A plain sequence of numbers in 0..1.
pub(crate) struct Numbers(pub(crate) u64);

impl Numbers {
    pub(crate) fn next(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }
}
