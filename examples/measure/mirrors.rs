//! A mirror ball in a room with columns, traced by a map of the room, as one table by search steps and one by rows of
//! the map: where sight lines end, and the directions of strokes there, against the exact ones.

use super::room::{self, EYE, End, PROJECTION, SIZE, Shown};
use crate::{Outcomes, direction_at, print_cells, quartiles, stroke_field};
use glam::{DAffine3, DMat3, DVec3};
use relievo::frame::{
    Camera, Frame, Mask, Plane, SpecularScene, Surroundings, Vector3Planes, map_direction,
};
use relievo::params::{
    Bend, Fallback, FieldParams, LineParams, SearchParams, SpecularParams, StrokeDirections,
};
use relievo::scenes::{angle_deg, frames::grey};
use relievo::trace::Tracer;
use std::sync::Arc;

/// Search steps, counted over half a turn; a mirrored sight line covers at most a quarter.
const STEPS: [u32; 6] = [8, 16, 32, 64, 128, 256];
/// Rows of the map.
const ROWS: [usize; 6] = [16, 32, 64, 128, 256, 512];

pub(crate) fn print() -> Outcomes<()> {
    let (frame, shown) = (grey(ball(), 0.5), room::shown());
    let errors = |by: [(usize, u32); 6]| {
        let errors = by.map(|(rows, steps)| Errors::new(&frame, &shown, rows, steps));
        errors.into_iter().collect::<Outcomes<Vec<Errors>>>()
    };
    let by_steps = errors(STEPS.map(|steps| (256, steps)))?;
    let by_rows = errors(ROWS.map(|rows| (rows, SearchParams::default().steps)))?;
    let percent = |share: f64| format!("{:.1} %", 100.0 * share);
    print_cells("steps", STEPS);
    println!("|---|---|---|---|---|---|---|");
    print_cells("columns missed", by_steps.iter().map(|e| percent(e.missed)));
    print_cells("astray", by_steps.iter().map(|e| percent(e.astray)));
    println!();
    print_cells("rows", ROWS);
    println!("|---|---|---|---|---|---|---|");
    let points = "half of all points on columns within, relative to their distance";
    print_cells(points, by_rows.iter().map(|e| format!("{:.1e}", e.place)));
    let strokes = "half of all strokes there within, degrees";
    print_cells(strokes, by_rows.iter().map(|e| format!("{:.3}", e.angle)));
    Ok(())
}

/// The ball as a frame.
fn ball() -> Frame {
    let normal = |x, y| room::on_ball(room::middle(x, y)).map_or(DVec3::ZERO, |(_, normal)| normal);
    let depth = |x, y| (EYE.z - normal(x, y).z) as f32;
    let mask = Plane::from_fn(SIZE, SIZE, |x, y| {
        room::on_ball(room::middle(x, y)).is_some()
    });
    Frame {
        depth: Some(Plane::from_fn(SIZE, SIZE, depth)),
        camera: Some(Camera {
            view_from_world: DAffine3::from_translation(-EYE),
            projection: PROJECTION,
        }),
        ..Frame::of_normals(Vector3Planes::from_fn(SIZE, SIZE, normal), Mask::new(mask))
    }
}

/// The map of the room.
fn surroundings(rows: usize) -> Surroundings {
    let end = |x, y| End::of(DVec3::ZERO, map_direction(x, y, 2 * rows, rows));
    let planes =
        |value: fn(End) -> DVec3| Vector3Planes::from_fn(2 * rows, rows, |x, y| value(end(x, y)));
    Surroundings {
        center: DVec3::ZERO,
        map_from_world: DMat3::IDENTITY,
        points: planes(|end| end.point),
        normal: planes(|end| end.normal),
        normal_rounding: 0.0,
        color: None,
    }
}

/// Strokes as the surface has them, at full resolution and without smoothing.
fn line() -> LineParams {
    LineParams {
        field: FieldParams {
            passes: 0,
            cell_px: 1,
            fallback: Fallback::Surface,
            ..FieldParams::default()
        },
        directions: StrokeDirections::Max,
        ..LineParams::default()
    }
}

/// Errors of a trace: shares of pixels, and medians on columns.
struct Errors {
    missed: f64,
    astray: f64,
    place: f64,
    angle: f64,
}

impl Errors {
    fn new(frame: &Frame, shown: &[Shown], rows: usize, steps: u32) -> Outcomes<Self> {
        let search = SearchParams {
            steps,
            ..SearchParams::default()
        };
        let specular = SpecularParams {
            bend: Bend::Mirror,
            search,
        };
        let scene = SpecularScene {
            surroundings: Some(Arc::new(surroundings(rows))),
            ..SpecularScene::default()
        };
        let tracer =
            Tracer::new(frame, &scene, &specular).ok_or("the ball has depth and a camera")?;
        let field = stroke_field(frame, &line(), Some((&scene, specular)))?;
        let (mut astray, mut missed, mut columns) = (0, 0, 0);
        let [mut places, mut angles] = [Vec::new(), Vec::new()];
        for Shown { at, end, direction } in shown {
            let path = tracer.path(at[0], at[1]);
            let hit = path.and_then(|path| tracer.hit(&path.leaving()));
            let found = hit.filter(|hit| hit.is_seen).map(|hit| hit.point + EYE);
            let is_astray = found.is_none_or(|point| room::nearest(point) != end.surface);
            astray += usize::from(is_astray);
            if end.is_on_column() {
                columns += 1;
                missed += usize::from(is_astray);
                places.extend(found.map(|point| point.distance(end.point) / end.point.length()));
                angles.extend(direction.map(|exact| angle_deg(direction_at(&field, *at), exact)));
            }
        }
        Ok(Self {
            missed: missed as f64 / columns as f64,
            astray: astray as f64 / shown.len() as f64,
            place: quartiles(&places)[1],
            angle: quartiles(&angles)[1],
        })
    }
}
