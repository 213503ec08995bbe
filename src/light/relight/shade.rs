//! Lighting of one batch: prepare, sum, look up, compose. Plain loops over lanes, compiled for the vectors of the
//! machine.

use crate::frame::{Gloss, luminance};
use crate::light::albedo::AlbedoEstimate;
use crate::light::batch::{BATCH, Lanes, Term, at, put};
use crate::light::brdf::mirrored;
use crate::light::cosines::scalar_product;
use crate::light::environment::Environment;
use crate::light::light_warping::{MOST_BRIGHTENED, contrast};
use crate::light::lights::PointLight;
use crate::light::radiance_scaling::ScalingCurve;
use crate::light::relight::batch::{Batch, GlossLanes};
use crate::light::relight::look_up::{add_lookups, add_mirrored, look_up, warp_lookups};
use crate::light::relight::scene::Scene;
use crate::light::sum::{Shading, Sums};
use crate::light::tones::tone_factor;
use crate::params::Tangent;
use crate::plan::Albedo;
use crate::shape::curvature::mapped_curvature;

/// One over the reflectance below which a surface mirrors less at grazing angles too: no clear matter reflects less.
const ANY_GLOSS: f32 = 50.0;

/// Lights the pixels of a batch.
#[inline(always)]
pub(crate) fn light_batch(batch: &mut Batch, scene: &Scene) {
    prepare(batch, scene);
    batch.sum.sums = Sums::NONE;
    add_lights(batch, scene);
    compose(batch, scene);
}

/// Prepares the light-independent state of the pixels.
#[inline(always)]
fn prepare(batch: &mut Batch, scene: &Scene) {
    let relighting = scene.relighting;
    if scene.eye.is_some() {
        normalise_eyes(batch);
    }
    if scene.frame.alpha.is_some() && matches!(relighting.albedo, Albedo::Layer | Albedo::Picture) {
        demodulate(batch, scene.gloss.is_some());
    }
    if let Some(estimate) = &scene.estimate {
        estimate_albedo(batch, estimate);
    }
    let Batch { pixels, grain, .. } = batch;
    for i in 0..BATCH {
        let (n, eye) = (pixels.normal.at(i), pixels.to_eye.at(i));
        pixels.mirrored.set(i, mirrored(n, eye));
    }
    let material = &scene.params().material;
    let has_grain = scene.around.sampled().is_some();
    if has_grain || material.material.has_coat() {
        let fixed = match material.tangent {
            Tangent::Degrees(angle) => angle.to_radians(),
            Tangent::Curvature => 0.0,
        };
        let fixed = [fixed.cos(), fixed.sin()];
        let faces_eye = material.material.glows_about_mirrored_view();
        pixels.set_tangents(faces_eye, |i| match scene.grain {
            Some(_) => [grain[0][i], grain[1][i]],
            None => fixed,
        });
    }
    if relighting.warps {
        pixels.warp_by(relighting.params.warping.warp * scene.gain);
    }
    pixels.find_facing();
    if relighting.scales || relighting.lit_spheres == 2 {
        set_curves(batch, scene);
    }
}

/// Mapped curvature, and the scaling curve of every term.
#[inline(always)]
fn set_curves(batch: &mut Batch, scene: &Scene) {
    let Batch { pixels, kappa, .. } = batch;
    let [xx, _, yy] = &pixels.hessian;
    for i in 0..BATCH {
        kappa[i] = mapped_curvature(xx[i] + yy[i], scene.gain);
    }
    let magnitudes = scene.magnitudes;
    let magnitudes = [magnitudes.ambient, magnitudes.diffuse, magnitudes.specular];
    for (curves, magnitude) in pixels.curves.iter_mut().zip(magnitudes) {
        for (i, &kappa) in kappa.iter().enumerate() {
            curves.set(i, ScalingCurve::of(magnitude * kappa));
        }
    }
}

/// Divides layers by coverage, which the result is multiplied by once more.
#[inline(always)]
fn demodulate(batch: &mut Batch, has_gloss: bool) {
    for i in 0..BATCH {
        let covered = batch.alpha[i] > 0.0;
        batch.share[i] = if covered { 1.0 / batch.alpha[i] } else { 1.0 };
    }
    let own = has_gloss.then_some(&mut batch.gloss.reflectance);
    for lanes in batch.albedo.iter_mut().chain(own.into_iter().flatten()) {
        multiply(lanes, &batch.share);
    }
}

/// Turns the picture's colours into the albedo estimated from them.
#[inline(always)]
fn estimate_albedo(batch: &mut Batch, estimate: &AlbedoEstimate) {
    for i in 0..BATCH {
        let cover = batch.alpha[i];
        let per_cover = if cover > 0.0 { 1.0 / cover } else { 0.0 };
        let bare = at(&batch.albedo, i).map(|channel| channel * per_cover);
        let albedo = estimate.at(batch.pixels.normal.at(i), bare);
        put(&mut batch.albedo, i, albedo);
    }
}

#[inline(always)]
fn normalise_eyes(batch: &mut Batch) {
    let [x, y, z] = &mut batch.pixels.to_eye.vector;
    for i in 0..BATCH {
        let inverse = 1.0 / (x[i] * x[i] + y[i] * y[i] + 1.0).sqrt();
        x[i] *= inverse;
        y[i] *= inverse;
        z[i] = inverse;
    }
}

/// The sum over single lights; first as gloss mirrors them, but for those that stand for an environment, which it looks up.
#[inline(always)]
fn add_lights(batch: &mut Batch, scene: &Scene) {
    if scene.relighting.gloss {
        batch.gloss.sums = Sums::NONE;
    }
    if let Some(shading) = &scene.mirror_shading {
        add_lamps(batch, scene, shading);
        std::mem::swap(&mut batch.gloss.sums, &mut batch.sum.sums);
    }
    let Some(shading) = &scene.shading else {
        return;
    };
    // Light from all around comes first: occlusion dims only that.
    let sampled = scene.around.sampled();
    let base = sampled.map(|_| &scene.base_lights[..]);
    let Batch { pixels, sum, .. } = batch;
    sum.add_around(pixels, shading, (&scene.around_lights, base));
    if let Some((environment, share)) = scene.around.looked_up() {
        for direction in scene.around.even_directions() {
            let direction = direction.to_array();
            if batch.pixels.facing.may_see(direction) {
                look_even_up(batch, scene, environment, direction, share);
                batch.sum.add_by_lane(&batch.pixels, shading, &batch.lamp);
            }
        }
    }
    if scene.frame.light.occlusion.is_some() {
        for lanes in &mut batch.sum.sums.diffuse {
            multiply(lanes, &batch.occlusion);
        }
    }
    add_lamps(batch, scene, shading);
    if let Some(sampled) = sampled {
        sampled.samples.add(&batch.pixels, &mut batch.sum, shading);
    }
}

/// Adds lights far away and near.
#[inline(always)]
fn add_lamps(batch: &mut Batch, scene: &Scene, shading: &Shading) {
    let Batch { pixels, sum, .. } = batch;
    sum.add_directed(pixels, shading, &scene.lights);
    for point in scene.points {
        approach(batch, point);
        batch.sum.add_by_lane(&batch.pixels, shading, &batch.lamp);
    }
}

/// Directions to a light near the surface, and its attenuation.
#[inline(always)]
fn approach(batch: &mut Batch, light: &PointLight) {
    let lamp = &mut batch.lamp;
    let [x, y, z] = light.position.to_array();
    for i in 0..BATCH {
        let [from_x, from_y, from_z] = at(&batch.points, i);
        let to = [x - from_x, y - from_y, z - from_z];
        let square = scalar_product(to, to);
        // A light on the surface itself has no direction.
        let apart = square > f32::MIN_POSITIVE;
        let inverse = if apart { 1.0 / square } else { 0.0 };
        let per_length = inverse.sqrt();
        let direction = to.map(|component| component * per_length);
        put(&mut lamp.direction, i, direction);
        lamp.share[i] = inverse;
    }
    lamp.rgb = light.intensity.map(|channel| [channel; BATCH]);
}

/// One of the even directions, with the light looked up where it is warped to ([LW] equation 1), and cosines limited by
/// [`MOST_BRIGHTENED`].
#[inline(always)]
fn look_even_up(
    batch: &mut Batch,
    scene: &Scene,
    environment: &Environment,
    direction: [f32; 3],
    even_share: f32,
) {
    batch.lamp.direction = direction.map(|component| [component; BATCH]);
    batch.toward = batch.lamp.direction;
    warp_lookups(batch, scene);
    look_up(
        &mut batch.lamp.rgb,
        environment,
        &batch.toward,
        batch.pixels.count,
    );
    for i in 0..BATCH {
        let n = batch.pixels.normal.at(i);
        let cosine = scalar_product(n, direction);
        let held = (MOST_BRIGHTENED * scalar_product(n, at(&batch.toward, i))).max(0.0);
        let is_limited = scene.relighting.warps && held < cosine;
        batch.lamp.share[i] = even_share * if is_limited { held / cosine } else { 1.0 };
    }
}

/// Combines the terms: gains, contrast, tones, coverage.
#[inline(always)]
fn compose(batch: &mut Batch, scene: &Scene) {
    let material = &scene.params().material;
    let (kd, ks) = (material.diffuse_gain, material.specular());
    if scene.mirrors.is_some() || scene.around.has_lookups() {
        add_lookups(batch, scene);
    }
    let scales = scene.relighting.scales && material.ambient > 0.0;
    let ambient = batch.pixels.curve(Term::Ambient);
    let alpha = scene.invariant_point;
    for i in 0..BATCH {
        // The intensity of ambient light is 1 in the open ([RS] section 5.1), else the occlusion.
        let open = batch.occlusion[i];
        let sigma = if scales {
            ambient.at(i).at(open, alpha)
        } else {
            1.0
        };
        batch.share[i] = material.ambient * open * sigma;
    }
    for (shown, diffuse) in batch.shown.iter_mut().zip(&batch.sum.sums.diffuse) {
        for i in 0..BATCH {
            shown[i] = batch.share[i] + kd * diffuse[i];
        }
    }
    if scene.relighting.contrasts {
        enhance_contrast(batch, scene);
    }
    // Toon quantises the light; for other materials the visible colour is quantised.
    let is_toon = material.material.has_toned_light();
    if is_toon {
        quantize_tones(batch, scene);
    }
    if scene.relighting.gloss && material.material.has_highlight() {
        part_highlights(batch);
    }
    for k in 0..3 {
        for i in 0..BATCH {
            let specular = ks * batch.sum.sums.specular[k][i];
            batch.shown[k][i] = batch.albedo[k][i] * batch.shown[k][i] + specular;
        }
    }
    if scene.relighting.gloss {
        add_gloss(batch, scene, material.specular_gain.unwrap_or(1.0));
    }
    if !is_toon {
        quantize_tones(batch, scene);
    }
    for lanes in &mut batch.shown {
        for (shown, &alpha) in lanes.iter_mut().zip(&batch.alpha) {
            *shown = premultiplied(*shown, alpha);
        }
    }
    if scene.gloss.is_some() {
        for (lanes, kept) in batch.shown.iter_mut().zip(&batch.gloss.kept) {
            for i in 0..BATCH {
                lanes[i] = (lanes[i] + kept[i]).clamp(-f32::MAX, f32::MAX);
            }
        }
    }
}

/// Leaves the highlights of the material to surfaces with a diffuse colour, and those of gloss to the others.
#[inline(always)]
fn part_highlights(batch: &mut Batch) {
    for i in 0..BATCH {
        batch.share[i] = Gloss::share_diffuse(at(&batch.albedo, i));
    }
    for lanes in &mut batch.sum.sums.specular {
        multiply(lanes, &batch.share);
    }
    for lanes in &mut batch.gloss.reflectance {
        for (own, share) in lanes.iter_mut().zip(&batch.share) {
            *own *= 1.0 - share;
        }
    }
}

/// Adds new light that surfaces mirror by their own gloss. At grazing angles all of it is mirrored, unless there is no gloss.
#[inline(always)]
fn add_gloss(batch: &mut Batch, scene: &Scene, gain: f32) {
    add_mirrored(batch, scene);
    let GlossLanes {
        sums, reflectance, ..
    } = &batch.gloss;
    let [r, g, b] = reflectance;
    for i in 0..BATCH {
        batch.share[i] = (ANY_GLOSS * r[i].max(g[i]).max(b[i])).clamp(0.0, 1.0);
    }
    let light = sums.diffuse.iter().zip(&sums.specular);
    let of_channel = batch.shown.iter_mut().zip(reflectance).zip(light);
    for ((shown, own), (facing, grazing)) in of_channel {
        for i in 0..BATCH {
            shown[i] += gain * (own[i] * facing[i] + batch.share[i] * grazing[i]);
        }
    }
}

/// Contrast by curvature ([LW] equation 3), for diffuse and specular light.
#[inline(always)]
fn enhance_contrast(batch: &mut Batch, scene: &Scene) {
    let gamma = scene.params().warping.contrast;
    for i in 0..BATCH {
        // The contrast of a warp is the reciprocal of that of its inverse.
        batch.share[i] = contrast(batch.pixels.inverse_warp(i), -gamma);
    }
    for lanes in batch.shown.iter_mut().chain(&mut batch.sum.sums.specular) {
        multiply(lanes, &batch.share);
    }
}

/// Quantises the colours so far, if a number of tones is given.
#[inline(always)]
fn quantize_tones(batch: &mut Batch, scene: &Scene) {
    let Some((tones, most)) = scene.tones else {
        return;
    };
    for i in 0..BATCH {
        let shown = at(&batch.shown, i);
        let factor = tone_factor(luminance(shown, scene.luminance), tones, most);
        put(&mut batch.shown, i, shown.map(|channel| channel * factor));
    }
}

#[inline(always)]
fn multiply(lanes: &mut Lanes, factors: &Lanes) {
    for (lane, factor) in lanes.iter_mut().zip(factors) {
        *lane *= factor;
    }
}

/// A channel times coverage, clamped to finite values.
#[inline(always)]
pub(crate) fn premultiplied(shown: f32, coverage: f32) -> f32 {
    (shown * coverage).clamp(-f32::MAX, f32::MAX)
}
