//! Relighting in double precision, one pixel and one light at a time: the reference of single-precision sums.
//!
//! The papers' equations as printed, with the corrections documented in the kernels, and sharing no code with them:
//! directions are warped in stereographic coordinates by eigenvectors, and the scaling is the printed fraction. It
//! starts from the backend's Hessian and gain, so that it shows the error of lighting alone.

use crate::frame::{Frame, Plane, SymmetricPlanes};
use crate::light::environment::Environment;
use crate::light::lights::DirectionalLight;
use crate::params::{
    Adaptive, AlbedoSource, Magnitude, Material, MaterialParams, Method, RelightParams,
    SampleCount, ScalingParams, Tangent,
};
use glam::{DMat2, DVec2, DVec3};
use std::f64::consts::{FRAC_PI_4, PI};

/// A pixel to light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Unit normal.
    pub normal: DVec3,
    /// Unit direction to the eye.
    pub to_eye: DVec3,
    /// Unit tangent along the grain.
    pub along: DVec3,
    /// Hessian xx, xy, yy; convex negative.
    pub hessian: [f64; 3],
}

/// Lighting parameters.
#[derive(Debug, Clone, Copy)]
pub struct Settings<'a> {
    /// Lighting method.
    pub method: Method,
    /// Strength of the warp: alpha of [LW], in pixels.
    pub alpha: f64,
    /// Gain of the mapped curvature, in pixels.
    pub gain: f64,
    /// Radiance scaling.
    pub scaling: &'a ScalingParams,
    /// Material of the surface.
    pub material: &'a MaterialParams,
}

/// White of one material with gains of 1, without ambient light.
pub fn white(material: Material, method: Method, samples: SampleCount) -> RelightParams {
    RelightParams {
        method,
        samples,
        albedo: AlbedoSource::White,
        environment_gain: Adaptive::Fixed(1.0),
        material: MaterialParams {
            material,
            ambient: 0.0,
            diffuse_gain: 1.0,
            specular_gain: Some(1.0),
            tangent: Tangent::Degrees(0.0),
            ..MaterialParams::default()
        },
        ..RelightParams::default()
    }
}

impl Pixel {
    /// A light with a smaller cosine to the normal, in magnitude, may be on either side of the horizon in single precision,
    /// where lobes without a cosine factor end in a step.
    pub const HORIZON: f64 = 1e-5;

    /// The pixel at column `x`, row `y`, of a frame with this Hessian, of the height in pixels, with the grain at `grain_deg` degrees in
    /// the picture.
    pub fn of(
        frame: &Frame,
        hessian: &SymmetricPlanes,
        [x, y]: [usize; 2],
        grain_deg: f64,
    ) -> Self {
        let at = |plane: &Plane| f64::from(plane.at(x, y));
        let n = &frame.normal;
        let normal = DVec3::new(at(&n.x), at(&n.y), at(&n.z));
        let [left, top] = [frame.data_window.x0, frame.data_window.y0].map(f64::from);
        let eye = frame.camera.map_or(DVec2::ZERO, |camera| {
            let (px, py) = (left + x as f64 + 0.5, top + y as f64 + 0.5);
            camera.projection.to_eye(px, py)
        });
        let grain = DVec2::from_angle(grain_deg.to_radians()).extend(0.0);
        Self {
            normal,
            to_eye: eye.extend(1.0).normalize(),
            along: (grain - normal * grain.dot(normal)).normalize_or_zero(),
            hessian: [at(&hessian.xx), at(&hessian.xy), at(&hessian.yy)],
        }
    }
}

/// Mean and half the difference of the principal curvatures, and the direction of the larger.
fn principal(h: [f64; 3]) -> (f64, f64, DVec2) {
    let (mean, half) = ((h[0] + h[2]) / 2.0, (h[0] - h[2]) / 2.0);
    let angle = 0.5 * h[1].atan2(half);
    (mean, half.hypot(h[1]), DVec2::from_angle(angle))
}

/// Lambda of [LW] section 5 by its eigenvectors.
fn lambda(h: [f64; 3], alpha: f64) -> DMat2 {
    let (mean, spread, u) = principal(h);
    let factor = |k: f64| ((alpha * k).atan() / 6.0 + FRAC_PI_4).tan();
    let outer = |d: DVec2, by: f64| DMat2::from_cols(by * d.x * d, by * d.y * d);
    outer(u, factor(mean + spread)) + outer(u.perp(), factor(mean - spread))
}

/// The direction `l` warped by the matrix `lambda`, in stereographic coordinates as printed: undefined for -z.
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

/// The scaling of intensity `d` ([RS] equation 2), as printed except for the sign of the exponent `x`.
pub fn sigma(d: f64, x: f64, a: f64) -> f64 {
    let (d, e) = (d.clamp(0.0, 1.0), (-x).exp());
    (a * e + d * (1.0 - a - a * e)) / (a + d * (e - a - a * e))
}

/// The mapping of curvature toward the light ([RS] section 4), in the frame of principal directions.
fn kappa(h: [f64; 3], l: DVec3, gain: f64, anisotropy: f64) -> f64 {
    let (mean, spread, u) = principal(h);
    let (lu, lv) = (l.truncate().dot(u), l.truncate().dot(u.perp()));
    let (sum, difference) = (2.0 * mean, 2.0 * spread);
    let along = (sum + anisotropy * difference) * lu * lu
        + (sum - anisotropy * difference) * lv * lv
        + sum * l.z * l.z;
    (-gain * along).tanh()
}

/// A light incident at one pixel.
struct IncidentLight {
    /// The unwarped direction.
    direction: DVec3,
    /// Ratio of solid angles after and before warping.
    weight: f64,
    /// Its cosine with the normal, at most four times that of the light as given.
    cosine: f64,
}

fn incident(pixel: &Pixel, light: DVec3, s: &Settings) -> IncidentLight {
    let n = pixel.normal;
    if !s.method.warps() {
        return IncidentLight {
            direction: light,
            weight: 1.0,
            cosine: n.dot(light),
        };
    }
    let lambda = lambda(pixel.hessian, s.alpha);
    let direction = warp(light, lambda.inverse());
    IncidentLight {
        direction,
        weight: jacobian(light, lambda),
        cosine: n.dot(direction).min(4.0 * n.dot(light)),
    }
}

/// Diffuse and specular reflection of a light of intensity 1 from `light`.
///
/// # Panics
/// For mirrors and glass, which are not lit by sums over lights.
pub fn reflected(pixel: &Pixel, light: DVec3, s: &Settings) -> [f64; 2] {
    shone(pixel, &incident(pixel, light, s), s)
}

fn shone(pixel: &Pixel, incident: &IncidentLight, s: &Settings) -> [f64; 2] {
    if incident.cosine <= 0.0 {
        return [0.0; 2];
    }
    let (intensities, lobes) = lobes(pixel, incident, s.material);
    let magnitudes = s.scaling.magnitudes();
    let scaled = |term: usize, magnitude: Magnitude| match s.method.scales() {
        true => {
            let anisotropy = s.scaling.anisotropy.into();
            let kappa = kappa(pixel.hessian, incident.direction, s.gain, anisotropy);
            let gamma = match kappa >= 0.0 {
                true => magnitude.convex,
                false => magnitude.concave,
            };
            let x = f64::from(gamma) * kappa;
            sigma(intensities[term], x, s.scaling.invariant_point.into())
        }
        false => 1.0,
    };
    [
        incident.weight * lobes[0] * scaled(0, magnitudes.diffuse),
        incident.weight * lobes[1] * scaled(1, magnitudes.specular),
    ]
}

/// Intensities of the diffuse and the specular lobe, and the light reflected by them.
fn lobes(pixel: &Pixel, incident: &IncidentLight, m: &MaterialParams) -> ([f64; 2], [f64; 2]) {
    let (n, e) = (pixel.normal, pixel.to_eye);
    let (l, nl) = (incident.direction, incident.cosine);
    let h = (l + e).normalize();
    let eta = f64::from(m.shininess);
    match m.material {
        Material::Lambert | Material::Toon => ([nl, 0.0], [nl, 0.0]),
        Material::Sublambert => {
            let flat = nl.powf(m.flatness.into());
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
    }
}

/// The colour of a white pixel under `lights`; `None` if one of them is so close to its horizon that single precision
/// may place it on the other side.
pub fn lit(pixel: &Pixel, lights: &[DirectionalLight], s: &Settings) -> Option<[f64; 3]> {
    let gains = [s.material.diffuse_gain, s.material.specular()].map(f64::from);
    let mut sum = [0.0; 3];
    for light in lights {
        // Directions are unit vectors only up to f32 rounding.
        let direction = light.to_light.as_dvec3().normalize();
        let incident = incident(pixel, direction, s);
        if incident.cosine.abs() < Pixel::HORIZON {
            return None;
        }
        let [diffuse, specular] = shone(pixel, &incident, s);
        let shown = gains[0] * diffuse + gains[1] * specular;
        for (sum, intensity) in sum.iter_mut().zip(light.intensity) {
            *sum += f64::from(intensity) * shown;
        }
    }
    Some(sum)
}

/// Irradiance over pi at a surface with unit normal `n`: a sum over all pixels of the map by solid angle.
pub fn irradiance(environment: &Environment, n: DVec3) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for y in 0..environment.height() {
        let share = environment.solid_angle(y) / PI;
        for x in 0..environment.width() {
            let cosine = n.dot(environment.direction(x, y).as_dvec3());
            if cosine > 0.0 {
                for (sum, radiance) in sum.iter_mut().zip(environment.pixel(x, y)) {
                    *sum += share * cosine * f64::from(radiance);
                }
            }
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(normal: DVec3, hessian: [f64; 3]) -> Pixel {
        Pixel {
            normal: normal.normalize(),
            to_eye: DVec3::Z,
            along: DVec3::X,
            hessian,
        }
    }

    #[test]
    fn closed_forms_are_met() {
        let base = RelightParams::default().material;
        let material = MaterialParams {
            material: Material::Phong,
            shininess: 3.0,
            ..base
        };
        let scaling = ScalingParams::default();
        let settings = |method| Settings {
            method,
            alpha: 20.0,
            gain: 10.0,
            scaling: &scaling,
            material: &material,
        };
        // Facing the eye, light at 60 degrees: n.l = r.l = 1/2.
        let flat = pixel(DVec3::Z, [0.0; 3]);
        let light = DVec3::new(0.75_f64.sqrt(), 0.0, 0.5);
        let close = |found: [f64; 2], expected: [f64; 2]| {
            let off = |i: usize| (found[i] - expected[i]).abs();
            assert!(off(0) < 1e-12 && off(1) < 1e-12, "{found:?} {expected:?}");
        };
        for method in [Method::Plain, Method::Warp, Method::Scale, Method::Both] {
            close(reflected(&flat, light, &settings(method)), [0.5, 0.125]);
        }
        // A ball of radius 20: alpha k = -1, lambda = tan(pi/4 - pi/24). The unwarped light is at twice the angle whose
        // tangent is tan(30 degrees) / lambda.
        let ball = pixel(DVec3::Z, [-0.05, 0.0, -0.05]);
        let factor = (5.0 * PI / 24.0).tan();
        let angle = 2.0 * ((PI / 6.0).tan() / factor).atan();
        // Ratio of solid angles there and here: sin(a) da / (sin(b) db), with tan(a/2) = tan(b/2) / lambda.
        let spread = angle.sin().powi(2) / (PI / 3.0).sin().powi(2);
        let expected = [spread * angle.cos(), spread * angle.cos().powi(3)];
        close(reflected(&ball, light, &settings(Method::Warp)), expected);
        // gain x trace = -1, so x = tanh 1; the invariant point is not scaled.
        assert!((sigma(0.25, 1.0_f64.tanh(), 0.25) - 1.0).abs() < 1e-12);
        assert!((sigma(1.0, 1.5, 0.25) - 1.5_f64.exp()).abs() < 1e-12);
        let x = 1.0_f64.tanh();
        let expected = [0.5 * sigma(0.5, x, 0.25), 0.125 * sigma(0.125, x, 0.25)];
        close(reflected(&ball, light, &settings(Method::Scale)), expected);
    }

    #[test]
    fn half_a_sphere_gives_its_irradiance() {
        // White above the horizon: (1 + n.y) / 2.
        let map = Environment::from_fn(128, 64, |_, y| [if y < 32 { 1.0 } else { 0.0 }; 3]);
        for n in [DVec3::Y, DVec3::X, DVec3::new(0.48, 0.6, 0.64)] {
            let found = irradiance(&map, n)[0];
            assert!((found - (1.0 + n.y) / 2.0).abs() < 1e-3, "{n}: {found}");
        }
    }
}
