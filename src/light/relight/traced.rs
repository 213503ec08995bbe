//! Mirrors and lenses that show their surroundings: each sight line is bent, warped and traced, and the light at its
//! hit is scaled by its own brightness.

use crate::frame::{Frame, luminance};
use crate::light::batch::{BATCH, Term};
use crate::light::light_warping::Warp;
use crate::light::relight::batch::Batch;
use crate::light::relight::mirrors::{BentSight, Mirrors};
use crate::light::relight::scene::LitScene;

/// Adds the light that the pixels of a batch mirror and refract.
pub(crate) fn add_traced(batch: &mut Batch, scene: &LitScene, mirrors: &Mirrors) {
    let material = scene.params().material;
    let curves = scene
        .relighting
        .scales
        .then(|| *batch.pixels.curve(Term::Specular as usize));
    let mut places = [[0; 2]; BATCH];
    for (lane, x, y) in batch.places() {
        places[lane] = [x, y];
    }
    for (lane, at) in places.into_iter().enumerate().take(batch.pixels.count) {
        let sight = BentSight {
            tracer: &mirrors.tracer,
            environment: scene.around.mirrored(),
            at,
            warp: scene.relighting.warps.then(|| {
                let [xx, xy, yy] = batch.pixels.unwarp.each_ref().map(|lanes| lanes[lane]);
                Warp { xx, xy, yy }.inverse()
            }),
        };
        let (n, eye) = (batch.pixels.normal.at(lane), batch.pixels.to_eye.at(lane));
        let cosine = n[0] * eye[0] + n[1] * eye[1] + n[2] * eye[2];
        let light = sight.light(cosine, &material, |color| {
            curves.as_ref().map_or(1.0, |curves| {
                // Files can hold infinities.
                let luminance = luminance(color, scene.luminance).min(f32::MAX);
                let intensity = mirrors.intensity.of(luminance);
                curves.at(lane).at(intensity, scene.invariant_point)
            })
        });
        // Without any hit the picture stays.
        let shown = light.unwrap_or_else(|| own_color(scene.frame, at));
        for (to, color) in batch.sum.sums.specular.iter_mut().zip(shown) {
            to[lane] += color;
        }
    }
}

/// The picture's colour divided by coverage; black without a picture.
fn own_color(frame: &Frame, [x, y]: [usize; 2]) -> [f32; 3] {
    let alpha = frame.alpha.as_ref().map_or(1.0, |alpha| alpha.at(x, y));
    let cover = if alpha > 0.0 { alpha } else { 1.0 };
    frame.color.as_ref().map_or([0.0; 3], |color| {
        [&color.r, &color.g, &color.b].map(|plane| plane.at(x, y) / cover)
    })
}
