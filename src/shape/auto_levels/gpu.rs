//! Automatic choices from the whole picture, without read-back: percentiles, resolved eleven bits at a time.

use crate::engine::gpu::bindings::bindings;
use crate::engine::gpu::constants::{
    MOST_COUNTING_GROUPS, SEARCH_BINS, SEARCH_BITS, SEARCH_INVOCATIONS, SEARCH_PASSES,
};
use crate::engine::gpu::kernels::{COVERAGE, INDEX, Kernel};
use crate::engine::gpu::made::Shape;
use crate::engine::gpu::run::Run;
use crate::engine::gpu::uniforms::uniforms;
use crate::engine::gpu::wgsl::Number::U32;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};
use crate::plan::Plan;
use crate::shape::auto_levels::{
    CURVATURE_PERCENT, WHITE_PERCENT, flat_curvature, typical_exponent,
};
use std::ops::Range;

/// Numbers as bit patterns with the same order.
const KEYS: Wgsl = wgsl!("keys.wgsl");

uniforms! {
    /// Uniforms of `count.wgsl`.
    CountParams {
        width: u32,
        height: u32,
        rows_start: u32,
        rows_end: u32,
        /// Mask of the bits found so far, and position of the next ones.
        known_bits: u32,
        shift: u32,
        /// Traces up to this are ignored.
        least: f32,
        /// Weights of luminance.
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
    }

    /// Uniforms of `narrow.wgsl`.
    NarrowParams {
        is_first: u32,
        shift: u32,
        /// The percentile as a fraction.
        share: u32,
        share_of: u32,
        /// Target of the gain times the percentile of curvature.
        target_times: f32,
        /// Upper limit of an automatic gain.
        most_gain: f32,
    }
}

bindings! {
    CountBuffers { covered, a, b, c, search, bins }
    NarrowBuffers { bins, search, chosen }
}

/// Histogram of the next bits of the numbers.
pub(crate) static COUNT: Kernel = Kernel::new::<CountParams, CountBuffers>(
    "Count",
    &[
        INDEX,
        COVERAGE,
        KEYS,
        wgsl!(
            "count.wgsl",
            [
                ("SEARCH_INVOCATIONS", U32(SEARCH_INVOCATIONS)),
                ("SEARCH_BINS", U32(SEARCH_BINS))
            ]
        ),
    ],
);

/// Resolves the bits of the wanted rank; after the last bits makes the choice.
pub(crate) static NARROW: Kernel = Kernel::new::<NarrowParams, NarrowBuffers>(
    "Narrow",
    &[
        KEYS,
        wgsl!(
            "narrow.wgsl",
            [
                ("SEARCH_INVOCATIONS", U32(SEARCH_INVOCATIONS)),
                ("SEARCH_BINS", U32(SEARCH_BINS))
            ]
        ),
    ],
);

/// Maximum number of counting workgroups on software devices, where the bins of [`MOST_COUNTING_GROUPS`] are costly.
const MOST_GROUPS_IN_SOFTWARE: u32 = 64;

/// Percentage of numbers below the median.
const MEDIAN_PERCENT: u32 = 50;

/// The quantity searched for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Search {
    /// The gain of the curvature mapping, for a picture of this size, a curvature with this factor, and an upper limit.
    Gain {
        size: [usize; 2],
        factor: f32,
        most: f32,
    },
    /// The white level, with these weights of luminance.
    White([f32; 3]),
    /// The white level of a term of the light, from its luminance.
    TermWhite,
    /// The median depth of patches, with this many columns and rows; stored in place of a white level.
    Depth([u32; 2]),
}

impl Search {
    /// Whether it searches the picture rather than the shape.
    pub(crate) fn is_of_picture(&self) -> bool {
        matches!(self, Self::White(_))
    }
}

/// A search, and its state on the device.
pub(crate) struct Searching {
    search: Search,
    /// Bits found, rank, and number of values.
    state: wgpu::Buffer,
    bins: wgpu::Buffer,
}

impl Searching {
    pub(crate) fn new(run: &mut Run, search: Search) -> Self {
        let state = run.take(12);
        let bins = run.take(4 * u64::from(SEARCH_BINS));
        run.recorder.clear(&state);
        run.recorder.clear(&bins);
        Self {
            search,
            state,
            bins,
        }
    }

    /// Columns and rows of the planes.
    fn size(&self, run: &Run) -> [u32; 2] {
        match self.search {
            Search::Depth(size) => size,
            _ => run.surface.size,
        }
    }

    /// Position of the bits resolved by pass number `pass`.
    fn shift(pass: u32) -> u32 {
        u32::BITS.saturating_sub((pass + 1) * SEARCH_BITS)
    }

    /// Counts the numbers in some rows of three planes: a trace, the conductance and either of them again; a picture;
    /// or luminance three times.
    pub(crate) fn count(
        &self,
        run: &mut Run,
        pass: u32,
        [a, b, c]: [&wgpu::Buffer; 3],
        rows: Range<u32>,
    ) {
        let [width, height] = self.size(run);
        let (least, weights) = match self.search {
            Search::Gain { size, factor, .. } => (flat_curvature(size, factor), [0.0; 3]),
            Search::White(weights) => (0.0, weights),
            Search::TermWhite | Search::Depth(_) => (0.0, [0.0; 3]),
        };
        let params = CountParams {
            width,
            height,
            rows_start: rows.start,
            rows_end: rows.end,
            known_bits: match pass {
                0 => 0,
                _ => u32::MAX << Self::shift(pass - 1),
            },
            shift: Self::shift(pass),
            least,
            weight_r: weights[0],
            weight_g: weights[1],
            weight_b: weights[2],
        };
        let switches = [
            ("OF_TRACE", matches!(self.search, Search::Gain { .. })),
            (
                "OF_LIGHT",
                matches!(self.search, Search::TermWhite | Search::Depth(_)),
            ),
        ];
        let most = match run.device.is_software() {
            true => MOST_GROUPS_IN_SOFTWARE,
            false => MOST_COUNTING_GROUPS,
        };
        let groups = [rows.end.clamp(1, most), 1];
        run.recorder.dispatch(
            self.stage(),
            (&COUNT, &switches),
            &params,
            &CountBuffers {
                covered: &run.surface.covered,
                a,
                b,
                c,
                search: &self.state,
                bins: &self.bins,
            },
            groups,
        );
    }

    /// Ends pass number `pass`; the last one stores its choice in `chosen`.
    pub(crate) fn narrow(&self, run: &mut Run, pass: u32, chosen: &wgpu::Buffer) {
        let (percent, most_gain) = match self.search {
            Search::Gain { most, .. } => (CURVATURE_PERCENT, Some(most)),
            Search::White(_) | Search::TermWhite => (WHITE_PERCENT, None),
            Search::Depth(_) => (MEDIAN_PERCENT, None),
        };
        let params = NarrowParams {
            is_first: u32::from(pass == 0),
            shift: Self::shift(pass),
            share: percent,
            share_of: 100,
            target_times: typical_exponent(),
            most_gain: most_gain.unwrap_or(0.0),
        };
        run.recorder.dispatch(
            self.stage(),
            (&NARROW, &[("IS_GAIN", most_gain.is_some())]),
            &params,
            &NarrowBuffers {
                bins: &self.bins,
                search: &self.state,
                chosen,
            },
            [1, 1],
        );
    }

    /// All passes over planes on the device.
    pub(crate) fn choose(self, run: &mut Run, planes: [&wgpu::Buffer; 3], chosen: &wgpu::Buffer) {
        let rows = 0..self.size(run)[1];
        for pass in 0..SEARCH_PASSES {
            self.count(run, pass, planes, rows.clone());
            self.narrow(run, pass, chosen);
        }
        run.buffers.recycle(self.into_buffers());
    }

    /// Its buffers.
    pub(crate) fn into_buffers(self) -> [wgpu::Buffer; 2] {
        [self.state, self.bins]
    }

    fn stage(&self) -> &'static str {
        match self.search {
            Search::Gain { .. } => "auto-gain",
            Search::White(_) | Search::TermWhite => "auto-white",
            Search::Depth(_) => "direction-field",
        }
    }
}

/// Chooses the gain of curvature, if it is left open.
pub(crate) fn choose_gain(run: &mut Run) {
    let shape = run.made.shape.take().expect("the gain takes the trace");
    run.choose_gain(run.plan, &shape);
    run.made.shape = Some(shape);
}

impl Run<'_> {
    /// Chooses the gain of curvature, if it is left open.
    pub(crate) fn choose_gain(&mut self, plan: &Plan, shape: &Shape) {
        if plan.chooses_gain() {
            let size = self.surface.size.map(|side| side as usize);
            let factor = plan.resolution_factor as f32;
            let most = plan.most_gain();
            let search = Searching::new(self, Search::Gain { size, factor, most });
            let chosen = self.chosen.clone();
            search.choose(self, shape.of_gain(), &chosen);
        }
    }
}
