//! Radiance scaling of light that a file tells apart: lobes, light groups, ambient occlusion.
//!
//! Theory: [RS] sections 5.1 and 5.3 give each lobe a reflectance mapping and a magnitude of its own, and
//! section 5.4 scales each sample of a light inside the sum. Changes: a rendered lobe is its own mapping,
//! its light over a white level, as the two prefiltered forms of section 5.3 are; and a light group, whose
//! sum is finished, is given the mean scaling of the samples it stands for. Practice: every term adds what
//! it changes to one sum, and the picture takes that at the end, so that what no layer tells of stays as it
//! is, and so does a picture of which nothing changes.

use super::radiance_scaling::scaling;
use crate::shape::curvature::{mapped_curvature, mapped_curvature_toward};

/// No picture holds more; the sum of a few of these, scaled as far as [`scaling`] goes, is still finite.
const MAX_RADIANCE: f32 = 1e11;

/// Colours darker than this say nothing of the light that they reflect.
const MIN_ALBEDO: f32 = 1e-3;

/// Three rows of one colour.
pub type ColorRow<'a> = [&'a [f32]; 3];

/// A row of the layers of a lobe. What is absent is a row of zeros, an absent colour one of ones.
#[derive(Debug, Clone, Copy)]
pub struct LobeRow<'a> {
    /// Light from lights.
    pub direct: ColorRow<'a>,
    /// Light from other surfaces.
    pub indirect: ColorRow<'a>,
    /// What light is multiplied by to be seen.
    pub color: ColorRow<'a>,
    /// What light has been multiplied by already.
    pub albedo: ColorRow<'a>,
}

impl LobeRow<'_> {
    /// The first `width` columns: what the compiler has to know to leave out its checks.
    #[inline(always)]
    fn first(&self, width: usize) -> Self {
        Self {
            direct: self.direct.map(|row| &row[..width]),
            indirect: self.indirect.map(|row| &row[..width]),
            color: self.color.map(|row| &row[..width]),
            albedo: self.albedo.map(|row| &row[..width]),
        }
    }

    /// Luminance at column `x` of the light before it takes the surface's colour: a dark surface in bright
    /// light counts as bright.
    #[inline(always)]
    pub fn luminance(&self, x: usize, weights: [f32; 3]) -> f32 {
        let (mut light, mut albedo) = (0.0, 0.0);
        for i in 0..3 {
            light += weights[i] * (self.direct[i][x] + self.indirect[i][x]);
            albedo += weights[i] * self.albedo[i][x];
        }
        light / albedo.max(MIN_ALBEDO)
    }
}

/// How a term of the light is scaled.
#[derive(Debug, Clone, Copy)]
pub struct TermScaling {
    /// Magnitude gamma.
    pub magnitude: f32,
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
    fn sigma(&self, luminance: f32, kappa: f32) -> f32 {
        // Of a bad value the first limit makes 0.
        let intensity = (luminance / self.white).max(0.0).min(1.0);
        scaling(intensity, self.magnitude * kappa, self.invariant_point)
    }
}

/// A row of mapped curvature.
#[inline(always)]
pub fn kappa_row(kappa: &mut [f32], trace: &[f32], gain: f32) {
    for (kappa, &trace) in kappa.iter_mut().zip(trace) {
        *kappa = mapped_curvature(trace, gain);
    }
}

/// A row of mapped curvature for light from `l_xy`, from a row of the Hessian [xx, xy, yy].
#[inline(always)]
pub fn kappa_toward_row(
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
pub fn lobe_sigma_row(sigma: &mut [f32], lobe: &LobeRow, kappa: &[f32], by: &TermScaling) {
    let width = sigma.len();
    let lobe = lobe.first(width);
    let kappa = &kappa[..width];
    for x in 0..width {
        sigma[x] = by.sigma(lobe.luminance(x, by.weights), kappa[x]);
    }
}

/// Adds one direction of a light group to two sums: of `n.l` where it is above 0, and of `n.l` scaled.
#[inline(always)]
pub fn add_direction_row(
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

/// The scaling of a light group: that of its directions on the whole, 1 where all are below the horizon.
/// Shadows are in the group and not in the directions, so they keep their shape ([RS] section 5.4).
#[inline(always)]
pub fn group_sigma_row(sigma: &mut [f32], plain: &[f32], scaled: &[f32]) {
    let width = sigma.len();
    let (plain, scaled) = (&plain[..width], &scaled[..width]);
    for x in 0..width {
        let mean = scaled[x] / plain[x].max(f32::MIN_POSITIVE);
        sigma[x] = if plain[x] > 0.0 { mean } else { 1.0 };
    }
}

/// Adds to one channel of two sums: of what `sigma` changes of the radiance `(direct + indirect) * color`,
/// and of that radiance.
#[inline(always)]
pub fn add_change_row(
    change: &mut [f32],
    told: &mut [f32],
    [direct, indirect, color]: [&[f32]; 3],
    sigma: &[f32],
) {
    let width = change.len();
    let (told, sigma) = (&mut told[..width], &sigma[..width]);
    let (direct, indirect, color) = (&direct[..width], &indirect[..width], &color[..width]);
    for x in 0..width {
        let radiance = (direct[x] + indirect[x]) * color[x];
        // Of a bad value the first limit makes 0.
        let radiance = radiance.max(0.0).min(MAX_RADIANCE);
        change[x] += (sigma[x] - 1.0) * radiance;
        told[x] += radiance;
    }
}

/// One channel of the picture with the changes made to it; its own bits where uncovered or unchanged.
///
/// Layers that tell of more light than the picture has, by a lossy compression or because they belong to
/// another one, change it by the picture's share only: nothing that was 0 or more falls below 0.
#[inline(always)]
pub fn changed_row(out: &mut [f32], from: &[f32], change: &[f32], told: &[f32], covered: &[bool]) {
    let width = out.len();
    let (from, covered) = (&from[..width], &covered[..width]);
    let (change, told) = (&change[..width], &told[..width]);
    for x in 0..width {
        let c = from[x];
        let share = (c.max(0.0) / told[x].max(f32::MIN_POSITIVE)).min(1.0);
        let changed = (c + share * change[x]).clamp(-f32::MAX, f32::MAX);
        let changes = covered[x] & (change[x] != 0.0);
        out[x] = if changes { changed } else { c };
    }
}

/// Scales a row of colours by ambient occlusion: the intensity of light from everywhere is the share of it
/// that arrives ([RS] section 5.3.1 and figure 8 b).
#[inline(always)]
pub fn occlude_row(
    [r, g, b]: [&mut [f32]; 3],
    occlusion: &[f32],
    kappa: &[f32],
    covered: &[bool],
    by: &TermScaling,
) {
    let width = kappa.len();
    let (r, g, b) = (&mut r[..width], &mut g[..width], &mut b[..width]);
    let (occlusion, covered) = (&occlusion[..width], &covered[..width]);
    for x in 0..width {
        let sigma = by.sigma(occlusion[x], kappa[x]);
        let changes = covered[x] & (kappa[x] != 0.0);
        let scaled = |c: f32| {
            let scaled = (c * sigma).clamp(-f32::MAX, f32::MAX);
            if changes { scaled } else { c }
        };
        (r[x], g[x], b[x]) = (scaled(r[x]), scaled(g[x]), scaled(b[x]));
    }
}
