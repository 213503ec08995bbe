//! A rendered lens, of two spherical caps, before a wall: where its sight lines end, exactly.

use super::traced;
use crate::prelude::*;
use relievo::io::{self, SpecularInputs, load_specular};
use relievo::trace::{HitSurface, Tracer};

/// Middles of the spheres of the front and of the back, and their radius: fitted to the depth of both files, whose
/// pixels lie on them within 7e-5.
const FRONT: DVec3 = DVec3::new(-0.27055, 0.14949, -6.20987);
const BACK: DVec3 = DVec3::new(0.27055, -0.14949, -3.79013);
const RADIUS: f64 = 1.59972;
const IOR: f64 = 1.5;
/// Depth of the wall.
const WALL: f64 = 8.2;

/// Exit, or entry, of a line from `start` through a sphere.
fn on_sphere(start: DVec3, direction: DVec3, middle: DVec3, leaves: bool) -> Option<DVec3> {
    let from = start - middle;
    let along = from.dot(direction);
    let square = along * along - from.length_squared() + RADIUS * RADIUS;
    let root = (square > 0.0).then(|| square.sqrt())?;
    let t = if leaves { root - along } else { -root - along };
    Some(start + t * direction)
}

/// The point of the wall seen at a position of the picture; `None` for total internal reflection, or light that misses
/// the wall.
fn on_wall(sight: &SightLines, at: DVec2) -> Option<DVec3> {
    let direction = sight.line(at.x, at.y).1.normalize();
    let entry = on_sphere(DVec3::ZERO, direction, FRONT, false)?;
    let inside = direction.refract((entry - FRONT) / RADIUS, 1.0 / IOR);
    let exit = on_sphere(entry, inside, BACK, true)?;
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
    let inputs = Inputs {
        picture: truth,
        normal: front.clone(),
        depth: front,
        ..Inputs::default()
    };
    let needs = Needs {
        projection: true,
        ..Needs::default()
    };
    let loaded = io::load(&inputs, needs).unwrap();
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
    for y in 0..512 {
        for x in loaded.frame.mask.runs(y).flatten() {
            let at = DVec2::new(x as f64, y as f64) + 0.5;
            let expected = on_wall(&sight, at).and_then(|p| camera.projection.pixel_of(p));
            let in_picture = |p: &DVec2| p.min_element() > 0.0 && p.max_element() < 512.0;
            let Some(expected) = expected.filter(in_picture) else {
                continue;
            };
            all += 1;
            let hit = tracer
                .path(x, y)
                .and_then(|path| tracer.hit(&path.leaving()));
            let Some(hit) = hit else { continue };
            found += 1;
            // The monkey is in front of the wall.
            if let (true, HitSurface::Behind(at)) =
                (hit.is_seen && hit.point.z < 0.001 - WALL, hit.surface)
            {
                errors.push(at.distance(expected));
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    let at = |share: f64| errors[((errors.len() - 1) as f64 * share) as usize];
    println!(
        "{all} sight lines, {:.2} % found, {:.1} % seen on the wall: median {:.3}, p95 {:.3} px",
        100.0 * f64::from(found) / f64::from(all),
        100.0 * errors.len() as f64 / f64::from(all),
        at(0.5),
        at(0.95)
    );
    assert!(f64::from(found) > 0.97 * f64::from(all));
    assert!(at(0.5) < 0.5 && at(0.95) < 1.0);
}
