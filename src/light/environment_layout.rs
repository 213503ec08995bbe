//! Layouts of environment pictures, and their conversion to a latitude-longitude map.

use super::environment::Environment;
use super::texels::Texels;
use crate::frame::ColorPlanes;

/// Layout of an environment in a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Layout {
    /// Longitude across, latitude down, as in [`Environment`].
    LatLong,
    /// A chrome ball that fills the picture, seen from far away: its centre reflects +z, behind the viewer; its rim -z.
    MirrorBall,
    /// A disc that fills the picture: its centre is -z, and the radius grows linearly with the angle up to +z at the
    /// rim. Also called a light probe.
    AngularMap,
    /// Six faces of a cube as an upright cross, 3:4. The middle of the second row is -z, with +y above,
    /// -y below, -x and +x to its sides; +z stands upside down at the foot.
    VerticalCross,
    /// Six faces of a cube as a horizontal cross, 4:3. From the left -x, -z, +x, +z; +y above -z, -y below.
    HorizontalCross,
}

/// Pixels at the rim of a ball that are not read, since they are blended with the background.
pub(crate) const RIM_PX: f32 = 1.5;

/// Largest range of values beside the faces of a cross, as a share of the brightest on the faces.
const BESIDE: f32 = 0.1;

/// A shorter radius counts as the centre of the disc.
pub(crate) const LEAST_RADIUS: f32 = 1e-9;

/// Look-ups per map pixel along each side: balls are locally finer than the map.
const SAMPLES: usize = 2;

impl Layout {
    /// The most likely layout of a picture of `width` by `height`; `None` for upright pictures that are no cross. A
    /// square is taken for a mirror ball: an angular map must be named.
    pub fn of_size(width: usize, height: usize) -> Option<Layout> {
        match () {
            () if width == height => Some(Layout::MirrorBall),
            () if 4 * width == 3 * height => Some(Layout::VerticalCross),
            () if 3 * width == 4 * height => Some(Layout::HorizontalCross),
            () if width > height => Some(Layout::LatLong),
            () => None,
        }
    }

    /// Whether a picture can have this layout: unlike a photo, a cross has a single colour beside its faces.
    pub(crate) fn suits(self, picture: &ColorPlanes) -> bool {
        let (cells, faces): ([usize; 2], &[[usize; 2]]) = match self {
            Layout::VerticalCross => ([3, 4], &[[1, 0], [0, 1], [1, 1], [2, 1], [1, 2], [1, 3]]),
            Layout::HorizontalCross => ([4, 3], &[[1, 0], [0, 1], [1, 1], [2, 1], [3, 1], [1, 2]]),
            _ => return true,
        };
        [&picture.r, &picture.g, &picture.b].iter().all(|plane| {
            let side = plane.width() as f32 / cells[0] as f32;
            // Away from the borders of faces, which compression smears.
            let within = |x: usize| (0.1..0.9).contains(&((x as f32 + 0.5) / side).fract());
            let is_face = |x: usize, y: usize| {
                let cell = [x, y].map(|i| ((i as f32 + 0.5) / side) as usize);
                faces.contains(&cell)
            };
            let pixels = (0..plane.height()).flat_map(|y| (0..plane.width()).map(move |x| (x, y)));
            let (mut least, mut most, mut brightest) = (f32::INFINITY, 0.0_f32, 0.0_f32);
            for (x, y) in pixels.filter(|&(x, y)| within(x) && within(y)) {
                let value = plane.at(x, y);
                if is_face(x, y) {
                    brightest = brightest.max(value);
                } else {
                    (least, most) = (least.min(value), most.max(value));
                }
            }
            most <= least + BESIDE * brightest
        })
    }

    /// Rows of a map about as fine as a picture of `width` by `height`.
    fn map_height(self, width: usize, height: usize) -> usize {
        match self {
            Layout::LatLong => height,
            Layout::MirrorBall | Layout::AngularMap => width.min(height),
            Layout::VerticalCross => width.div_ceil(3) * 2,
            Layout::HorizontalCross => height.div_ceil(3) * 2,
        }
    }
}

impl Environment {
    /// The environment in `picture`, of this `layout`, on a latitude-longitude map of similar resolution.
    ///
    /// # Panics
    /// If the planes differ in size or are empty.
    pub fn of_layout(picture: ColorPlanes, layout: Layout) -> Self {
        let texels = Texels::new(&picture);
        drop(picture);
        if layout == Layout::LatLong {
            return Self::of_texels(texels);
        }
        let rows = layout.map_height(texels.width(), texels.height());
        let columns = 2 * rows;
        let color = |x: usize, y: usize| {
            let mut sum = [0.0; 3];
            for i in 0..SAMPLES * SAMPLES {
                let offset = |i: usize| (i as f64 + 0.5) / SAMPLES as f64;
                let across = (x as f64 + offset(i % SAMPLES)) / columns as f64 - 0.5;
                let down = (y as f64 + offset(i / SAMPLES)) / rows as f64;
                let color = color_in(&texels, layout, direction(across, 0.5 - down));
                sum = std::array::from_fn(|c| sum[c] + color[c]);
            }
            sum.map(|v| v / (SAMPLES * SAMPLES) as f32)
        };
        Self::from_fn(columns, rows, color)
    }
}

/// The unit direction at an azimuth in turns from ahead and an elevation in half turns.
fn direction(azimuth: f64, elevation: f64) -> [f32; 3] {
    use std::f64::consts::{PI, TAU};
    let ((sin_a, cos_a), (sin_e, cos_e)) = ((azimuth * TAU).sin_cos(), (elevation * PI).sin_cos());
    [cos_e * sin_a, sin_e, -cos_e * cos_a].map(|v| v as f32)
}

fn color_in(picture: &Texels, layout: Layout, direction: [f32; 3]) -> [f32; 3] {
    match layout {
        Layout::LatLong => unreachable!("a map is used as it is"),
        Layout::MirrorBall => on_disc(picture, on_mirror_ball(direction)),
        Layout::AngularMap => on_disc(picture, on_angular_map(direction)),
        Layout::VerticalCross => on_cross(picture, [3, 4], on_cube(direction, true)),
        Layout::HorizontalCross => on_cross(picture, [4, 3], on_cube(direction, false)),
    }
}

/// The point of a ball of radius 1 that shows `direction`. A normal n reflects the viewer's direction e to 2 (n.e) n -
/// e, so n lies half-way between e and `direction`.
fn on_mirror_ball([x, y, z]: [f32; 3]) -> [f32; 2] {
    let length = (2.0 * (1.0 + z)).max(1e-12).sqrt();
    [x / length, y / length]
}

fn on_angular_map([x, y, z]: [f32; 3]) -> [f32; 2] {
    let across = x.hypot(y);
    let radius = across.atan2(-z) / std::f32::consts::PI;
    // Straight ahead the radius is 0, so the ratio does not matter; straight behind, any direction is valid.
    match across > 0.0 {
        true => [x / across * radius, y / across * radius],
        false => [radius, 0.0],
    }
}

/// The colour at a point of the disc inscribed in the picture, x right and y up, kept inside the rim. NaN reads the
/// centre.
#[inline]
pub(super) fn on_disc(picture: &Texels, [x, y]: [f32; 2]) -> [f32; 3] {
    let (width, height) = (picture.width() as f32, picture.height() as f32);
    let (x, y) = match x.is_nan() || y.is_nan() {
        true => (0.0, 0.0),
        // Clamped so that squares do not overflow.
        false => (x.clamp(-1e9, 1e9), y.clamp(-1e9, 1e9)),
    };
    let largest = (1.0 - 2.0 * RIM_PX / width.min(height)).max(0.0);
    let inward = largest / (x * x + y * y).sqrt().max(largest).max(LEAST_RADIUS);
    let column = (1.0 + x * inward) / 2.0 * width - 0.5;
    let row = (1.0 - y * inward) / 2.0 * height - 0.5;
    picture.clamped(column, row)
}

/// The face of the cross, by column and row, that shows a direction, and the position on it: x right, y up, -1..1.
fn on_cube([x, y, z]: [f32; 3], upright: bool) -> ([usize; 2], [f32; 2]) {
    let (ax, ay, az) = (x.abs(), y.abs(), z.abs());
    if az >= ax && az >= ay {
        match (z < 0.0, upright) {
            (true, _) => ([1, 1], [x / az, y / az]),
            (false, true) => ([1, 3], [x / az, -y / az]),
            (false, false) => ([3, 1], [-x / az, y / az]),
        }
    } else if ay >= ax {
        // Top and bottom adjoin -z with their nearer edges.
        match y > 0.0 {
            true => ([1, 0], [x / ay, z / ay]),
            false => ([1, 2], [x / ay, -z / ay]),
        }
    } else {
        match x > 0.0 {
            true => ([2, 1], [z / ax, y / ax]),
            false => ([0, 1], [-z / ax, y / ax]),
        }
    }
}

/// The colour at a point of a face, blended only with neighbours on the cube.
fn on_cross(
    picture: &Texels,
    faces: [usize; 2],
    ([column, row], [x, y]): ([usize; 2], [f32; 2]),
) -> [f32; 3] {
    let position = |side: usize, faces: usize, face: usize, share: f32| {
        let size = side as f32 / faces as f32;
        let (start, end) = (face as f32 * size, (face + 1) as f32 * size);
        let middle = (start + end) / 2.0;
        let (first, last) = ((start + 0.5).min(middle), (end - 0.5).max(middle));
        (start + share * size).clamp(first, last) - 0.5
    };
    picture.clamped(
        position(picture.width(), faces[0], column, (1.0 + x) / 2.0),
        position(picture.height(), faces[1], row, (1.0 - y) / 2.0),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Plane;
    use glam::Vec3;

    fn radiance(d: Vec3) -> [f32; 3] {
        [2.0 + d.x, 2.0 + d.y, 2.0 + d.z]
    }

    /// A picture of `radiance`, where `seen` gives the direction of a pixel; poison elsewhere.
    fn picture(
        width: usize,
        height: usize,
        seen: impl Fn(f32, f32) -> Option<Vec3>,
    ) -> ColorPlanes {
        let plane = |c: usize| {
            Plane::from_fn(width, height, |x, y| {
                let (x, y) = (x as f32 + 0.5, y as f32 + 0.5);
                seen(x, y).map_or(1e6, |d| radiance(d.normalize())[c])
            })
        };
        let [r, g, b] = [0, 1, 2].map(plane);
        ColorPlanes { r, g, b }
    }

    /// Largest error over directions within `reach` radians of `middle`.
    fn error(map: &Environment, middle: Vec3, reach: f32) -> f32 {
        let mut worst = 0.0_f32;
        for i in 0..4000 {
            let z = 1.0 - (2 * i + 1) as f32 / 4000.0;
            let (sin, cos) = (2.399_963 * i as f32).sin_cos();
            let d = Vec3::new((1.0 - z * z).sqrt() * cos, (1.0 - z * z).sqrt() * sin, z);
            if d.dot(middle) > reach.cos() {
                let (read, truth) = (map.radiance(d.into()), radiance(d));
                for c in 0..3 {
                    worst = worst.max((read[c] - truth[c]).abs());
                }
            }
        }
        worst
    }

    #[test]
    fn a_photo_of_the_proportions_of_a_cross_is_none() {
        let sky = |x: usize, y: usize| (x + y) as f32 / 100.0;
        let photo = ColorPlanes::grey(Plane::from_fn(40, 30, sky));
        assert!(!Layout::HorizontalCross.suits(&photo));
        assert!(Layout::MirrorBall.suits(&photo));
        // Only the rows and columns of the faces; pixels beside them are dark, except for smear.
        let is_face = |x: usize, y: usize| (10..20).contains(&y) || (10..20).contains(&x);
        let smear = |x: usize, y: usize| if x == 9 { 0.3 } else { sky(x, y).min(0.01) };
        let cross = |x, y| {
            if is_face(x, y) {
                sky(x, y)
            } else {
                smear(x, y)
            }
        };
        let lying = ColorPlanes::grey(Plane::from_fn(40, 30, cross));
        assert!(Layout::HorizontalCross.suits(&lying));
        let upright = ColorPlanes::grey(Plane::from_fn(30, 40, cross));
        assert!(Layout::VerticalCross.suits(&upright));
    }

    #[test]
    fn a_mirror_ball_gives_back_what_it_reflects() {
        let side = 256.0;
        let ball = picture(256, 256, |x, y| {
            let (x, y) = (2.0 * x / side - 1.0, 1.0 - 2.0 * y / side);
            let z = (1.0 - x * x - y * y).max(0.0).sqrt();
            // The mirror law, r = 2 (n.e) n - e with e = (0, 0, 1).
            let n = Vec3::new(x, y, z);
            (x * x + y * y < 1.0).then(|| 2.0 * n.z * n - Vec3::Z)
        });
        let map = Environment::of_layout(ball, Layout::MirrorBall);
        assert_eq!((map.width(), map.height()), (512, 256));
        // Radius 1 - 3/256 is the last that is read: 4 asin(sqrt(3/512)), or 17.6 degrees, from -z.
        let worst = error(&map, Vec3::Z, (180.0_f32 - 19.0).to_radians());
        assert!(worst < 0.02, "{worst}");
        let beyond = error(&map, Vec3::NEG_Z, 19.0_f32.to_radians());
        assert!(beyond < 0.34, "{beyond}, more than the sine of 19 degrees");
    }

    #[test]
    fn an_angular_map_gives_back_its_directions() {
        let side = 256.0;
        let probe = picture(256, 256, |x, y| {
            let (x, y) = (2.0 * x / side - 1.0, 1.0 - 2.0 * y / side);
            let radius = x.hypot(y);
            let (sin, cos) = (radius * std::f32::consts::PI).sin_cos();
            (radius < 1.0).then(|| Vec3::new(x / radius * sin, y / radius * sin, -cos))
        });
        let map = Environment::of_layout(probe, Layout::AngularMap);
        // The rim of 1.5 pixels is 1.5/128 half turns, 2.1 degrees.
        let worst = error(&map, Vec3::NEG_Z, std::f32::consts::PI);
        assert!(worst < 0.05, "{worst}");
        let inside = error(&map, Vec3::NEG_Z, 177.0_f32.to_radians());
        assert!(inside < 2e-3, "{inside}");
    }

    /// Directions of a face from its axes, as for a camera: view direction, right and up.
    fn on_face(x: f32, y: f32, [ahead, right, up]: [Vec3; 3]) -> Vec3 {
        ahead + (2.0 * x - 1.0) * right + (1.0 - 2.0 * y) * up
    }

    #[test]
    fn crosses_give_back_their_faces() {
        use Vec3 as V;
        let level = [
            ([0, 1], [V::NEG_X, V::NEG_Z, V::Y]),
            ([1, 1], [V::NEG_Z, V::X, V::Y]),
            ([2, 1], [V::X, V::Z, V::Y]),
            // Tilting the camera up from -z keeps its right, and its up becomes +z; down, -z.
            ([1, 0], [V::Y, V::X, V::Z]),
            ([1, 2], [V::NEG_Y, V::X, V::NEG_Z]),
        ];
        let behind = [
            (Layout::HorizontalCross, [3, 1], [V::Z, V::NEG_X, V::Y]),
            // Tilted further from straight down.
            (Layout::VerticalCross, [1, 3], [V::Z, V::X, V::NEG_Y]),
        ];
        for (layout, place, axes) in behind {
            let faces: Vec<_> = level.into_iter().chain([(place, axes)]).collect();
            let (columns, rows) = match layout {
                Layout::VerticalCross => (3, 4),
                _ => (4, 3),
            };
            let cross = picture(64 * columns, 64 * rows, |x, y| {
                let (x, y) = (x / 64.0, y / 64.0);
                let place = [x as usize, y as usize];
                let (_, axes) = faces.iter().find(|(p, _)| *p == place)?;
                Some(on_face(x.fract(), y.fract(), *axes))
            });
            assert_eq!(Layout::of_size(64 * columns, 64 * rows), Some(layout));
            let map = Environment::of_layout(cross, layout);
            let worst = error(&map, Vec3::Z, 4.0_f32.min(std::f32::consts::PI));
            // Half a pixel of a face next to its edges: 1/64.
            assert!(worst < 0.016, "{layout:?}: {worst}");
        }
    }

    #[test]
    fn sizes_tell_layouts() {
        let cases = [
            ((1024, 512), Some(Layout::LatLong)),
            ((1000, 600), Some(Layout::LatLong)),
            ((512, 512), Some(Layout::MirrorBall)),
            ((300, 400), Some(Layout::VerticalCross)),
            ((400, 300), Some(Layout::HorizontalCross)),
            ((300, 500), None),
        ];
        for ((width, height), layout) in cases {
            assert_eq!(Layout::of_size(width, height), layout, "{width}x{height}");
        }
    }

    #[test]
    fn pictures_of_one_pixel_are_read() {
        for layout in [
            Layout::LatLong,
            Layout::MirrorBall,
            Layout::AngularMap,
            Layout::VerticalCross,
            Layout::HorizontalCross,
        ] {
            let one = picture(1, 1, |_, _| Some(Vec3::X));
            let map = Environment::of_layout(one, layout);
            let read = map.radiance([0.0, 1.0, 0.0]);
            assert!((read[0] - 3.0).abs() < 1e-6, "{layout:?}: {read:?}");
        }
    }
}
