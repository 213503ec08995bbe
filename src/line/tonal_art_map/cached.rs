//! The texture of strokes, made once and cached as long as its parameters stay the same.

use crate::line::tonal_art_map::TonalArtMap;
use crate::params::{Stroke, StrokeParams, Style};
use std::sync::{Arc, Mutex, PoisonError};

/// The texture of the last drawing.
#[derive(Debug, Default)]
pub(crate) struct ArtMapCache(Mutex<Option<(MadeWith, Arc<TonalArtMap>)>>);

/// The stroke, style and seed that a texture was made with.
type MadeWith = (Stroke, Style, u64);

impl ArtMapCache {
    /// The texture for strokes in a picture with `resolution_factor` pixels for each of the reference; `timed` builds
    /// it if it has changed.
    pub(crate) fn of(
        &self,
        params: &StrokeParams,
        resolution_factor: f32,
        timed: impl FnOnce(&dyn Fn() -> TonalArtMap) -> TonalArtMap,
    ) -> Arc<TonalArtMap> {
        let (stroke, style, seed) = (params.stroke(resolution_factor), params.style, params.seed);
        let asked = (stroke, style, seed);
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        match &*kept {
            Some((made, map)) if *made == asked => map.clone(),
            _ => {
                let make = || TonalArtMap::of_strokes(&stroke, style, seed);
                let map = Arc::new(timed(&make));
                *kept = Some((asked, map.clone()));
                map
            }
        }
    }
}
