use super::*;

fn full(width: usize, rows: usize) -> Mask {
    Mask::full(width, rows)
}

/// Height and normals of `z(x)`, a groove along y, from its slope.
fn groove(
    width: usize,
    rows: usize,
    z: impl Fn(f64) -> f64,
    slope: impl Fn(f64) -> f64,
) -> (Plane, Vector3Planes) {
    let height = Plane::from_fn(width, rows, |x, _| z(x as f64) as f32);
    let normal = Vector3Planes::from_fn(width, rows, |x, _| {
        glam::DVec3::new(-slope(x as f64), 0.0, 1.0).normalize()
    });
    (height, normal)
}

/// A plane sees all of its sky, however it leans, and the light comes along its normal.
#[test]
fn a_plane_sees_all_of_its_sky() {
    for [p, q] in [[0.0, 0.0], [0.7, 0.0], [-1.5, 0.8], [0.0, 4.0]] {
        let height = Plane::from_fn(40, 40, |x, y| (p * x as f64 - q * y as f64) as f32);
        let n = glam::DVec3::new(-p, -q, 1.0).normalize();
        let normal = Vector3Planes::from_fn(40, 40, |_, _| n);
        let sky = sky(&height, &normal, &full(40, 40), 16.0, 8);
        for (x, y) in [(0, 0), (20, 20), (39, 5)] {
            assert!(
                (sky.seen.at(x, y) - 1.0).abs() < 1e-4,
                "{p} {q} {}",
                sky.seen.at(x, y)
            );
            let toward = sky.bent.at(x, y).dot(n);
            assert!(
                toward > 0.999,
                "{p} {q} {toward} at {x},{y}: {:?} {n:?}",
                sky.bent.at(x, y)
            );
        }
    }
}

/// The bottom of a V whose sides rise by m sees the sky within the angle b of the zenith, across the groove, with
/// tan b = 1/m: of a cosine-weighted sky the share sin b, the form factor of a strip without end. On a side, close to the
/// bottom, it is a wedge of w = pi - 2 atan m from the side's own plane on: (1 - cos w) / 2.
#[test]
fn a_groove_has_its_closed_form() {
    for m in [0.5, 1.0, 2.0] {
        let z = |x: f64| m * (x - 300.0).abs();
        // The bottom pixel itself is flat.
        let slope = |x: f64| {
            m * if x == 300.0 {
                0.0
            } else {
                (x - 300.0).signum()
            }
        };
        let (height, normal) = groove(601, 601, z, slope);
        let sky = sky(&height, &normal, &full(601, 601), 290.0, 32);
        let bottom = sky.seen.at(300, 300);
        let expected = (1.0_f64 / m).atan().sin();
        assert!(
            (f64::from(bottom) / expected - 1.0).abs() < 0.02,
            "{m}: {bottom} {expected}"
        );
        let side = sky.seen.at(301, 300);
        let expected = 0.5 * (1.0 - (std::f64::consts::PI - 2.0 * m.atan()).cos());
        assert!(
            (f64::from(side) / expected - 1.0).abs() < 0.02,
            "{m}: side {side} {expected}"
        );
        // The other side hides light from the left, where the normal leans to.
        assert!(sky.bent.x.at(301, 300) > normal.x.at(301, 300));
    }
}

/// A wall hides half of the sky at its foot, nothing beyond the radius; what is outside the mask hides nothing.
#[test]
fn walls_hide_half_within_the_radius() {
    let (height, normal) = groove(400, 64, |x| if x < 200.0 { 1e6 } else { 0.0 }, |_| 0.0);
    let of = |mask: &Mask, height: &Plane| sky(height, &normal, mask, 40.0, 16).seen;
    let seen = of(&full(400, 64), &height);
    assert!(
        (seen.at(200, 32) - 0.5).abs() < 0.02,
        "{}",
        seen.at(200, 32)
    );
    assert_eq!(seen.at(260, 32), 1.0);
    let mask = Mask::new(Plane::from_fn(400, 64, |x, _| x >= 200));
    let low = Plane::from_fn(
        400,
        64,
        |x, y| if x < 200 { NOTHING } else { height.at(x, y) },
    );
    let seen = of(&mask, &low);
    assert!((seen.at(200, 32) - 1.0).abs() < 1e-5);
    assert_eq!(seen.at(100, 32), 0.0);
}

#[test]
fn ordinary_and_extreme_inputs_end() {
    for size in [[1, 1], [7, 1], [1, 5], [3, 2]] {
        for height in [0.0_f32, 1e30, -1e30] {
            let plane = Plane::from_fn(size[0], size[1], |x, y| {
                if (x + y) % 2 == 0 { height } else { 0.0 }
            });
            let normal =
                Vector3Planes::from_fn(size[0], size[1], |_, _| glam::DVec3::new(1.0, 0.0, 0.0));
            let sky = sky(&plane, &normal, &full(size[0], size[1]), 300.0, 3);
            let all = [&sky.seen, &sky.bent.x, &sky.bent.y, &sky.bent.z];
            assert!(
                all.iter()
                    .all(|p| p.samples().iter().all(|v| v.is_finite())),
                "{size:?} {height}"
            );
        }
    }
}
