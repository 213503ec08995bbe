//! Tone response: from the tone wanted to the threshold that gives it, by measured coverage.

/// Thresholds by density.
#[derive(Debug, Clone)]
pub(super) struct Response {
    thresholds: Vec<f32>,
}

/// Entries of the response, from density 0 to [`MAX_DENSITY`].
pub(crate) const ENTRIES: usize = 4096;

/// Density past which paper is black: 0.2 % stay white.
pub(crate) const MAX_DENSITY: f32 = 6.0;

impl Response {
    /// The response of a texture whose mean ink is `inks` at even steps of the threshold from 0 to `top`,
    /// rising.
    pub(super) fn of(inks: &[f64], top: f32) -> Self {
        let steps = inks.len() - 1;
        let mut step = 0;
        let threshold = |entry: usize| {
            let density = f64::from(MAX_DENSITY) * entry as f64 / ENTRIES as f64;
            let wanted = -(-density).exp_m1();
            while step + 1 < steps && inks[step + 1] < wanted {
                step += 1;
            }
            let (low, high) = (inks[step], inks[step + 1]);
            let share = ((wanted - low) / (high - low).max(1e-12)).clamp(0.0, 1.0);
            ((step as f64 + share) / steps as f64) as f32 * top
        };
        Self {
            thresholds: (0..=ENTRIES).map(threshold).collect(),
        }
    }

    /// All thresholds, in the order of entries.
    #[cfg(feature = "gpu")]
    pub(super) fn thresholds(&self) -> &[f32] {
        &self.thresholds
    }

    /// The entry of a density: apart from the look-up itself, which no vector does.
    #[inline(always)]
    pub(super) fn entry(density: f32) -> u32 {
        let entry = (density * (ENTRIES as f32 / MAX_DENSITY))
            .max(0.0)
            .min(ENTRIES as f32);
        entry as i32 as u32
    }

    /// The threshold at which a share 1 - exp(-density) of the paper is inked.
    #[inline(always)]
    pub(super) fn threshold(&self, entry: u32) -> f32 {
        self.thresholds[entry as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texture_that_inks_by_the_square_of_its_threshold_is_asked_for_the_root() {
        let inks: Vec<f64> = (0..=1000)
            .map(|i| (f64::from(i) / 1000.0).powi(2))
            .collect();
        let response = Response::of(&inks, 10.0);
        for ink in [0.0_f32, 0.01, 0.3, 0.9, 0.99] {
            // Entries are 6/4096 apart in density: up to 0.0015 (1 - ink) too little ink.
            let found = (response.threshold(Response::entry(-(1.0 - ink).ln())) / 10.0).powi(2);
            assert!(
                found <= ink + 1e-5 && found > ink - 0.0016,
                "{ink}: {found}"
            );
        }
    }
}
