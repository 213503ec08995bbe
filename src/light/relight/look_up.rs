//! Look-ups made once per pixel, in an environment or a lit sphere.

use crate::frame::luminance;
use crate::light::batch::{BATCH, Term, Vectors};
use crate::light::brdf::{grazing, seen_in_glass};
use crate::light::cosines::scalar_product;
use crate::light::environment::Environment;
use crate::light::intensity::{Intensity, Map};
use crate::light::light_warping::{Warp, half_vector};
use crate::light::lit_sphere::LitSphere;
use crate::light::prepared_environment::Used;
use crate::light::relight::batch::Batch;
use crate::light::relight::pilot::Base;
use crate::light::relight::scene::LitScene;
use crate::light::relight::traced::add_traced;
use crate::params::MaterialParams;

/// Looks `map` up in the directions `toward`: positions of all lanes first, then the samples.
#[inline(always)]
pub(crate) fn look_up(found: &mut Vectors, map: &Environment, toward: &Vectors, count: usize) {
    let [x, y, z] = toward;
    let mut positions = [[0.0; BATCH]; 2];
    let [columns, rows] = &mut positions;
    for i in 0..BATCH {
        [columns[i], rows[i]] = map.position([x[i], y[i], z[i]]);
    }
    let [r, g, b] = found;
    for i in 0..count {
        [r[i], g[i], b[i]] = map.at_position(columns[i], rows[i]);
    }
}

/// Adds the look-ups of each pixel to the sums.
#[inline(always)]
pub(crate) fn add_lookups(batch: &mut Batch, scene: &LitScene) {
    let gain = scene.around.gain().unwrap_or(1.0);
    if let Some(mirrors) = &scene.mirrors {
        add_traced(batch, scene, mirrors);
        return;
    }
    match &scene.around.ready.used {
        Used::Nothing | Used::Lights(_) | Used::Lookups(..) => {}
        Used::Sampled(sampled) => {
            if let Base::Map(map) = &sampled.base {
                let shading = scene.shading.expect("samples have lobes");
                let shares = shading.lobes.base_share(&batch.pixels);
                for (i, share) in shares.into_iter().enumerate() {
                    batch.share[i] = gain * batch.occlusion[i] * share;
                }
                batch.toward = batch.pixels.normal.vector;
                add_seen(batch, scene, Term::Diffuse, map);
            }
        }
        Used::Prefiltered { diffuse, specular } => {
            for i in 0..BATCH {
                batch.share[i] = gain * batch.occlusion[i];
            }
            batch.toward = batch.pixels.normal.vector;
            add_seen(batch, scene, Term::Diffuse, diffuse);
            if let Some(map) = specular {
                // In a sum over lights the lobe peaks at 1; in the map it has the energy of a cosine.
                let lobe = 2.0 / (scene.params().material.shininess + 1.0);
                batch.share = [gain * lobe; BATCH];
                batch.toward = batch.pixels.mirrored.vector;
                add_seen(batch, scene, Term::Specular, map);
            }
        }
        Used::Mirrored(map) => {
            let material = scene.params().material;
            batch.share = [gain; BATCH];
            if material.material.is_clear() {
                add_refracted(batch, scene, map, &material);
            }
            batch.toward = batch.pixels.mirrored.vector;
            add_seen(batch, scene, Term::Specular, map);
        }
        Used::LitSpheres(intensity) => {
            add_spheres(batch, scene, scene.around.spheres, *intensity);
        }
    }
}

/// Adds what surfaces with gloss of their own mirror of the environment.
#[inline(always)]
pub(crate) fn add_mirrored(batch: &mut Batch, scene: &LitScene) {
    let Some(map) = &scene.around.ready.gloss else {
        return;
    };
    batch.share = [scene.around.gain().unwrap_or(1.0); BATCH];
    batch.toward = batch.pixels.mirrored.vector;
    see(batch, scene, Term::Specular, map);
    for i in 0..BATCH {
        let (n, eye) = (batch.pixels.normal.at(i), batch.pixels.to_eye.at(i));
        let grazing = grazing(scalar_product(n, eye));
        for k in 0..3 {
            let light = batch.looked_up[k][i] * batch.share[i];
            batch.gloss.sums.diffuse[k][i] += (1.0 - grazing) * light;
            batch.gloss.sums.specular[k][i] += grazing * light;
        }
    }
}

/// Adds the radiance of `map` from the warped `batch.toward`, times `batch.share`, scaled by its own brightness.
#[inline(always)]
fn add_seen(batch: &mut Batch, scene: &LitScene, term: Term, map: &Map) {
    see(batch, scene, term, map);
    let sums = match term {
        Term::Specular => &mut batch.sum.sums.specular,
        _ => &mut batch.sum.sums.diffuse,
    };
    for (sum, found) in sums.iter_mut().zip(&batch.looked_up) {
        for i in 0..BATCH {
            sum[i] += found[i] * batch.share[i];
        }
    }
}

/// Looks up the radiance of `map` from the warped `batch.toward`, and multiplies `batch.share` by the scale of its own
/// brightness ([RS] section 5.3).
#[inline(always)]
fn see(batch: &mut Batch, scene: &LitScene, term: Term, map: &Map) {
    warp_lookups(batch, scene);
    look_up(
        &mut batch.looked_up,
        &map.environment,
        &batch.toward,
        batch.pixels.count,
    );
    let [r, g, b] = &batch.looked_up;
    let w = scene.luminance;
    if scene.relighting.scales {
        let curves = batch.pixels.curve(term as usize);
        for i in 0..BATCH {
            let luminance = w[0] * r[i] + w[1] * g[i] + w[2] * b[i];
            let intensity = map.intensity.of(luminance);
            let sigma = curves.at(i).at(intensity, scene.invariant_point);
            batch.share[i] *= sigma;
        }
    }
}

/// Adds light refracted through glass, and keeps the reflected share.
#[inline(always)]
fn add_refracted(batch: &mut Batch, scene: &LitScene, map: &Map, material: &MaterialParams) {
    let mut mirrored = [0.0; BATCH];
    let all = batch.share;
    for i in 0..batch.pixels.count {
        let (n, eye) = (batch.pixels.normal.at(i), batch.pixels.to_eye.at(i));
        let (share, [x, y, z]) = seen_in_glass(n, eye, material);
        (batch.toward[0][i], batch.toward[1][i], batch.toward[2][i]) = (x, y, z);
        mirrored[i] = share;
        batch.share[i] = all[i] * (1.0 - mirrored[i]);
    }
    add_seen(batch, scene, Term::Specular, map);
    for i in 0..BATCH {
        batch.share[i] = all[i] * mirrored[i];
    }
}

/// Adds the colours of the lit sphere, or of both blended by curvature. They include gains of their own.
#[inline(always)]
fn add_spheres(batch: &mut Batch, scene: &LitScene, spheres: &[LitSphere], intensity: Intensity) {
    let own = 1.0 / scene.params().material.diffuse_gain.max(f32::MIN_POSITIVE);
    batch.toward = batch.pixels.normal.vector;
    warp_lookups(batch, scene);
    for i in 0..batch.pixels.count {
        let across = [batch.toward[0][i], batch.toward[1][i]];
        let color = match spheres {
            [convex, concave] => {
                let share = 0.5 + 0.5 * batch.kappa[i];
                let (convex, concave) = (convex.color(across), concave.color(across));
                [0, 1, 2].map(|k| concave[k] + share * (convex[k] - concave[k]))
            }
            spheres => spheres
                .first()
                .map_or([0.0; 3], |sphere| sphere.color(across)),
        };
        let sigma = match scene.relighting.scales {
            true => {
                let luminance = luminance(color, scene.luminance);
                let curves = batch.pixels.curve(Term::Diffuse as usize);
                curves
                    .at(i)
                    .at(intensity.of(luminance), scene.invariant_point)
            }
            false => 1.0,
        };
        for (sum, color) in batch.sum.sums.diffuse.iter_mut().zip(color) {
            sum[i] += color * sigma * own;
        }
    }
}

/// Warps look-up directions ([LW] equation 1).
#[inline(always)]
pub(crate) fn warp_lookups(batch: &mut Batch, scene: &LitScene) {
    if !scene.relighting.warps {
        return;
    }
    let [xx, xy, yy] = &batch.pixels.unwarp;
    let [x, y, z] = &mut batch.toward;
    for i in 0..BATCH {
        let inverse = Warp {
            xx: xx[i],
            xy: xy[i],
            yy: yy[i],
        };
        let half = half_vector([x[i], y[i], z[i]]);
        [x[i], y[i], z[i]] = inverse.inverse().direction(half);
    }
}
