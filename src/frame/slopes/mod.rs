//! Slopes of depth, heights or positions: how values change from pixel to pixel, without their noise and rounding.
//!
//! Differences of neighbouring values are exact, and as noisy as the values are. Links between neighbours are broken at
//! steps, differences are smoothed along the links to ever larger widths, and each pixel takes the largest width that
//! contradicts no smaller one: Goldenshluger and Nemirovski's intersection of confidence intervals ("On spatially
//! adaptive estimation of nonparametric regression", Mathematical Methods of Statistics 6, 1997). Slopes are smoothed,
//! not values: a plane keeps its slope beside a step.

mod choice;
mod links;
mod noise;
mod smoothing;

use crate::frame::Plane;
use crate::frame::repair::unround_values;
use links::SurfaceLinks;
use noise::ValueNoise;

/// How values are rounded in the file that they come from.
pub(crate) enum Rounding<'a> {
    /// The distance of neighbouring codes; 0 for floats.
    Step(f32),
    /// The distance of the codes around a value.
    Of(&'a (dyn Fn(f32) -> f32 + Sync)),
}

/// Slopes of a plane of values.
pub(crate) struct Slopes {
    /// Change of the value per pixel to the right; 0 where not found.
    pub across: Plane,
    /// Change of the value per pixel down; 0 where not found.
    pub down: Plane,
    /// The pixels that have a neighbour on the same surface along both axes.
    pub found: Plane<bool>,
}

impl Slopes {
    /// Gives pixels that steps part from all others the slopes to their neighbours: heights seen from above hide nothing.
    pub(super) fn go_over_steps(&mut self, values: &Plane) {
        let (width, height) = (values.width(), values.height());
        let found = self.found.samples_mut().iter_mut().enumerate();
        for (i, found) in found.filter(|(i, found)| !**found && values.samples()[*i].is_finite()) {
            let (x, y) = (i % width, i / width);
            let at = |x: usize, y: usize| {
                let there = values.at(x.min(width - 1), y.min(height - 1));
                if there.is_finite() {
                    there
                } else {
                    values.at(i % width, i / width)
                }
            };
            self.across.samples_mut()[i] = 0.5 * (at(x + 1, y) - at(x.saturating_sub(1), y));
            self.down.samples_mut()[i] = 0.5 * (at(x, y + 1) - at(x, y.saturating_sub(1)));
            *found = true;
        }
    }
}

/// Values from here on are no samples: their squares have to be finite.
pub(crate) const TOO_LARGE: f32 = 1e15;

/// Noise and rounding up to this share of the values' median size need no smoothing: they turn normals by 0.1 degrees at
/// most, seen by a focal length of 1,000 pixels.
const FINE: f32 = 1e-6;

/// Most codes over all values whose rounding is undone before differences are taken: treads of 8-bit codes are wider than
/// slopes can be smoothed.
const FEW_CODES: f32 = 300.0;

/// The slopes of `values`, affine in x and y on planes, none as large as [`TOO_LARGE`]; NaN is no value, and breaks all links.
/// Values in few codes are moved to the smoothest ones.
pub(crate) fn slopes(values: &mut Plane, rounding: &Rounding) -> Slopes {
    let [width, height] = [values.width(), values.height()];
    if values.samples().is_empty() {
        let [across, down] = [(); 2].map(|()| Plane::filled(width, height, 0.0));
        let found = Plane::filled(width, height, false);
        return Slopes {
            across,
            down,
            found,
        };
    }
    let noise = ValueNoise::of(values, rounding);
    let links = SurfaceLinks::of(values, &noise);
    if let Rounding::Step(step) = *rounding
        && step > 0.0
    {
        without_treads(values, step);
    }
    let (mut slopes, found) = links::differences(values, &links);
    if !noise.is_below(FINE) {
        slopes = choice::choose(slopes, &links, &noise);
    }
    let [across, down] = slopes;
    Slopes {
        across,
        down,
        found,
    }
}

/// Moves values in few codes to the smoothest ones that round to these. Links, found before, keep them apart at steps.
fn without_treads(values: &mut Plane, step: f32) {
    let finite = values.samples().iter().filter(|value| value.is_finite());
    let [least, most] = finite.fold([f32::MAX, f32::MIN], |[a, b], &v| [a.min(v), b.max(v)]);
    if most - least > FEW_CODES * step {
        return;
    }
    // Gaps take the value on their left: what is smoothed across a gap or a step stays within half a step of its code.
    let mut filled = values.clone();
    filled.each_row(|_, row| {
        let first = row.iter().copied().find(|value| value.is_finite());
        row.iter_mut().fold(first.unwrap_or(least), |last, value| {
            *value = if value.is_finite() { *value } else { last };
            *value
        });
    });
    let mut smooth = with_margins(&filled);
    unround_values(&mut smooth, 0.5 * step, MARGIN);
    values.each_row(|y, row| {
        let smooth = &smooth.row(y + MARGIN)[MARGIN..];
        for (value, &smooth) in row.iter_mut().zip(smooth) {
            *value = if value.is_finite() { smooth } else { *value };
        }
    });
}

/// Pixels beyond the border that values are continued for before their rounding is undone: five standard deviations of
/// the widest neighbourhood.
const MARGIN: usize = 64;

/// Values next to a border that a line is fitted to.
const FITTED: usize = 32;

/// Values with margins, in which they go on as they came.
fn with_margins(values: &Plane) -> Plane {
    let mut wide = Plane::filled(values.width() + 2 * MARGIN, values.height(), 0.0);
    wide.each_row(|y, row| continue_line(row, values.row(y).iter().copied()));
    let mut turned = Plane::filled(values.height() + 2 * MARGIN, wide.width(), 0.0);
    turned.each_row(|x, row| {
        continue_line(row, (0..values.height()).map(|y| wide.at(x, y)));
    });
    Plane::of_pixels(turned.height(), turned.width(), |x, y| turned.at(y, x))
}

/// Writes a line with margins, in which it is turned by half a circle about the line that fits it next to the border.
fn continue_line(to: &mut [f32], line: impl Iterator<Item = f32>) {
    let inner = MARGIN..to.len() - MARGIN;
    to[inner.clone()]
        .iter_mut()
        .zip(line)
        .for_each(|(to, value)| *to = value);
    let most = inner.len() - 1;
    let first = at_border(to[inner.clone()].iter());
    let last = at_border(to[inner.clone()].iter().rev());
    for i in 1..=MARGIN {
        to[MARGIN - i] = 2.0 * first - to[MARGIN + i.min(most)];
        to[MARGIN + most + i] = 2.0 * last - to[MARGIN + most - i.min(most)];
    }
}

/// Where the line that fits the first of these values best begins.
fn at_border<'a>(values: impl Iterator<Item = &'a f32>) -> f32 {
    let near: Vec<_> = values.take(FITTED).copied().collect();
    let middle = 0.5 * (near.len() - 1) as f32;
    let mean = near.iter().sum::<f32>() / near.len() as f32;
    let [mut along, mut squares] = [0.0_f32; 2];
    for (i, value) in near.iter().enumerate() {
        let at = i as f32 - middle;
        along += at * (value - mean);
        squares += at * at;
    }
    mean - middle * along / squares.max(f32::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::Mask;
    use std::f32::consts::TAU;

    /// The slopes of the values within a mask.
    fn slopes_within(values: &Plane, valid: &Mask, rounding: &Rounding) -> Slopes {
        let within = |x, y| {
            let is_value = valid.at(x, y) && values.at(x, y).abs() < TOO_LARGE;
            if is_value { values.at(x, y) } else { f32::NAN }
        };
        slopes(
            &mut Plane::from_fn(values.width(), values.height(), within),
            rounding,
        )
    }

    #[test]
    fn a_height_that_steps_part_from_all_others_has_the_slopes_over_them() {
        // A ramp of 0.1 a column with a pixel 50 above it.
        let is_tower = |x, y| x == 10 && y == 8;
        let mut values = Plane::from_fn(21, 17, |x, y| {
            0.1 * x as f32 + if is_tower(x, y) { 50.0 } else { 0.0 }
        });
        let mut found = slopes(&mut values, &Rounding::Step(0.0));
        assert!(!found.found.at(10, 8) && found.found.at(9, 8));
        found.go_over_steps(&values);
        assert!(found.found.samples().iter().all(|&found| found));
        assert!((found.across.at(10, 8) - 0.1).abs() < 1e-6);
        assert_eq!(found.down.at(10, 8), 0.0);
        // It changes no other.
        assert!((found.across.at(9, 8) - 0.1).abs() < 1e-6);
    }

    /// Normally distributed numbers, to about four deviations, that depend on the place alone.
    fn noise_at(x: usize, y: usize) -> f32 {
        let mut state = (x as u64) << 32 | y as u64;
        let mut uniform = || {
            state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            (mixed >> 40) as f32 / (1 << 24) as f32 - 0.5
        };
        (0..12).map(|_| uniform()).sum()
    }

    /// Largest errors of slopes within these pixels.
    fn worst(found: &Slopes, exact: impl Fn(usize, usize) -> Option<[f32; 2]>) -> f32 {
        let (width, height) = (found.found.width(), found.found.height());
        let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
        pixels.fold(0.0, |worst: f32, (x, y)| {
            let Some([across, down]) = exact(x, y) else {
                return worst;
            };
            assert!(found.found.at(x, y), "{x} {y}");
            let errors = [found.across.at(x, y) - across, found.down.at(x, y) - down];
            worst.max(errors[0].abs()).max(errors[1].abs())
        })
    }

    #[test]
    fn planes_keep_their_slopes_beside_steps_and_gaps() {
        // Multiples of 1/4 are exact, and so are their differences; smoothing rounds sums of some hundred slopes.
        let is_gap = |x: usize, y: usize| x.abs_diff(20) + y.abs_diff(60) < 9;
        let far = |x: usize, y: usize| 2 * x + y > 120;
        let values = Plane::from_fn(80, 80, |x, y| {
            let [x, y, step] = [x as f32, y as f32, if far(x, y) { 40.0 } else { 0.0 }];
            0.25 * x - 0.5 * y + step
        });
        let valid = Mask::new(Plane::from_fn(80, 80, |x, y| !is_gap(x, y)));
        for (step, limit) in [(0.0, 0.0), (1.0 / 64.0, 1e-6)] {
            let found = slopes_within(&values, &valid, &Rounding::Step(step));
            let error = worst(&found, |x, y| (!is_gap(x, y)).then_some([0.25, -0.5]));
            assert!(error <= limit, "{step} {error}");
            assert!(!found.found.at(20, 60) && found.across.at(20, 60) == 0.0);
        }
    }

    #[test]
    fn a_sphere_has_its_slopes() {
        // z^2 = 100^2 - x^2 - y^2, whose slopes are -x / z. Central differences are off by a sixth of the third
        // derivative, 3 (x^2 + z^2) x / z^5: 9.2e-5 at x = 60. Values are rounded to 3.8e-6.
        let place = |x: usize, y: usize| [x as f32 - 70.0, y as f32 - 70.0];
        let height = |x, y| {
            place(x, y)
                .map(|a| a * a)
                .iter()
                .fold(1e4_f32, |z, a| z - a)
                .max(0.0)
                .sqrt()
        };
        let within = |x, y, radius: f32| place(x, y)[0].hypot(place(x, y)[1]) < radius;
        let values = Plane::from_fn(141, 141, height);
        let valid = Mask::new(Plane::from_fn(141, 141, |x, y| within(x, y, 62.0)));
        let found = slopes_within(&values, &valid, &Rounding::Step(0.0));
        let exact = |x, y| within(x, y, 60.0).then(|| place(x, y).map(|a| -a / height(x, y)));
        let error = worst(&found, exact);
        assert!(error < 9.2e-5 + 3.8e-6, "{error}");
    }

    #[test]
    fn a_wave_of_few_pixels_has_no_steps() {
        // Twelve pixels to a period and an amplitude of 2: slopes up to 1.05, of which central differences lose 1/22. Next
        // to the border a crest may look like a step.
        let wave = |x: usize, shift: f32| TAU / 12.0 * x as f32 + shift;
        for shift in [0.0, 0.1, 0.26, 0.4] {
            let values = Plane::from_fn(96, 12, |x, _| 2.0 * wave(x, shift).sin());
            let found = slopes_within(&values, &Mask::full(96, 12), &Rounding::Step(0.0));
            let exact = |x, _| (3..93).contains(&x).then(|| [wave(x, shift).cos(), 0.0]);
            let exact = |x, y| exact(x, y).map(|[p, q]| [p * TAU / 6.0, q]);
            let error = worst(&found, exact);
            assert!(error < 1.05 / 22.0, "{shift} {error}");
        }
    }

    #[test]
    fn a_plane_in_few_codes_has_its_slope() {
        // Values within half a step of a plane. A kernel K has a slope that is off by half a step times the total
        // variation of K, 2 K(0): 0.083 for a normal distribution with a deviation of 9.6 pixels.
        let step = 0.44 * 159.0 / 255.0;
        let values = Plane::from_fn(160, 160, |x, y| {
            ((0.31 * x as f32 + 0.13 * y as f32) / step).round() * step
        });
        let found = slopes_within(&values, &Mask::full(160, 160), &Rounding::Step(step));
        let inside = |x: usize| (30..130).contains(&x);
        let error = worst(&found, |x, y| {
            (inside(x) & inside(y)).then_some([0.31, 0.13])
        });
        assert!(error < 0.5 * step * 0.083, "{error} {step}");
    }

    #[test]
    fn treads_go_on_to_the_border() {
        // Values off by the root of 1/12 give a line through 32 of them a slope that is off by 32^-1.5, and the worst of some
        // hundred three times that.
        for (across, down) in [(0.06, 0.03), (0.1, -0.04), (0.02, 0.05), (0.03, 0.0)] {
            let values = |x, y| (across * x as f32 + down * y as f32 + 0.3).round();
            let values = Plane::from_fn(160, 120, values);
            let found = slopes_within(&values, &Mask::full(160, 120), &Rounding::Step(1.0));
            let error = worst(&found, |_, _| Some([across, down]));
            assert!(
                error < 3.0 * 32.0_f32.powf(-1.5),
                "{across} {down}: {error}"
            );
        }
    }

    #[test]
    fn noise_is_measured_and_smoothed_away() {
        let values = Plane::from_fn(160, 160, |x, y| {
            let wave = (x as f32 * 0.1).sin() * (y as f32 * 0.07).cos();
            3.0 * wave + 0.1 * noise_at(x, y)
        });
        // A median of 4,096 absolute values is known to 1.2 %, and the least of eight of them is 1.4 times that lower.
        let (whole, floats) = (Mask::full(160, 160), Rounding::Step(0.0));
        let noise = ValueNoise::of(&values, &floats).white;
        assert!((noise - 0.1).abs() < 0.005, "{noise}");
        let found = slopes_within(&values, &whole, &floats);
        // Differences have a deviation of 0.071; codes that are as coarse as the noise change little.
        let steps = slopes_within(&values, &Mask::full(160, 160), &Rounding::Of(&|_| 0.1));
        for found in [found, steps] {
            let exact = |x: usize, y: usize| 0.3 * (x as f32 * 0.1).cos() * (y as f32 * 0.07).cos();
            let inside = (8..152).flat_map(|y| (8..152).map(move |x| (x, y)));
            let squares = inside.map(|(x, y)| (found.across.at(x, y) - exact(x, y)).powi(2));
            let error = (squares.sum::<f32>() / 144.0_f32.powi(2)).sqrt();
            assert!(error < 0.25 * 0.071, "{error}");
        }
    }

    #[test]
    fn hostile_values_give_finite_slopes() {
        let hostile = [
            f32::NAN,
            f32::INFINITY,
            f32::NEG_INFINITY,
            3e38,
            -3e38,
            1e14,
            -1e14,
            0.0,
            1e-40,
        ];
        for (width, height) in [
            (0, 0),
            (0, 3),
            (3, 0),
            (1, 1),
            (1, 9),
            (9, 1),
            (2, 2),
            (17, 33),
            (40, 5),
        ] {
            for from in 0..hostile.len() + 1 {
                let values = Plane::from_fn(width, height, |x, y| match (x * 7 + y * 3) % 5 {
                    0 => hostile[(from + x + y) % hostile.len()],
                    _ => x as f32,
                });
                let valid = Mask::new(Plane::from_fn(width, height, |x, y| {
                    from > 0 && x + 2 * y != 4
                }));
                let steps: [Rounding; 5] = [
                    Rounding::Step(0.0),
                    Rounding::Step(0.5),
                    Rounding::Step(f32::NAN),
                    Rounding::Of(&|value| 1e-3 / (value * value)),
                    Rounding::Of(&|value| if value > 2.0 { f32::INFINITY } else { -1.0 }),
                ];
                for step in &steps {
                    let slopes = slopes_within(&values, &valid, step);
                    let mut all = slopes.across.samples().iter().chain(slopes.down.samples());
                    assert!(
                        all.all(|slope| slope.is_finite()),
                        "{width} {height} {from}"
                    );
                    let found = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
                    let mut found = found.filter(|&(x, y)| slopes.found.at(x, y));
                    assert!(
                        found.all(|(x, y)| valid.at(x, y) && values.at(x, y).abs() < TOO_LARGE)
                    );
                }
            }
        }
    }
}
