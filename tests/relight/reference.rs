//! The papers' equations in double precision, one pixel and one light at a time, as printed (with the
//! corrections of the crate's documentation), sharing no code with the program.

use glam::{DMat2, DVec2, DVec3};
use relievo::params::{Material, MaterialParams, Method, ScalingParams};

/// What is known of a pixel.
pub(crate) struct Pixel {
    pub(crate) normal: DVec3,
    pub(crate) to_eye: DVec3,
    /// Tangent along the grain.
    pub(crate) along: DVec3,
    /// [xx, xy, yy], convex negative.
    pub(crate) hessian: [f64; 3],
}

pub(crate) struct Settings<'a> {
    pub(crate) method: Method,
    /// Strength of the warp: alpha of [LW].
    pub(crate) alpha: f64,
    pub(crate) gain: f64,
    pub(crate) scaling: &'a ScalingParams,
    pub(crate) material: &'a MaterialParams,
}

/// Lambda of [LW] section 5 by its eigenvectors.
fn lambda(h: [f64; 3], alpha: f64) -> DMat2 {
    let (mean, half) = ((h[0] + h[2]) / 2.0, (h[0] - h[2]) / 2.0);
    let spread = half.hypot(h[1]);
    let angle = 0.5 * h[1].atan2(half);
    let (u, v) = (DVec2::from_angle(angle), DVec2::from_angle(angle).perp());
    let factor = |k: f64| ((alpha * k).atan() / 6.0 + std::f64::consts::FRAC_PI_4).tan();
    let outer = |d: DVec2, by: f64| DMat2::from_cols(by * d.x * d, by * d.y * d);
    outer(u, factor(mean + spread)) + outer(v, factor(mean - spread))
}

/// W with the matrix `lambda`, in stereographic coordinates as printed.
pub(crate) fn warp(l: DVec3, lambda: DMat2) -> DVec3 {
    let p = lambda * (l.truncate() / (1.0 + l.z));
    let square = p.length_squared();
    DVec3::new(2.0 * p.x, 2.0 * p.y, 1.0 - square) / (1.0 + square)
}

/// The Jacobian of the inverse at l'.
fn jacobian(l: DVec3, lambda: DMat2) -> f64 {
    let p = l.truncate() / (1.0 + l.z);
    let q = lambda.inverse() * p;
    ((1.0 + p.length_squared()) / (1.0 + q.length_squared())).powi(2) / lambda.determinant()
}

/// sigma, as printed but for the sign of the exponent.
fn sigma(d: f64, x: f64, a: f64) -> f64 {
    let (d, e) = (d.clamp(0.0, 1.0), (-x).exp());
    (a * e + d * (1.0 - a - a * e)) / (a + d * (e - a - a * e))
}

/// Anisotropic mapping of curvature, in the frame of principal directions as printed.
fn kappa(h: [f64; 3], l: DVec3, gain: f64, anisotropy: f64) -> f64 {
    let (mean, half) = ((h[0] + h[2]) / 2.0, (h[0] - h[2]) / 2.0);
    let spread = half.hypot(h[1]);
    let u = DVec2::from_angle(0.5 * h[1].atan2(half));
    let (lu, lv) = (l.truncate().dot(u), l.truncate().dot(u.perp()));
    let (sum, difference) = (2.0 * mean, 2.0 * spread);
    let along = (sum + anisotropy * difference) * lu * lu
        + (sum - anisotropy * difference) * lv * lv
        + sum * l.z * l.z;
    (-gain * along).tanh()
}

/// What a light of 1 from `light` adds: diffusely, specularly.
pub(crate) fn reflected(pixel: &Pixel, light: DVec3, s: &Settings) -> [f64; 2] {
    let lambda = match s.method.warps() {
        true => lambda(pixel.hessian, s.alpha),
        false => DMat2::IDENTITY,
    };
    let l = warp(light, lambda.inverse());
    let n = pixel.normal;
    let nl = n.dot(l);
    if nl <= 0.0 || n.dot(light) <= 0.0 {
        return [0.0; 2];
    }
    let weight = jacobian(light, lambda);
    let (e, m) = (pixel.to_eye, s.material);
    let h = (l + e).normalize();
    let eta = f64::from(m.shininess);
    // Intensities, and what is reflected of them.
    let (intensities, lobes) = match m.material {
        Material::Lambert | Material::Toon => ([nl, 0.0], [nl, 0.0]),
        Material::Sublambert => {
            let flat = nl.powf(f64::from(m.flatness));
            ([flat, 0.0], [flat, 0.0])
        }
        Material::Phong => {
            let r = 2.0 * n.dot(e) * n - e;
            let lobe = r.dot(l).max(0.0).powf(eta);
            ([nl, lobe], [nl, lobe])
        }
        Material::BlinnPhong => {
            let lobe = n.dot(h).max(0.0).powf(eta);
            ([nl, lobe], [nl, nl * lobe])
        }
        Material::AshikhminShirley => {
            let ne = n.dot(e).max(0.0);
            let rs = f64::from(m.reflectance);
            let passed = |c: f64| 1.0 - (1.0 - c / 2.0).powi(5);
            let base = 28.0 / 23.0 * (1.0 - rs) * passed(nl) * passed(ne) * nl;
            let [nu, nv] = m.coat.map(f64::from);
            let (hu, hv, hn) = (h.dot(pixel.along), h.dot(n.cross(pixel.along)), h.dot(n));
            let exponent = (nu * hu * hu + nv * hv * hv) / (1.0 - hn * hn).max(1e-300);
            let fresnel = rs + (1.0 - rs) * (1.0 - h.dot(e)).powi(5);
            let coat = ((nu + 1.0) * (nv + 1.0)).sqrt() / 8.0 * hn.powf(exponent) * fresnel
                / (h.dot(e) * nl.max(ne))
                * nl;
            ([nl, hn], [base, coat])
        }
        Material::Mirror | Material::Glass => unreachable!("no light is summed on these"),
    };
    let magnitudes = s.scaling.magnitudes();
    let kappa = kappa(pixel.hessian, l, s.gain, f64::from(s.scaling.anisotropy));
    let scaled = |term: usize, gamma: f32| match s.method.scales() {
        true => {
            let x = f64::from(gamma) * kappa;
            sigma(intensities[term], x, f64::from(s.scaling.invariant_point))
        }
        false => 1.0,
    };
    [
        weight * lobes[0] * scaled(0, magnitudes.diffuse),
        weight * lobes[1] * scaled(1, magnitudes.specular),
    ]
}
