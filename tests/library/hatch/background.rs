//! Floors and walls: paper, but for the shadow of what stands on them and the place where it stands.

use super::halo::{asked, asked_before, bare};
use super::*;

const SIZE: [usize; 2] = [320, 240];

/// The root of the picture's area.
const H: f64 = 277.0;

/// Focal length and the row of the horizon, in pixels.
const FOCAL: f64 = 300.0;
const HORIZON: f64 = 40.0;

/// A ball of radius .7, four units away from a level camera one unit above a floor, its lowest point this high above it; and
/// a piece of wall that stands twelve units away.
struct BallOnFloor {
    lifted: f64,
    /// Height of bumps in the floor, as a share of the distance.
    bumps: f64,
}

impl BallOnFloor {
    const RADIUS: f64 = 0.7;
    const AWAY: f64 = 4.0;

    fn ray(x: usize, y: usize) -> DVec3 {
        let [x, y] = [x as f64 - 159.5, HORIZON - y as f64 - 0.5];
        DVec3::new(x / FOCAL, y / FOCAL, -1.0)
    }

    /// The distance along the view at a pixel, and the normal there, of the ball.
    fn ball(&self, x: usize, y: usize) -> Option<(f64, DVec3)> {
        let (ray, radius) = (Self::ray(x, y), Self::RADIUS);
        let middle = DVec3::new(0.0, radius + self.lifted - 1.0, -Self::AWAY);
        let (a, b) = (ray.length_squared(), ray.dot(middle));
        let c = middle.length_squared() - radius * radius;
        let root = b * b - a * c;
        let depth = (root > 0.0).then(|| (b - root.sqrt()) / a)?;
        Some((depth, (depth * ray - middle) / radius))
    }

    fn floor(&self, x: usize, y: usize) -> Option<(f64, DVec3)> {
        let below = (y as f64 + 0.5 - HORIZON) / FOCAL;
        let bump = 1.0 + self.bumps * (0.3 * x as f64).sin() * (0.3 * y as f64).sin();
        (below > 0.0).then(|| (bump / below, DVec3::Y))
    }

    /// 30 columns from a foot in row 300 / 12 below the horizon up to it.
    fn wall(x: usize, y: usize) -> Option<(f64, DVec3)> {
        ((220..250).contains(&x) && (40..65).contains(&y)).then_some((12.0, DVec3::Z))
    }

    fn seen(&self, x: usize, y: usize) -> Option<(f64, DVec3)> {
        let each = [self.ball(x, y), Self::wall(x, y), self.floor(x, y)];
        let each = each.into_iter().flatten();
        each.min_by(|a, b| a.0.total_cmp(&b.0))
    }

    fn frame(&self) -> Frame {
        let [width, height] = SIZE;
        let seen = Plane::from_fn(width, height, |x, y| self.seen(x, y));
        let normal = |x, y| seen.at(x, y).map_or(DVec3::ZERO, |(_, normal)| normal);
        let normal = Vector3Planes::from_fn(width, height, normal);
        let mask = Mask::new(seen.map(|seen| seen.is_some()));
        let [fx, fy, cx, cy] = [FOCAL, FOCAL, 160.0, HORIZON];
        Frame {
            depth: Some(seen.map(|seen| seen.map_or(0.0, |(depth, _)| depth as f32))),
            camera: Some(Camera {
                view_from_world: DAffine3::IDENTITY,
                projection: Projection::Perspective { fx, fy, cx, cy },
            }),
            ..Frame::of_normals(normal, mask)
        }
    }

    /// The mean ink of the floor where `wanted` takes the distance from the lowest point of the ball that is seen, in pixels.
    fn ink(&self, wanted: impl Fn(f64) -> bool) -> f64 {
        // The middle is asin(.3 / 4.01) below the horizon, the rim asin(.7 / 4.01) lower: 300 tan(14.3 degrees) is 76.7.
        let under = [159.5, HORIZON + 76.7 - 0.5];
        self.ink_where(|x, y| wanted((x as f64 - under[0]).hypot(y as f64 - under[1])))
    }

    /// The mean ink of the floor at the pixels wanted.
    fn ink_where(&self, wanted: impl Fn(usize, usize) -> bool) -> f64 {
        let asked = asked(&self.frame(), 0.0);
        let inks = places(SIZE[0], SIZE[1]).filter(|&(x, y)| {
            let is_other = self.ball(x, y).or(Self::wall(x, y)).is_some();
            self.floor(x, y).is_some() && !is_other && wanted(x, y)
        });
        let inks: Vec<f64> = inks.map(|(x, y)| f64::from(asked.at(x, y))).collect();
        assert!(!inks.is_empty());
        inks.iter().sum::<f64>() / inks.len() as f64
    }
}

#[test]
fn a_floor_is_paper_but_for_where_a_ball_stands_on_it() {
    let ball = |lifted, bumps| BallOnFloor { lifted, bumps };
    let stands = ball(0.0, 0.0);
    let contact = stands.ink(|away| away < H / 60.0);
    assert!(contact >= 0.5, "{contact}");
    // The ball is 2 * 300 / 4 * .7 = 106 pixels high.
    let lit = stands.ink(|away| away > 106.0 + H / 6.0);
    assert!(lit <= 0.02, "{lit}");
    let bumpy = ball(0.0, 0.01);
    assert!(bumpy.ink(|away| away > 106.0 + H / 6.0) <= 0.02);
    assert!(bumpy.ink(|away| away < H / 60.0) >= 0.5);
    // Three times as far away all is a quarter as large, and has a quarter of its ink: .22 exp(-d / 1.26) before the wall, at
    // distances of 2 to 8 pixels .01 in the mean, and .09 if it reached as far as before the ball.
    let far = stands.ink_where(|x, y| (222..248).contains(&x) && (67..73).contains(&y));
    assert!(far <= 0.03, "{far}");
    // By half its radius.
    let below = ball(0.35, 0.0).ink(|away| away < H / 60.0);
    assert!(below <= 0.05, "{below}");
}

#[test]
fn a_relief_that_fills_the_frame_keeps_its_ink() {
    // Waves of a thousandth of the distance in a wall: every pixel is near its plane, which then is the subject.
    let height = |x: f64| 4.0 * (0.1 * x).sin();
    let normal =
        |x: usize, _: usize| DVec3::new(-0.4 * (0.1 * x as f64).cos(), 0.0, 1.0).normalize();
    let normal = Vector3Planes::from_fn(240, 200, normal);
    let depth = |x: usize, _: usize| (4000.0 - height(x as f64)) as f32;
    let frame = bare(Frame {
        depth: Some(Plane::from_fn(240, 200, depth)),
        ..Frame::of_normals(normal, Mask::full(240, 200))
    });
    let ink = |background| -> f32 {
        let asked = asked_before(&frame, 0.0, background);
        asked.samples().iter().sum()
    };
    let share = ink(Background::Plain) / ink(Background::Strokes);
    assert!(share >= 0.95, "{share}");
}
