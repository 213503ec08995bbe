//! Radiance scaling of light layers: lobes, light groups, ambient occlusion.
//!
//! Theory: [RS] sections 5.1 and 5.3 give each lobe its own reflectance mapping and magnitude, and section 5.4 scales
//! each sample of a light inside the sum. Changes: a rendered lobe is its own mapping, its light over a white level,
//! like the two prefiltered forms of section 5.3; and a light group, whose sum is finished, gets the mean scaling of
//! the samples it stands for. Practice: every term adds its change to one sum, which is applied to the picture at the
//! end, so that light in no layer stays unchanged, and so does a picture without changes.

pub(crate) mod cpu;
#[cfg(test)]
mod levels;
pub(crate) mod stage;
pub(crate) mod terms;

use super::radiance_scaling::{limited, scaling};
use crate::params::Magnitude;
use crate::shape::curvature::{mapped_curvature, mapped_curvature_toward};

/// Largest radiance of a picture; the sum of a few of these, scaled by the largest [`scaling`], is still finite.
pub(crate) const MAX_RADIANCE: f32 = 1e11;

/// Darker colours carry no information about the light they reflect.
pub(crate) const MIN_ALBEDO: f32 = 1e-3;

/// Three rows of one colour.
pub(crate) type ColorRow<'a> = [&'a [f32]; 3];

/// A row of the layers of a lobe. Absent light is a row of zeros, an absent colour a row of ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LobeRow<'a> {
    /// Light from lights.
    pub direct: ColorRow<'a>,
    /// Light from other surfaces.
    pub indirect: ColorRow<'a>,
    /// The factor that multiplies the light as displayed.
    pub color: ColorRow<'a>,
    /// The factor already included in the light.
    pub albedo: ColorRow<'a>,
}

impl LobeRow<'_> {
    /// The first `width` columns: a length known to the compiler removes bounds checks.
    #[inline(always)]
    fn first(&self, width: usize) -> Self {
        Self {
            direct: self.direct.map(|row| &row[..width]),
            indirect: self.indirect.map(|row| &row[..width]),
            color: self.color.map(|row| &row[..width]),
            albedo: self.albedo.map(|row| &row[..width]),
        }
    }

    /// Luminance at column `x` of the light before multiplication by the surface's colour: a dark surface in bright
    /// light counts as bright.
    #[inline(always)]
    pub(crate) fn luminance(&self, x: usize, weights: [f32; 3]) -> f32 {
        let (mut light, mut albedo) = (0.0, 0.0);
        for (i, weight) in weights.into_iter().enumerate() {
            light += weight * (self.direct[i][x] + self.indirect[i][x]);
            albedo += weight * self.albedo[i][x];
        }
        light / albedo.max(MIN_ALBEDO)
    }
}

/// Scaling of a term of the light.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TermScaling {
    /// Magnitude gamma.
    pub magnitude: Magnitude,
    /// Invariant point alpha.
    pub invariant_point: f32,
    /// Luminance of light that counts as intensity 1.
    pub white: f32,
    /// Weights of red, green and blue in luminance.
    pub weights: [f32; 3],
}

impl TermScaling {
    /// The scaling of a luminance.
    #[inline(always)]
    pub(crate) fn sigma(&self, luminance: f32, kappa: f32) -> f32 {
        let intensity = limited(luminance / self.white, 1.0);
        scaling(
            intensity,
            self.magnitude.exponent(kappa),
            self.invariant_point,
        )
    }
}

/// A row of mapped curvature.
#[inline(always)]
pub(crate) fn kappa_row(kappa: &mut [f32], trace: &[f32], gain: f32) {
    for (kappa, &trace) in kappa.iter_mut().zip(trace) {
        *kappa = mapped_curvature(trace, gain);
    }
}

/// A row of mapped curvature for light from `l_xy`, from a row of the Hessian [xx, xy, yy].
#[inline(always)]
pub(crate) fn kappa_toward_row(
    kappa: &mut [f32],
    hessian: [&[f32]; 3],
    l_xy: [f32; 2],
    gain: f32,
    anisotropy: f32,
) {
    let width = kappa.len();
    let [xx, xy, yy] = hessian.map(|row| &row[..width]);
    for x in 0..width {
        let h = [xx[x], xy[x], yy[x]];
        kappa[x] = mapped_curvature_toward(h, l_xy, gain, anisotropy);
    }
}

/// The scaling of a lobe: its intensity is its own light over the white level ([RS] section 5.3).
#[inline(always)]
pub(crate) fn lobe_sigma_row(sigma: &mut [f32], lobe: &LobeRow, kappa: &[f32], by: &TermScaling) {
    let width = sigma.len();
    let lobe = lobe.first(width);
    let kappa = &kappa[..width];
    for x in 0..width {
        sigma[x] = by.sigma(lobe.luminance(x, by.weights), kappa[x]);
    }
}

/// Adds one direction of a light group to two sums: of positive `n.l`, and of `n.l` scaled.
#[inline(always)]
pub(crate) fn add_direction_row(
    plain: &mut [f32],
    scaled: &mut [f32],
    normal: [&[f32]; 3],
    to_light: [f32; 3],
    kappa: &[f32],
    by: &TermScaling,
) {
    let width = plain.len();
    let (scaled, kappa) = (&mut scaled[..width], &kappa[..width]);
    let [nx, ny, nz] = normal.map(|row| &row[..width]);
    let [lx, ly, lz] = to_light;
    for x in 0..width {
        let facing = (nx[x] * lx + ny[x] * ly + nz[x] * lz).max(0.0);
        plain[x] += facing;
        scaled[x] += facing * by.sigma(facing, kappa[x]);
    }
}

/// The scaling of a light group: the mean over its directions, 1 where all are below the horizon. Shadows are in the
/// group and not in the directions, so they keep their shape ([RS] section 5.4).
#[inline(always)]
pub(crate) fn group_sigma_row(sigma: &mut [f32], plain: &[f32], scaled: &[f32]) {
    let width = sigma.len();
    let (plain, scaled) = (&plain[..width], &scaled[..width]);
    for x in 0..width {
        let mean = scaled[x] / plain[x].max(f32::MIN_POSITIVE);
        sigma[x] = if plain[x] > 0.0 { mean } else { 1.0 };
    }
}

/// Adds to one channel of two sums: the change of the radiance `(direct + indirect) * color` by `sigma`, and that
/// radiance.
#[inline(always)]
pub(crate) fn add_change_row(
    change: &mut [f32],
    layered: &mut [f32],
    [direct, indirect, color]: [&[f32]; 3],
    sigma: &[f32],
) {
    let width = change.len();
    let (layered, sigma) = (&mut layered[..width], &sigma[..width]);
    let (direct, indirect, color) = (&direct[..width], &indirect[..width], &color[..width]);
    for x in 0..width {
        let radiance = limited((direct[x] + indirect[x]) * color[x], MAX_RADIANCE);
        change[x] += (sigma[x] - 1.0) * radiance;
        layered[x] += radiance;
    }
}

/// One channel of the picture with the changes applied; its own bits where uncovered or unchanged.
///
/// If layers hold more light than the picture, due to lossy compression or because they belong to another picture, the
/// change is reduced to the picture's share: non-negative values stay non-negative.
#[inline(always)]
pub(crate) fn changed_row(
    out: &mut [f32],
    from: &[f32],
    change: &[f32],
    layered: &[f32],
    covered: &[bool],
) {
    let width = out.len();
    let (from, covered) = (&from[..width], &covered[..width]);
    let (change, layered) = (&change[..width], &layered[..width]);
    for x in 0..width {
        let changed = changed(from[x], change[x], layered[x]);
        out[x] = if covered[x] { changed } else { from[x] };
    }
}

/// The channel `c` of a picture after `change`, computed for layers of radiance `layered`: the change is reduced to the
/// picture's share of their light.
#[inline(always)]
pub(crate) fn changed(c: f32, change: f32, layered: f32) -> f32 {
    let share = (c.max(0.0) / layered.max(f32::MIN_POSITIVE)).min(1.0);
    let changed = (c + share * change).clamp(-f32::MAX, f32::MAX);
    if change != 0.0 { changed } else { c }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::radiance_scaling::scaling;

    const GREY: [f32; 3] = crate::frame::ColorPlanes::REC709_LUMINANCE;

    fn by(magnitude: f32, white: f32) -> TermScaling {
        TermScaling {
            magnitude: Magnitude::of_both(magnitude),
            invariant_point: 0.25,
            white,
            weights: GREY,
        }
    }

    #[test]
    fn a_dark_surface_in_bright_light_counts_as_bright() {
        let row = |v: f32| [v; 2];
        let (light, none, dark, seen) = (row(0.8), row(0.0), row(0.1), row(0.08));
        let ones = row(1.0);
        let kappa = [0.7, -0.4];
        let sigma = |direct: &[f32], color: &[f32], albedo: &[f32]| {
            let lobe = LobeRow {
                direct: [direct; 3],
                indirect: [&none; 3],
                color: [color; 3],
                albedo: [albedo; 3],
            };
            let mut sigma = [0.0; 2];
            lobe_sigma_row(&mut sigma, &lobe, &kappa, &by(1.0, 1.0));
            sigma
        };
        // Light 0.8 on an albedo of 0.1, as two layers or as one: intensity 0.8 in both cases.
        let expected = kappa.map(|k| scaling(0.8, k, 0.25));
        let near = |a: [f32; 2]| assert!(a.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-5));
        near(sigma(&light, &dark, &ones));
        near(sigma(&seen, &ones, &dark));
    }

    #[test]
    fn an_area_light_is_scaled_by_its_samples() {
        // n = z; samples at cosines 0.8 and 0.6, and one below the horizon that is ignored.
        let normal: [&[f32]; 3] = [&[0.0], &[0.0], &[1.0]];
        let (mut plain, mut scaled, mut sigma) = ([0.0], [0.0], [0.0]);
        for to_light in [[0.6, 0.0, 0.8], [0.0, 0.8, 0.6], [0.6, 0.0, -0.8]] {
            let term = by(1.5, 1.0);
            add_direction_row(&mut plain, &mut scaled, normal, to_light, &[0.5], &term);
        }
        group_sigma_row(&mut sigma, &plain, &scaled);
        let of = |d: f32| d * scaling(d, 0.75, 0.25);
        let expected = (of(0.8) + of(0.6)) / 1.4;
        assert!(
            (sigma[0] - expected).abs() < 1e-6,
            "{} is not {expected}",
            sigma[0]
        );
        group_sigma_row(&mut sigma, &[0.0], &[0.0]);
        assert_eq!(sigma, [1.0]);
    }

    #[test]
    fn layers_brighter_than_the_picture_take_no_more_than_there_is() {
        // A picture of 0.5 whose layers add up to 2, all to be removed: the result is 0, not -1.5.
        let made = |from: f32, change: f32, layered: f32| {
            let mut out = [f32::NAN];
            changed_row(&mut out, &[from], &[change], &[layered], &[true]);
            out[0]
        };
        assert_eq!(made(0.5, -2.0, 2.0), 0.0);
        assert_eq!(made(0.5, -1.0, 2.0), 0.25);
        // Layers with less light than the picture change it in full; values of 0 and below stay.
        assert_eq!(made(0.5, 0.25, 0.25), 0.75);
        assert_eq!(made(0.0, 3.0, 2.0), 0.0);
        assert_eq!(made(-0.5, 3.0, 2.0), -0.5);
        // No change preserves even the sign of 0.
        assert_eq!(made(-0.0, 0.0, 1.0).to_bits(), (-0.0_f32).to_bits());
    }

    #[test]
    fn bad_light_is_no_light() {
        for bad in [f32::NAN, f32::NEG_INFINITY, -1.0] {
            let (mut change, mut layered) = ([0.0], [0.0]);
            add_change_row(&mut change, &mut layered, [&[bad], &[0.0], &[1.0]], &[3.0]);
            assert_eq!((change, layered), ([0.0], [0.0]));
        }
        let (mut change, mut layered, mut out) = ([0.0], [0.0], [0.0]);
        let most = scaling(1.0, 1e9, 0.25);
        for _ in 0..3 {
            add_change_row(
                &mut change,
                &mut layered,
                [&[f32::INFINITY], &[0.0], &[1.0]],
                &[most],
            );
        }
        changed_row(&mut out, &[2.0], &change, &layered, &[true]);
        assert!(out[0].is_finite(), "{}", out[0]);
    }
}
