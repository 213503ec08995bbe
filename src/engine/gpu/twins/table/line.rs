//! Twins of lines and strokes.

use super::*;

pub(super) fn twins() -> Vec<Twin> {
    [rays(), steps(), normal_rays(), tangents(), strokes()]
        .into_iter()
        .flatten()
        .collect()
}

/// Sight lines whose line through the point below has the direction `line`.
fn sight([x, y, _]: [f32; 3], pixel_shape: f32) -> (SightLines, [f64; 2]) {
    let fy = f64::from(pixel_shape);
    let sight = SightLines::new(Projection::Perspective {
        fx: 1.0,
        fy,
        cx: 0.0,
        cy: 0.0,
    });
    (sight, [f64::from(x), -f64::from(y) * fy])
}

fn dvec([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into())
}

/// A sight line, a unit vector and a pixel aspect ratio.
fn seen_vector(words: &mut [u32]) {
    sight_line(words);
    unit_vector(&mut words[3..6]);
}

fn rays() -> Vec<Twin> {
    // The CPU computes the following in f64, the device in f32.
    const SINGLE: Tolerance = Tolerance::Absolute(1e-4);
    vec![
        // Positions in a picture, and cameras with focal lengths of 100 to 10,000 pixels.
        twin!(
            line,
            SightLines::line,
            NORMAL_RAYS,
            |place: [f32; 2], line: [f32; 2], step: [f32; 2]| {
                let [[line_x, line_y], [step_x, step_y]] =
                    [line, step].map(|pair| pair.map(f64::from));
                let [fx, fy] = [1.0 / step_x, -1.0 / step_y];
                let sight = SightLines::new(Projection::Perspective {
                    fx,
                    fy,
                    cx: 0.5 - line_x * fx,
                    cy: 0.5 + line_y * fy,
                });
                let (_, direction) = sight.line(place[0].into(), place[1].into());
                direction.as_vec3().to_array()
            }
        )
        .with(&["line_x", "line_y", "line_x_step", "line_y_step"])
        .on(|words| {
            within_range(&mut words[..2], 0.0, 4000.0);
            within_range(&mut words[2..4], -2.0, 2.0);
            within_range(&mut words[4..], 1e-4, 1e-2);
        })
        .within(SINGLE),
    ]
}

fn steps() -> Vec<Twin> {
    // The CPU computes the following in f64, the device in f32.
    const SINGLE: Tolerance = Tolerance::Absolute(1e-4);
    vec![
        // Pixels have aspect ratios of 1/2 to 2.
        twin!(
            picture_direction,
            SightLines::picture_direction,
            NORMAL_RAYS,
            |line: [f32; 3], tangent: [f32; 3], shape: f32| {
                let (sight, [x, y]) = sight(line, shape);
                let seen = sight.picture_direction(x, y, dvec(tangent));
                seen.unwrap_or_default().as_vec2().to_array()
            }
        )
        .with(&["pixel_shape"])
        .on(|words| {
            seen_vector(words);
            within_range(&mut words[6..], 0.5, 2.0);
        })
        .within(Tolerance::Absolute(5e-5)),
        // A surface seen edge-on recedes without end: single precision loses its distance.
        twin!(
            sight_lines_step,
            SightLines::step,
            NORMAL_RAYS,
            |normals: [f32; 3], line: [f32; 3], there: [f32; 3], _: [f32; 3]| {
                let (sight, from) = sight(line, 1.0);
                let (_, to) = self::sight(there, 1.0);
                let step = sight.step(from.into(), dvec(normals), to.into(), DVec3::ZERO);
                let offset = step.map_or([UNSPECIFIED; 3], |step| step.as_vec3().to_array());
                (step.is_some(), offset)
            }
        )
        .on(|words| {
            coarse(&mut words[..3], 2.0);
            sight_line(&mut words[3..6]);
            sight_line(&mut words[6..9]);
            let [normal, line, there] = [0, 3, 6].map(|at| Vec3::from(vector(&words[at..])));
            if normal.dot(there).abs() < 0.25 {
                set(words, &[0.0, 0.0, 1.0]);
            }
            set(&mut words[9..], &(there - line).to_array());
        })
        .within(SINGLE),
    ]
}

fn normal_rays() -> Vec<Twin> {
    // The CPU computes the following in f64, the device in f32.
    const SINGLE: Tolerance = Tolerance::Absolute(1e-4);
    vec![
        // A normal with its tangents, and the neighbour it is compared with.
        twin!(
            local_ray,
            Local::ray,
            NORMAL_RAYS,
            |step: (bool, [f32; 3]),
             there: [f32; 3],
             _: [f32; 3],
             normal: [f32; 3],
             tangents: [[f32; 3]; 2]| {
                let local = Local {
                    tangents: tangents.map(dvec),
                    normal: dvec(normal),
                };
                let ray = local.ray(&NormalRay {
                    is_there: step.0,
                    offset: dvec(step.1),
                    normal: dvec(there),
                });
                let placed = [ray.foot, ray.slope].map(|v| v.as_vec2().to_array());
                (ray.is_there, placed)
            }
        )
        .on(|words| {
            coarse(&mut words[1..4], 4.0);
            unit_vector(&mut words[4..7]);
            unit_vector(&mut words[10..13]);
            let [there, normal] = [4, 10].map(|at| Vec3::from(vector(&words[at..])));
            set(&mut words[7..10], &(there - normal).to_array());
            let (a, b) = normal.any_orthonormal_pair();
            set(&mut words[13..16], &a.to_array());
            set(&mut words[16..19], &b.to_array());
        })
        .within(SINGLE),
        // A missing ray is all 0.
        twin!(
            slopes_of,
            Slopes::of,
            NORMAL_RAYS,
            |rays: [(bool, [f32; 2], [f32; 2]); 4]| {
                let between = |before: usize, after: usize| {
                    let (a, b) = (&rays[before], &rays[after]);
                    let difference = |a: [f32; 2], b: [f32; 2]| {
                        DVec2::new(b[0].into(), b[1].into()) - DVec2::new(a[0].into(), a[1].into())
                    };
                    Difference {
                        foot: difference(a.1, b.1),
                        slope: difference(a.2, b.2),
                        samples: f64::from(u8::from(a.0 || b.0)),
                    }
                };
                let s = Slopes::of(&between(0, 1), &between(2, 3));
                let all = [s.mean, s.half_difference, s.off, s.area, s.spread];
                match s.is_there {
                    true => (true, all.map(|v| v as f32)),
                    false => (false, [UNSPECIFIED; 5]),
                }
            }
        )
        .on(|words| {
            for ray in words.chunks_mut(5) {
                coarse(&mut ray[1..], 2.0);
                if ray[0] == 0 {
                    ray.fill(0);
                }
            }
        })
        .within(Tolerance::Absolute(1e-3)),
    ]
}

fn tangents() -> Vec<Twin> {
    vec![
        twin!(
            any_orthonormal_pair,
            Vec3::any_orthonormal_pair,
            NORMAL_RAYS,
            |normal: [f32; 3]| {
                let (a, b) = Vec3::from(normal).any_orthonormal_pair();
                [a.to_array(), b.to_array()]
            }
        )
        .on(bounded),
    ]
}

fn strokes() -> Vec<Twin> {
    vec![
        twin!(
            share,
            share,
            STROKES,
            |wanted: f32, family: u32, families: u32| {
                share(wanted, family as usize, families as usize)
            }
        )
        .with(&["family", "families"]),
        // A texture has at least one texel, and its positions wrap.
        twin!(within, within, PICTURE_STROKES, |at: f32, size: u32| {
            let (first, next, share) = within(at, size as usize);
            (first as u32, next as u32, share)
        })
        .on(|words| {
            within_range(&mut words[..1], -4096.0, 4096.0);
            words[1] = words[1] % 4096 + 1;
        }),
        twin!(
            mix_of,
            mix,
            PICTURE_STROKES,
            |a: f32, b: f32, share: f32| { mix(a, b, share) }
        ),
        twin!(ramp_of, ramp_of, STROKES, |word: u32| ramp_of(word)),
        twin!(
            ramp_between,
            ramp_between,
            STROKES,
            |word: u32, across: f32| { ramp_between(word, across) }
        ),
        twin!(is_joined, is_joined, STROKES, |a: [f32; 2], b: [f32; 2]| {
            is_joined(a, b)
        }),
        twin!(
            slope,
            slope,
            STROKES,
            |here: [f32; 2], beside: [Option<[f32; 2]>; 2]| { slope(here, beside) }
        ),
        twin!(
            jacobian,
            jacobian,
            STROKES,
            |here: [f32; 2], beside: [Option<[f32; 2]>; 2], over: [Option<[f32; 2]>; 2]| {
                jacobian(here, beside, over)
            }
        ),
        twin!(
            in_texture,
            in_texture,
            STROKES,
            |by: [[f32; 2]; 2], t: [f32; 2]| in_texture(&by, t)
        ),
        twin!(is_one_depth, is_one_depth, STROKES, |a: f32, b: f32| {
            is_one_depth(a, b)
        }),
        twin!(
            is_one_motion,
            is_one_motion,
            STROKES,
            |a: [f32; 2], b: [f32; 2]| { is_one_motion(a, b) }
        ),
    ]
}
