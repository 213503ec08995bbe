//! Options of a run on the CPU. They change run time only, never a result.

use std::num::NonZeroUsize;

/// Largest size of the tiles that threads work on, in pixels. Tiles are balanced so that every thread gets the same
/// number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TileSize {
    /// Columns. Fewer waste more work on the border of a tile; more overflow the cache.
    pub width: NonZeroUsize,
    /// Rows. Fewer waste more work; more leave threads idle at the end.
    pub height: NonZeroUsize,
}

/// CPU options.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RunOptions {
    /// Size of diffusion tiles.
    pub tile: TileSize,
    /// Maximum number of diffusion sweeps over a tile before its neighbours are read again. Fewer read and write the
    /// frame more often; more waste work on the border, so that low tiles take at most 32.
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
            sweeps_per_pass: size(64),
        }
    }
}
