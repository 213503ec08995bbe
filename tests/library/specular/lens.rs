//! A rendered lens, of two spherical caps, before a wall: where its sight lines end, exactly.

use super::exact::on_sphere;
use super::*;
use crate::common::files::load;
use relievo::io::{SpecularInputs, load_specular};
use relievo::trace::{HitSurface, Tracer};

/// Middles of the spheres of the front and of the back, and their radius: fitted to the depth of both files, whose
/// pixels lie on them within 7e-5.
const FRONT: DVec3 = DVec3::new(-0.27055, 0.14949, -6.20987);
const BACK: DVec3 = DVec3::new(0.27055, -0.14949, -3.79013);
const RADIUS: f64 = 1.59972;
const IOR: f64 = 1.5;
/// Depth of the wall.
const WALL: f64 = 8.2;

/// The point of the wall seen at a position of the picture; `None` for total internal reflection, or light that misses
/// the wall.
fn on_wall(sight: &SightLines, at: DVec2) -> Option<DVec3> {
    let direction = sight.line(at.x, at.y).1.normalize();
    let (entry, _) = on_sphere(DVec3::ZERO, direction, FRONT, RADIUS)?;
    let inside = direction.refract((entry - FRONT) / RADIUS, 1.0 / IOR);
    let (_, exit) = on_sphere(entry, inside, BACK, RADIUS)?;
    let out = inside.refract(-(exit - BACK) / RADIUS, IOR);
    let goes_on = out != DVec3::ZERO && out.z < 0.0;
    goes_on.then(|| exit + (WALL + exit.z) / -out.z * out)
}

#[test]
fn sight_lines_through_a_lens_end_where_they_must() {
    let names = ["truth", "front", "back", "bg"];
    let files = names.map(|name| real(&format!("renders/lens_{name}_512.exr")));
    let [Some(truth), Some(front), Some(back), Some(behind)] = files else {
        return;
    };
    let front = front.to_str().map(String::from);
    let loaded = load(truth, |inputs, needs| {
        (inputs.normal, inputs.depth) = (front.clone(), front);
        needs.projection = true;
    });
    let inputs = SpecularInputs {
        back: Some(back),
        behind: Some(behind),
        ..SpecularInputs::default()
    };
    let scene = load_specular(&inputs, &loaded, None).unwrap();
    let bend = Bend::Glass { ior: IOR as f32 };
    let tracer = Tracer::new(&loaded.frame, &scene, &traced(bend)).unwrap();
    let camera = loaded.frame.camera.unwrap();
    let sight = SightLines::new(camera.projection);
    let (mut errors, mut found, mut all) = (Vec::new(), 0, 0);
    for (x, y) in covered(&loaded.frame.mask) {
        let expected = on_wall(&sight, middle(x, y)).and_then(|p| camera.projection.pixel_of(p));
        let in_picture = |p: &DVec2| p.min_element() > 0.0 && p.max_element() < 512.0;
        let Some(expected) = expected.filter(in_picture) else {
            continue;
        };
        all += 1;
        let path = tracer.path(x, y);
        let Some(hit) = path.and_then(|path| tracer.hit(&path.leaving())) else {
            continue;
        };
        found += 1;
        // The monkey is in front of the wall.
        let is_wall = hit.is_seen && hit.point.z < 0.001 - WALL;
        if let (true, HitSurface::Behind(at)) = (is_wall, hit.surface) {
            errors.push(at.distance(expected));
        }
    }
    let errors = sorted(errors);
    let [median, p95] = [0.5, 0.95].map(|share| quantile(&errors, share));
    assert!(f64::from(found) > 0.97 * f64::from(all), "{found} of {all}");
    assert!(median < 0.5 && p95 < 1.0, "{median} {p95} px");
}
