//! Lighting of one batch: prepare, sum, look up, compose. Plain loops over lanes, compiled for the vectors of the
//! machine.

use crate::frame::{Gloss, luminance};
use crate::light::albedo::AlbedoEstimate;
use crate::light::batch::{Above, BATCH, Facing, Lanes, Term};
use crate::light::brdf::mirrored;
use crate::light::environment::Environment;
use crate::light::light_warping::{MOST_BRIGHTENED, Warp, contrast};
use crate::light::radiance_scaling::ScalingCurve;
use crate::light::relight::batch::{Batch, GlossLanes};
use crate::light::relight::curvature::CurvedBy;
use crate::light::relight::look_up::{add_lookups, add_mirrored, look_up, warp_lookups};
use crate::light::relight::scene::{Aligned, LitScene};
use crate::light::relight::setting::Albedo;
use crate::light::shadows::cast::Shadowed;
use crate::light::sum::lobes::Lobes;
use crate::light::sum::{Directed, LightSums, Shading};
use crate::light::tones::tone_factor;
use crate::params::{Magnitude, Tangent};
use crate::shape::coarse_normals::normal_at;
use crate::shape::curvature::mapped_curvature;

/// One over the reflectance below which a surface mirrors less at grazing angles too: no clear matter reflects less.
const ANY_GLOSS: f32 = 50.0;

/// Number of lights from which computing the box of the batch's normals pays off.
const WORTH_A_BOX: usize = 4;

/// Lights the pixels of a batch.
#[inline(always)]
pub(crate) fn light_batch(fma: bool, batch: &mut Batch, scene: &LitScene) {
    prepare(batch, scene);
    batch.sum.clear();
    add_lights(fma, batch, scene);
    compose(batch, scene);
}

/// Prepares the light-independent state of the pixels.
#[inline(always)]
fn prepare(batch: &mut Batch, scene: &LitScene) {
    let relighting = scene.relighting;
    if scene.eye.is_some() {
        normalise_eyes(batch);
    }
    if scene.shadows.horizons.is_some() {
        batch.find_sky();
    }
    if scene.frame.alpha.is_some() && matches!(relighting.albedo, Albedo::Layer | Albedo::Picture) {
        demodulate(batch, scene.gloss.is_some());
    }
    if let Some(estimate) = &scene.estimate {
        estimate_albedo(batch, estimate);
    }
    let lobes = scene.shading.map(|shading| shading.lobes);
    let phong = relighting
        .params
        .material
        .material
        .glows_about_mirrored_view();
    if phong || scene.around.is_mirrored() {
        for i in 0..BATCH {
            let (n, eye) = (batch.pixels.normal.at(i), batch.pixels.to_eye.at(i));
            batch.pixels.mirrored.set(i, mirrored(n, eye));
        }
    }
    let samples = scene.around.sampled().is_some();
    if samples || matches!(lobes, Some(Lobes::AshikhminShirley(_))) {
        let fixed = match scene.params().material.tangent {
            Tangent::Degrees(angle) => angle.to_radians(),
            Tangent::Curvature => 0.0,
        };
        let (sine, cosine) = fixed.sin_cos();
        let Batch { pixels, grain, .. } = batch;
        let grain = |i: usize| match scene.grain {
            Some(_) => [grain[0][i], grain[1][i]],
            None => [cosine, sine],
        };
        pixels.set_tangents(phong, grain);
    }
    if let Some(lobes) = lobes {
        lobes.see(&mut batch.pixels);
    }
    if relighting.warps {
        let pixels = &mut batch.pixels;
        pixels.warp_by(relighting.params.warping.warp * scene.gain);
        let mirror = scene.mirror_shading.map(|shading| shading.lobes);
        for lobes in lobes.into_iter().chain(mirror) {
            lobes.unwarp_axes(pixels);
        }
    }
    if scene.aligned.is_some() {
        find_details(batch);
    }
    if relighting.scales {
        set_curves(batch, scene);
    } else if relighting.lit_spheres == 2 {
        find_kappa(batch, scene);
    }
    let around = &scene.around;
    let lights = scene.lights.len()
        + scene.shadows.far.len()
        + scene.around_lights.len()
        + scene.base_lights.len();
    let directions = lights + around.even_directions().len();
    if directions >= WORTH_A_BOX {
        let pixels = &mut batch.pixels;
        pixels.facing = Facing::of(&pixels.normal.vector, pixels.count);
    }
}

/// What the normals at each scale have beyond those of the next coarser one.
#[inline(always)]
fn find_details(batch: &mut Batch) {
    let Batch {
        pixels,
        coarse,
        details,
        ..
    } = batch;
    let mut normal = pixels.normal.vector;
    for (detail, place) in details.iter_mut().zip(&*coarse) {
        let mut base = normal;
        for i in 0..BATCH {
            let [x, y, z] = normal_at([place[0][i], place[1][i]]);
            (base[0][i], base[1][i], base[2][i]) = (x, y, z);
        }
        detail.find(&normal, &base);
        normal = base;
    }
}

/// Mapped curvature.
#[inline(always)]
fn find_kappa(batch: &mut Batch, scene: &LitScene) {
    let Batch {
        pixels,
        trace,
        kappa,
        ..
    } = batch;
    if matches!(scene.curvature, Some(CurvedBy::Hessian(_))) {
        let [xx, _, yy] = &pixels.hessian;
        for i in 0..BATCH {
            trace[i] = xx[i] + yy[i];
        }
    }
    for i in 0..BATCH {
        kappa[i] = mapped_curvature(trace[i], scene.gain);
    }
}

/// The scaling curve of every active term; terms of equal magnitude share one.
#[inline(always)]
fn set_curves(batch: &mut Batch, scene: &LitScene) {
    find_kappa(batch, scene);
    let magnitudes = scene.magnitudes;
    let terms = [
        (magnitudes.ambient, scene.params().material.ambient > 0.0),
        (magnitudes.diffuse, true),
        (magnitudes.specular, scene.is_glossy),
    ];
    let mut done: Option<(Magnitude, usize)> = None;
    for (term, (magnitude, used)) in terms.into_iter().enumerate() {
        if !used {
            continue;
        }
        match done {
            Some((same, of)) if same == magnitude => {
                batch.pixels.curve_of[term] = of;
            }
            _ => {
                let curves = &mut batch.pixels.curves[term];
                for i in 0..BATCH {
                    curves.set(i, ScalingCurve::of(magnitude.exponent(batch.kappa[i])));
                }
                batch.pixels.curve_of[term] = term;
                done = Some((magnitude, term));
            }
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
        for (albedo, per_cover) in lanes.iter_mut().zip(&batch.share) {
            *albedo *= per_cover;
        }
    }
}

/// Turns the picture's colours into the albedo estimated from them.
#[inline(always)]
fn estimate_albedo(batch: &mut Batch, estimate: &AlbedoEstimate) {
    let [r, g, b] = &mut batch.albedo;
    for i in 0..BATCH {
        let cover = batch.alpha[i];
        let per_cover = if cover > 0.0 { 1.0 / cover } else { 0.0 };
        let bare = [r[i] * per_cover, g[i] * per_cover, b[i] * per_cover];
        [r[i], g[i], b[i]] = estimate.at(batch.pixels.normal.at(i), bare);
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
fn add_lights(fma: bool, batch: &mut Batch, scene: &LitScene) {
    if scene.relighting.gloss {
        batch.gloss.sums = LightSums::NONE;
    }
    if let Some(shading) = &scene.mirror_shading {
        add_lamps(fma, batch, scene, shading);
        std::mem::swap(&mut batch.gloss.sums, &mut batch.sum.sums);
    }
    let Some(shading) = &scene.shading else {
        return;
    };
    if let Some(aligned) = &scene.aligned {
        add_turned(fma, batch, scene, shading, aligned);
        return;
    }
    // Light from all around comes first: occlusion dims only that.
    let sampled = scene.around.sampled();
    add_around(fma, batch, scene, shading, &scene.around_lights);
    if sampled.is_some() {
        batch.sum.sums.diffuse = LightSums::NONE.diffuse;
        add_around(fma, batch, scene, &shading.diffuse(), &scene.base_lights);
    }
    if let Some((environment, share)) = scene.around.looked_up() {
        for direction in scene.around.even_directions() {
            let direction = direction.to_array();
            if batch.pixels.facing.above(direction) == Above::Nowhere {
                continue;
            }
            look_even_up(batch, scene, environment, direction, share);
            if scene.shadows.horizons.is_some() {
                batch.hide_looked_up(direction);
            }
            let Batch {
                pixels,
                sum,
                looked_up,
                ..
            } = batch;
            sum.add_looked_up(pixels, shading, direction, looked_up);
        }
    }
    dim(batch, scene);
    add_lamps(fma, batch, scene, shading);
    add_samples(batch, scene, shading);
}

/// Adds highlights of an environment that samples stand for, less what horizons hide of them.
#[inline(always)]
fn add_samples(batch: &mut Batch, scene: &LitScene, shading: &Shading) {
    if let Some(sampled) = scene.around.sampled() {
        let hiding = scene.shadows.horizons.as_ref().map(|_| &batch.horizons);
        sampled
            .samples
            .add(&batch.pixels, &mut batch.sum, shading, hiding);
    }
}

/// Adds lights that stand for an environment, less what horizons hide of each.
#[inline(always)]
fn add_around(
    fma: bool,
    batch: &mut Batch,
    scene: &LitScene,
    shading: &Shading,
    lights: &[Directed],
) {
    if scene.shadows.horizons.is_none() {
        batch.sum.add_directed(fma, &batch.pixels, shading, lights);
    } else {
        each_around(batch, scene, lights, (shading, None));
    }
}

/// How light is shaded, and how it is turned before, if it is.
type HowLit<'a> = (&'a Shading, Option<&'a Aligned>);

/// Lets the light of each of these arrive, less what horizons hide, and adds it.
#[inline(always)]
fn each_around(batch: &mut Batch, scene: &LitScene, lights: &[Directed], how: HowLit) {
    for light in lights {
        batch.face(light.direction);
        match scene.shadows.of_key(light.direction) {
            Some(share) => batch.shade(share),
            None if scene.shadows.horizons.is_some() => batch.hide(light.direction),
            None => {}
        }
        add_arriving(batch, how, light.intensity);
    }
}

/// Takes what a layer of occlusion hides off the diffuse light added so far, unless horizons have.
#[inline(always)]
fn dim(batch: &mut Batch, scene: &LitScene) {
    if scene.occlusion.is_some() && scene.shadows.horizons.is_none() {
        batch.sum.dim(&batch.occlusion);
    }
}

/// The sum over single lights, where each is turned to the form; highlights are those of the lights as given.
#[inline(always)]
fn add_turned(
    fma: bool,
    batch: &mut Batch,
    scene: &LitScene,
    shading: &Shading,
    aligned: &Aligned,
) {
    let sampled = scene.around.sampled();
    if shading.lobes.are_glossy() {
        add_around(fma, batch, scene, shading, &scene.around_lights);
        add_lamps(fma, batch, scene, shading);
        add_samples(batch, scene, shading);
        batch.sum.sums.diffuse = LightSums::NONE.diffuse;
    }
    let around = match sampled {
        Some(_) => &scene.base_lights,
        None => &scene.around_lights,
    };
    let diffuse = &shading.diffuse();
    each_around(batch, scene, around, (diffuse, Some(aligned)));
    dim(batch, scene);
    each_lamp(batch, scene, &scene.lights, (diffuse, Some(aligned)));
}

/// The luminance of a batch's diffuse light by single lights: as it is, and turned to the form.
#[inline(always)]
pub(crate) fn measure_turned(fma: bool, batch: &mut Batch, scene: &LitScene) -> [f64; 2] {
    let (Some(shading), Some(aligned)) = (&scene.shading, &scene.aligned) else {
        return [0.0; 2];
    };
    prepare(batch, scene);
    let diffuse = &shading.diffuse();
    let unturned = Aligned {
        coarse: Vec::new(),
        strength: 0.0,
        gain: 1.0,
    };
    let mut sums = [0.0; 2];
    for (sum, how) in sums.iter_mut().zip([&unturned, aligned]) {
        batch.sum.clear();
        add_turned(fma, batch, scene, diffuse, how);
        let light = &batch.sum.sums.diffuse;
        let of = |i: usize| {
            let shown = std::array::from_fn(|k| batch.albedo[k][i] * light[k][i]);
            f64::from(luminance(shown, scene.luminance))
        };
        *sum = (0..batch.pixels.count).map(of).sum();
    }
    sums
}

/// Adds lights far away and near, and completes the sum.
#[inline(always)]
fn add_lamps(fma: bool, batch: &mut Batch, scene: &LitScene, shading: &Shading) {
    let one_by_one = match scene.turns {
        Some(_) => scene.lights.as_slice(),
        None => {
            batch
                .sum
                .add_directed(fma, &batch.pixels, shading, &scene.lights);
            &[]
        }
    };
    each_lamp(batch, scene, one_by_one, (shading, None));
    batch.sum.finish(&batch.pixels, shading);
}

/// Lets the light of each lamp arrive in turn, less its shadows, and adds it: of `lights` far away, and of all others.
#[inline(always)]
fn each_lamp(batch: &mut Batch, scene: &LitScene, lights: &[Directed], how: HowLit) {
    for light in lights {
        batch.face(light.direction);
        if scene.turns.is_some() {
            batch.rake();
        }
        add_arriving(batch, how, light.intensity);
    }
    for Shadowed { light, share } in &scene.shadows.far {
        batch.face(light.to_light.to_array());
        batch.shade(share);
        add_arriving(batch, how, light.intensity);
    }
    for (i, point) in scene.points.iter().enumerate() {
        approach(batch, point.position.to_array());
        if let Some(share) = scene.shadows.near.get(i) {
            batch.shade(share);
        }
        add_arriving(batch, how, point.intensity);
    }
}

/// Adds the light that arrives from `near`, which is turned from the coarsest scale to the finest.
#[inline(always)]
fn add_arriving(batch: &mut Batch, (shading, turned): HowLit, intensity: [f32; 3]) {
    let Batch {
        pixels,
        sum,
        near: (directions, share),
        details,
        ..
    } = batch;
    let mut gain = 1.0;
    if let Some(aligned) = turned {
        gain = aligned.gain;
        for detail in details.iter().rev() {
            detail.turn(directions, aligned.strength);
        }
    }
    let intensity = intensity.map(|channel| gain * channel);
    sum.add_near(pixels, shading, (directions, share), intensity);
}

/// Directions to a light at `position`, and its attenuation.
#[inline(always)]
fn approach(batch: &mut Batch, position: [f32; 3]) {
    let ([x, y, z], share) = &mut batch.near;
    for i in 0..BATCH {
        let to = [
            position[0] - batch.points[0][i],
            position[1] - batch.points[1][i],
            position[2] - batch.points[2][i],
        ];
        let square = to[0] * to[0] + to[1] * to[1] + to[2] * to[2];
        // A light on the surface itself has no direction.
        let apart = square > f32::MIN_POSITIVE;
        let inverse = if apart { 1.0 / square } else { 0.0 };
        let per_length = inverse.sqrt();
        (x[i], y[i], z[i]) = (to[0] * per_length, to[1] * per_length, to[2] * per_length);
        share[i] = inverse;
    }
}

/// The intensities of one of the even directions, looked up where it is warped to ([LW] equation 1), with cosines
/// limited by [`MOST_BRIGHTENED`].
#[inline(always)]
fn look_even_up(
    batch: &mut Batch,
    scene: &LitScene,
    environment: &Environment,
    direction: [f32; 3],
    share: f32,
) {
    for (lanes, component) in batch.toward.iter_mut().zip(direction) {
        lanes.fill(component);
    }
    warp_lookups(batch, scene);
    let count = batch.pixels.count;
    look_up(&mut batch.looked_up, environment, &batch.toward, count);
    let [x, y, z] = &batch.toward;
    let [r, g, b] = &mut batch.looked_up;
    for i in 0..BATCH {
        let n = batch.pixels.normal.at(i);
        let cosine = n[0] * direction[0] + n[1] * direction[1] + n[2] * direction[2];
        let warped = n[0] * x[i] + n[1] * y[i] + n[2] * z[i];
        let held = (MOST_BRIGHTENED * warped).max(0.0);
        let counts = if held < cosine { held / cosine } else { 1.0 };
        let share = if scene.relighting.warps {
            share * counts
        } else {
            share
        };
        r[i] *= share;
        g[i] *= share;
        b[i] *= share;
    }
}

/// Combines the terms: gains, contrast, tones, coverage.
#[inline(always)]
fn compose(batch: &mut Batch, scene: &LitScene) {
    let material = &scene.params().material;
    let (kd, ks) = (material.diffuse_gain, material.specular());
    if scene.mirrors.is_some() || scene.around.has_lookups() {
        add_lookups(batch, scene);
    }
    let scales = scene.relighting.scales && material.ambient > 0.0;
    let ambient = batch.pixels.curve(Term::Ambient as usize);
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
    let has_highlight = Lobes::of(material, true).is_some_and(|lobes| lobes.are_glossy());
    if scene.relighting.gloss && has_highlight {
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
        cover(lanes, &batch.alpha);
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
    let Batch {
        albedo: [r, g, b],
        share,
        ..
    } = batch;
    for i in 0..BATCH {
        share[i] = Gloss::share_diffuse([r[i], g[i], b[i]]);
    }
    for lanes in &mut batch.sum.sums.specular {
        for (light, share) in lanes.iter_mut().zip(&batch.share) {
            *light *= share;
        }
    }
    for lanes in &mut batch.gloss.reflectance {
        for (own, share) in lanes.iter_mut().zip(&batch.share) {
            *own *= 1.0 - share;
        }
    }
}

/// Adds new light that surfaces mirror by their own gloss. At grazing angles all of it is mirrored, unless there is no gloss.
#[inline(always)]
fn add_gloss(batch: &mut Batch, scene: &LitScene, gain: f32) {
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
fn enhance_contrast(batch: &mut Batch, scene: &LitScene) {
    let gamma = scene.params().warping.contrast;
    let [xx, xy, yy] = &batch.pixels.unwarp;
    for i in 0..BATCH {
        // The contrast of a warp is the reciprocal of that of its inverse.
        let inverse = Warp {
            xx: xx[i],
            xy: xy[i],
            yy: yy[i],
        };
        batch.share[i] = contrast(inverse, -gamma);
    }
    for lanes in batch.shown.iter_mut().chain(&mut batch.sum.sums.specular) {
        for (light, factor) in lanes.iter_mut().zip(&batch.share) {
            *light *= factor;
        }
    }
}

/// Quantises the colours so far, if a number of tones is given.
#[inline(always)]
fn quantize_tones(batch: &mut Batch, scene: &LitScene) {
    let Some((tones, most)) = scene.tones else {
        return;
    };
    let w = scene.luminance;
    let [r, g, b] = &mut batch.shown;
    for i in 0..BATCH {
        let factor = tone_factor(w[0] * r[i] + w[1] * g[i] + w[2] * b[i], tones, most);
        r[i] *= factor;
        g[i] *= factor;
        b[i] *= factor;
    }
}

#[inline(always)]
fn cover(lanes: &mut Lanes, alpha: &Lanes) {
    for i in 0..BATCH {
        lanes[i] = premultiplied(lanes[i], alpha[i]);
    }
}

/// A channel times coverage, clamped to finite values.
#[inline(always)]
pub(crate) fn premultiplied(shown: f32, coverage: f32) -> f32 {
    (shown * coverage).clamp(-f32::MAX, f32::MAX)
}
