//! Twins of lines and strokes.

use super::*;

pub(super) fn twins() -> Vec<Twin> {
    [
        contours(),
        directions(),
        fallbacks(),
        rays(),
        steps(),
        normal_rays(),
        tangents(),
        strokes(),
    ]
    .into_iter()
    .flatten()
    .collect()
}

fn contours() -> Vec<Twin> {
    vec![
        twin!(
            difference,
            crack::difference,
            CRACKS,
            |a: Option<f32>, b: Option<f32>| { crack::difference(a, b) }
        ),
        twin!(
            beyond_slopes,
            crack::beyond_slopes,
            CRACKS,
            |jump: f32, times: f32, slopes: [Option<f32>; 2]| crack::beyond_slopes(
                jump, times, slopes
            )
        ),
        twin!(steepness, crack::steepness, CRACKS, |slope: Option<f32>| {
            crack::steepness(slope)
        }),
        twin!(
            unexplained_jump,
            crack::unexplained_jump,
            CRACKS,
            |across: [Option<f32>; 6]| { crack::unexplained_jump(&across) }
        ),
        twin!(
            spread_offset,
            crack::spread_offset,
            CRACKS,
            |raw: [f32; 2], sharp: [f32; 2]| { crack::spread_offset(raw, sharp) }
        ),
        twin!(
            nearer_extreme,
            crack::nearer_extreme,
            CRACKS,
            |value: f32, least: f32, greatest: f32| crack::nearer_extreme(value, least, greatest)
        ),
        // Pictures and strokes up to a million pixels; half an output pixel lies within these sizes.
        twin!(
            round_stroke_coverage,
            RoundStroke::coverage,
            LINE_COVERAGE,
            |numbers: [f32; 8], p: [f32; 2]| RoundStroke::of_numbers(numbers).coverage(p.into())
        )
        .on(|words| {
            within_range(words, -1e6, 1e6);
            within_range(&mut words[7..8], 0.1, 1.0);
        }),
        twin!(unit, unit, LINE_COVERAGE, |high: u32| unit(
            u64::from(high) << 32
        )),
        twin!(
            grain,
            grain,
            LINE_COVERAGE,
            |x: i32, y: i32, low: u32, high: u32| {
                // The device receives the seed multiplied by an odd number, which spreads it over all bits; this is its
                // inverse.
                let spread = u64::from(high) << 32 | u64::from(low);
                grain(x, y, spread.wrapping_mul(0xf1de_83e1_9937_733d))
            }
        )
        .with(&["seed_low", "seed_high"]),
        twin!(
            graphite,
            graphite,
            LINE_COVERAGE,
            |coverage: f32, grain: f32| { graphite(coverage, grain) }
        )
        .on(bounded),
    ]
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

fn form([x, y, mean, _]: [f32; 4]) -> CurvatureTensor {
    CurvatureTensor {
        deviator: DVec2::new(x.into(), y.into()),
        mean: mean.into(),
    }
}

fn directions() -> Vec<Twin> {
    // The CPU computes the following in f64, the device in f32.
    const SINGLE: Tolerance = Tolerance::Absolute(2e-6);
    vec![
        twin!(doubled, doubled, SPREAD_DIRECTIONS, |t: [f32; 2]| doubled(
            t.into()
        )
        .to_array()),
        twin!(halved, halved, SPREAD_DIRECTIONS, |z: [f32; 2]| halved(z)),
        twin!(
            clear_direction,
            clear_direction,
            SPREAD_DIRECTIONS,
            |sum: [f32; 2], weight: f32| {
                clear_direction(sum.into(), weight)
                    .unwrap_or_default()
                    .to_array()
            }
        ),
        twin!(
            calm,
            calm,
            SETTLE_PATCHES,
            |own: [f32; 4], around: [f32; 4]| calm(own, around)
        )
        .on(bounded),
        twin!(
            curvature_tensor_larger,
            CurvatureTensor::larger,
            PATCH_DIRECTIONS,
            |f: [f32; 4]| { form(f).larger().unwrap_or_default().as_vec2().to_array() }
        )
        .on(|words| coarse(words, 4.0))
        .within(SINGLE),
        // A doubt is a share; where it almost vanishes, the precision of the shape decides.
        twin!(
            curvature_tensor_confidence,
            CurvatureTensor::confidence,
            PATCH_DIRECTIONS,
            |f: [f32; 4], doubt: f32| { form(f).confidence(doubt.into()) as f32 }
        )
        .with(&["doubt"])
        .on(|words| {
            coarse(&mut words[..4], 4.0);
            within_range(&mut words[4..], 1e-3, 1.0);
        })
        .within(SINGLE),
        // As above; zero is a separate case.
        twin!(
            curvature_tensor_flatness,
            CurvatureTensor::flatness,
            PATCH_DIRECTIONS,
            |f: [f32; 4], doubt: f32| { form(f).flatness(doubt.into()) as f32 }
        )
        .with(&["doubt"])
        .on(|words| {
            coarse(&mut words[..4], 4.0);
            within_range(&mut words[4..], 0.0, 1.0);
            each(&mut words[4..], |v| if v < 1e-3 { 0.0 } else { v });
        })
        .within(SINGLE),
    ]
}

fn fallbacks() -> Vec<Twin> {
    vec![
        // Pixels have aspect ratios of 1/2 to 2.
        twin!(
            fallback,
            FieldSetting::fallback,
            PATCH_DIRECTIONS,
            |line: [f32; 3],
             normal: [f32; 3],
             shape: f32,
             order: u32,
             is_fixed: u32,
             fixed: [f32; 2]| {
                let (sight, [x, y]) = sight(line, shape);
                let setting = FieldSetting {
                    fixed: (is_fixed == 1).then_some([Vec2::from(fixed); 2]),
                    sight,
                    pixels: 1.0,
                    cells: 1.0,
                    doubt: 1.0,
                    is_by_depth: false,
                };
                setting
                    .fallback(x, y, dvec(normal), order as usize)
                    .to_array()
            }
        )
        .with(&["pixel_shape", "order", "is_fixed", "fixed_x", "fixed_y"])
        .on(|words| {
            seen_vector(words);
            within_range(&mut words[6..7], 0.5, 2.0);
            words[7] &= 1;
        })
        .within(Tolerance::Absolute(5e-5)),
        // The same aspect ratios.
        twin!(
            fixed_direction,
            fixed_direction,
            PATCH_DIRECTIONS,
            |line: [f32; 3], normal: [f32; 3], order: u32, shape: f32| {
                let (sight, [x, y]) = sight(line, shape);
                let direction = match order {
                    0 => fixed_direction(dvec(normal), &sight, x, y),
                    _ => fixed_second_direction(dvec(normal), &sight, x, y),
                };
                direction.to_array()
            }
        )
        .with(&["pixel_shape"])
        .on(|words| {
            seen_vector(words);
            words[6] &= 1;
            within_range(&mut words[7..], 0.5, 2.0);
        })
        .within(Tolerance::Absolute(5e-5)),
    ]
}

fn rays() -> Vec<Twin> {
    // The CPU computes the following in f64, the device in f32.
    const SINGLE: Tolerance = Tolerance::Absolute(1e-4);
    vec![
        // Positions in a picture, and cameras with focal lengths of 100 to 10,000 pixels.
        twin!(
            line,
            SightLines::line,
            PATCH_DIRECTIONS,
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
        twin!(
            sight_lines_facing,
            SightLines::facing,
            PATCH_DIRECTIONS,
            |line: [f32; 3], normal: [f32; 3]| {
                let (sight, [x, y]) = sight(line, 1.0);
                sight.facing(x, y, dvec(normal)) as f32
            }
        )
        .on(seen_vector)
        .within(Tolerance::Absolute(1e-6)),
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
            PATCH_DIRECTIONS,
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
            PATCH_FORMS,
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
            PATCH_FORMS,
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
            PATCH_FORMS,
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
    // The CPU computes the following in f64, the device in f32.
    const SINGLE: Tolerance = Tolerance::Absolute(1e-4);
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
        // Directly behind the viewer a rounding turns the tangents.
        twin!(
            upright_tangents,
            upright_tangents,
            PATCH_FORMS,
            |normal: [f32; 3]| {
                match upright_tangents(dvec(normal)) {
                    Some(tangents) => (true, tangents.map(|t| t.as_vec3().to_array())),
                    None => (false, [[UNSPECIFIED; 3]; 2]),
                }
            }
        )
        .on(|words| {
            unit_vector(words);
            let [x, y, z] = vector(words);
            if z < -0.9 {
                let up = if x + y > 0.0 { 1.0 } else { -1.0 };
                set(words, &[0.0, 0.0, up]);
            }
        })
        .within(SINGLE),
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
