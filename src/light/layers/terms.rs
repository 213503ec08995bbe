//! The terms scaled separately in the light of a picture: lobes, and parts of lobes.

use crate::frame::{ColorPlanes, LobeLayers};
use crate::params::{Magnitude, ScalingParams};

/// A lobe, or a part of it, that is scaled separately.
pub(crate) struct LightTerm<'a> {
    pub(crate) name: &'static str,
    pub(crate) direct: Option<&'a ColorPlanes>,
    pub(crate) indirect: Option<&'a ColorPlanes>,
    pub(crate) color: Option<&'a ColorPlanes>,
    pub(crate) albedo: Option<&'a ColorPlanes>,
    pub(crate) magnitude: Magnitude,
}

/// The terms of the lobes with a magnitude above 0. If ambient light has its own magnitude, that applies to diffuse
/// light from other surfaces.
pub(crate) fn light_terms<'a>(
    lobes: &'a [LobeLayers],
    params: &ScalingParams,
) -> Vec<LightTerm<'a>> {
    let magnitudes = params.magnitudes();
    let of_lobe = |layers: &'a LobeLayers| {
        let term = |name, direct, indirect, magnitude| LightTerm {
            name,
            direct,
            indirect,
            color: layers.color.as_ref(),
            albedo: layers.albedo.as_ref(),
            magnitude,
        };
        let (direct, indirect) = (layers.direct.as_ref(), layers.indirect.as_ref());
        let diffuse = layers.lobe.is_diffuse();
        let name = layers.lobe.name();
        let magnitude = if diffuse {
            magnitudes.diffuse
        } else {
            magnitudes.specular
        };
        if diffuse && params.scaling_ambient.is_some() {
            let apart = [
                term(name, direct, None, magnitude),
                term("ambient", None, indirect, magnitudes.ambient),
            ];
            return apart.into_iter().collect::<Vec<_>>();
        }
        vec![term(name, direct, indirect, magnitude)]
    };
    let all = lobes.iter().flat_map(of_lobe);
    all.filter(|term| term.magnitude.largest() > 0.0)
        .filter(|term| term.direct.or(term.indirect).is_some())
        .collect()
}
