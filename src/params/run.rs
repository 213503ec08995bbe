//! Options of a run on the CPU. None of them changes a result, only run time.

use std::num::NonZeroUsize;

/// Largest size of the rectangles that threads work on, in pixels. They are evened out, so that every
/// thread gets as many.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileSize {
    /// Columns. Fewer waste more work on the rim of a tile; more outgrow the cache.
    pub width: NonZeroUsize,
    /// Rows. Fewer waste more work; more leave threads idle at the end.
    pub height: NonZeroUsize,
}

/// How the CPU runs a plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunOptions {
    /// Size of the tiles that diffusion works on.
    pub tile: TileSize,
    /// Most sweeps of the diffusion operator over a tile before its neighbours are looked at again.
    /// Fewer read and write the frame more often; more waste work on the rim and outgrow the cache.
    pub sweeps_per_pass: NonZeroUsize,
}

impl Default for RunOptions {
    fn default() -> Self {
        let size = |n| NonZeroUsize::new(n).expect("above 0");
        Self {
            tile: TileSize {
                width: size(2048),
                height: size(640),
            },
            sweeps_per_pass: size(32),
        }
    }
}
