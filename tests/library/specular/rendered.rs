//! A rendered mirror ball in a hall, against where the renderer's own rays ended.

use super::*;
use crate::common::exr::Part;
use crate::common::files::load;
use crate::common::program::fixture;
use relievo::io::{SpecularInputs, load_specular};
use relievo::trace::Tracer;

/// The mirror, with normals and points of the file `hits` in place of its own where they are named.
fn loaded() -> Loaded {
    load(fixture("mirror.exr"), |_, needs| {
        (needs.color, needs.projection) = (true, true);
    })
}

fn hits() -> Option<String> {
    fixture("mirror.hits.exr").to_str().map(String::from)
}

fn scene(loaded: &Loaded, hit_position: Option<String>) -> SpecularScene {
    let inputs = SpecularInputs {
        mask: Some("Mirror".into()),
        surroundings: Some(fixture("mirror.surroundings.exr")),
        hit_position,
        ..SpecularInputs::default()
    };
    load_specular(&inputs, loaded, None).unwrap()
}

#[test]
fn the_search_ends_where_the_renderers_rays_did() {
    let loaded = loaded();
    let scene = scene(&loaded, hits());
    let truth = scene.hit_position.as_ref().unwrap();
    let tracer = Tracer::new(&loaded.frame, &scene, &traced(Bend::Mirror)).unwrap();
    let (mut errors, mut all) = (Vec::new(), 0);
    for (x, y) in places(320, 240) {
        let expected = truth.at(x, y);
        let Some(path) = tracer.path(x, y).filter(|_| expected.is_finite()) else {
            continue;
        };
        all += 1;
        if let Some(hit) = tracer.hit(&path.leaving()) {
            let (start, found) = (path.entry.start, hit.point);
            let seen = (found - start).angle_between(expected - start);
            errors.push(seen.max(found.distance(expected) / expected.distance(start)));
        }
    }
    let (share, errors) = (errors.len() as f64 / f64::from(all), sorted(errors));
    // The map is rounded to 1/4096 of a length of some units, and normals on the ball are filtered.
    let median = quantile(&errors, 0.5);
    let is_near = all > 20_000 && share > 0.97 && median < 5e-3;
    assert!(is_near, "{all} rays, {share} found, {median} of the way");
}

#[test]
fn distances_and_where_they_were_seen_from_are_as_good_as_positions() {
    let loaded = loaded();
    let known = scene(&loaded, None).surroundings.unwrap();
    let (width, height) = (known.width(), known.height());
    let distance = Plane::from_fn(width, height, |x, y| known.point_at(x, y).length() as f32);
    let desk = tempfile::tempdir().unwrap();
    let [map, pose] = ["map.exr", "pose.json"].map(|name| desk.path().join(name));
    let n = &known.normal;
    Part::of([
        ("Z", &distance),
        ("N.X", &n.x),
        ("N.Y", &n.y),
        ("N.Z", &n.z),
    ])
    .write(&map);
    let place = -(known.map_from_world * known.center);
    let row = |i: usize| known.map_from_world.row(i).extend(place[i]).to_array();
    let matrix = [row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]];
    std::fs::write(&pose, format!("{{\"world_to_camera\": {matrix:?}}}")).unwrap();
    let inputs = SpecularInputs {
        surroundings: Some(map),
        surroundings_camera: Some(pose),
        ..SpecularInputs::default()
    };
    let found = load_specular(&inputs, &loaded, None)
        .unwrap()
        .surroundings
        .unwrap();
    assert!(found.center.distance(known.center) < 1e-12);
    for (x, y) in places(width, height).filter(|&(x, y)| distance.at(x, y) > 0.0) {
        let [found, known] = [&found, &known].map(|map| map.point_at(x, y));
        // The renderer's rays pass a pixel anywhere, up to half its diagonal off, .71; its positions are rounded.
        let off = found.angle_between(known) / (std::f64::consts::PI / height as f64);
        let length = found.length() / known.length() - 1.0;
        assert!(
            off < 0.8 && length.abs() < 1e-6,
            "({x}, {y}): {off} px, {length}"
        );
    }
}

/// Image direction where adjacent pixels hit walls: the upright tangent of [LA] section 4.2, by the Jacobian of the
/// renderer's own points.
fn truth(points: &Vector3Planes, x: usize, y: usize) -> Option<DVec2> {
    let point = |x: usize, y: usize| {
        let is_inside = x < points.x.width() && y < points.x.height();
        is_inside.then(|| points.at(x, y)).filter(|p| p.is_finite())
    };
    let here = point(x, y)?;
    let sides = [
        point(x - 1, y)?,
        point(x + 1, y)?,
        point(x, y + 1)?,
        point(x, y - 1)?,
    ];
    let (right, up) = (0.5 * (sides[1] - sides[0]), 0.5 * (sides[3] - sides[2]));
    let normal = right.cross(up).try_normalize()?;
    // A cell of the field and more around it shows this plane alone: strokes are averaged over cells of 4 pixels.
    let is_flat = (0..81).all(|i| {
        let (x, y) = ((x + i % 9).wrapping_sub(4), (y + i / 9).wrapping_sub(4));
        point(x, y).is_some_and(|p| normal.dot(p - here).abs() <= 2e-3 * p.distance(here))
    });
    if !is_flat {
        return None;
    }
    // Side walls have x for a normal: y is next.
    let is_side = DVec3::X.cross(normal).length() < 0.02;
    let axis = if is_side { DVec3::Y } else { DVec3::X };
    let tangent = axis.cross(normal).try_normalize()?;
    let (aa, ab, bb) = (right.dot(right), right.dot(up), up.dot(up));
    let (a, b) = (right.dot(tangent), up.dot(tangent));
    DVec2::new(bb * a - ab * b, aa * b - ab * a).try_normalize()
}

#[test]
fn strokes_on_a_mirror_lie_where_the_renderers_rays_put_them() {
    let loaded = loaded();
    let params = default_but(|line: &mut LineParams| line.field.fallback = Fallback::Surface);
    let given = scene(&loaded, hits());
    let points = given.hit_position.clone().unwrap();
    for (name, scene) in [("searched", scene(&loaded, None)), ("given", given)] {
        let field = &fields(&loaded.frame, &scene, params, Bend::Mirror)[0];
        let inner = places(318, 238).map(|(x, y)| (x + 1, y + 1));
        let errors = inner.filter_map(|(x, y)| {
            let expected = truth(&points, x, y)?;
            let found = direction_at(field, x, y);
            let sine = found.perp_dot(expected).abs();
            Some(sine.atan2(found.dot(expected).abs()).to_degrees())
        });
        let errors = sorted(errors);
        let median = quantile(&errors, 0.5);
        let is_near = errors.len() > 1_000 && median < 3.0;
        assert!(is_near, "{name}: {median} degrees of {}", errors.len());
    }
}
