//! Automatic choices from the whole picture, without read-back: percentiles of a sample, resolved eleven bits at a time.
//!
//! The sample is that of the CPU: a second look at more pixels follows, which the device leaves out if the first gave
//! enough values.

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
use crate::frame::sampling::{ENOUGH, Lattice};
use crate::frame::{Extent, Mask};
use crate::plan::Plan;
use crate::shape::auto_levels::{
    CURVATURE_PERCENT, WHITE_PERCENT, flat_curvature, typical_exponent,
};
use std::ops::Range;

/// Numbers as bit patterns with the same order.
const KEYS: Wgsl = wgsl!("keys.wgsl");

/// Places of the sample.
const LATTICE: Wgsl = wgsl!("../../frame/lattice.wgsl", [("ENOUGH", U32(ENOUGH))]);

uniforms! {
    /// Uniforms of `count.wgsl`.
    CountParams {
        width: u32,
        height: u32,
        /// The lattice: side of its cells, first column and row, number of columns and rows.
        side: u32,
        first_column: u32,
        first_row: u32,
        columns: u32,
        rows: u32,
        /// Row of the picture that is the first of the planes, and the rows looked at.
        top: u32,
        rows_start: u32,
        rows_end: u32,
        is_second: u32,
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
        /// Whether these are the first bits, and whether the look is the second.
        is_first: u32,
        is_second: u32,
        /// Side of the lattice at the first look.
        side: u32,
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
        LATTICE,
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
        LATTICE,
        wgsl!(
            "narrow.wgsl",
            [
                ("SEARCH_INVOCATIONS", U32(SEARCH_INVOCATIONS)),
                ("SEARCH_BINS", U32(SEARCH_BINS))
            ]
        ),
    ],
);

/// Places that are worth a counting workgroup.
const PLACES_PER_GROUP: u32 = 2048;

/// Maximum number of counting workgroups on software devices, where the bins of [`MOST_COUNTING_GROUPS`] are costly.
const MOST_GROUPS_IN_SOFTWARE: u32 = 64;

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
}

/// A pass over the values: the look at them, 0 or 1, and the number of the bits that it resolves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Pass {
    look: u32,
    bits: u32,
}

impl Pass {
    /// All passes of a search, in their order.
    pub(crate) fn all() -> impl Iterator<Item = Self> {
        let of_look = |look| (0..SEARCH_PASSES).map(move |bits| Self { look, bits });
        (0..2).flat_map(of_look)
    }

    /// Whether it begins the second look.
    pub(crate) fn begins_again(self) -> bool {
        self == Self { look: 1, bits: 0 }
    }
}

/// A search, and its state on the device.
pub(crate) struct Searching {
    search: Search,
    lattice: Lattice,
    /// Bits found, rank, number of values, and the side of the lattice at a second look.
    pub(crate) state: wgpu::Buffer,
    bins: wgpu::Buffer,
}

/// The lattice over the covered pixels of a picture.
pub(crate) fn lattice_over(mask: &Mask) -> Lattice {
    Extent::of(mask).lattice()
}

impl Searching {
    pub(crate) fn new(run: &mut Run, search: Search, lattice: Lattice) -> Self {
        let state = run.take(16);
        let bins = run.take(4 * u64::from(SEARCH_BINS));
        run.recorder.clear(&state);
        run.recorder.clear(&bins);
        Self {
            search,
            lattice,
            state,
            bins,
        }
    }

    /// Columns and rows of the planes.
    fn size(&self, run: &Run) -> [u32; 2] {
        run.surface.size
    }

    /// Position of the bits with this number.
    fn shift(bits: u32) -> u32 {
        u32::BITS.saturating_sub((bits + 1) * SEARCH_BITS)
    }

    /// Counts the sampled numbers in the rows `rows` of three planes, whose first row is row `top` of the picture: a
    /// trace, the conductance and either of them again; a picture; or luminance three times.
    pub(crate) fn count(
        &self,
        run: &mut Run,
        pass: Pass,
        [a, b, c]: [&wgpu::Buffer; 3],
        rows: Range<u32>,
        top: u32,
    ) {
        let [width, height] = run.surface.size;
        let (least, weights) = match self.search {
            Search::Gain { size, factor, .. } => (flat_curvature(size, factor), [0.0; 3]),
            Search::White(weights) => (0.0, weights),
        };
        let Lattice {
            side,
            columns,
            rows: lattice_rows,
        } = &self.lattice;
        let params = CountParams {
            width,
            height,
            side: *side,
            first_column: columns.start as u32,
            first_row: lattice_rows.start as u32,
            columns: columns.len() as u32,
            rows: lattice_rows.len() as u32,
            top,
            rows_start: top + rows.start,
            rows_end: top + rows.end,
            is_second: pass.look,
            known_bits: match pass.bits {
                0 => 0,
                bits => u32::MAX << Self::shift(bits - 1),
            },
            shift: Self::shift(pass.bits),
            least,
            weight_r: weights[0],
            weight_g: weights[1],
            weight_b: weights[2],
        };
        let switches = [
            ("OF_TRACE", matches!(self.search, Search::Gain { .. })),
        ];
        let most = match run.device.is_software() {
            true => MOST_GROUPS_IN_SOFTWARE,
            false => MOST_COUNTING_GROUPS,
        };
        let pixels = columns.len() * lattice_rows.len();
        let places = (pixels as u64 / u64::from(side * side)) as u32;
        let groups = [(places / PLACES_PER_GROUP).clamp(1, most), 1];
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

    /// Ends a pass; the last of a look stores its choice in `chosen`.
    pub(crate) fn narrow(&self, run: &mut Run, pass: Pass, chosen: &wgpu::Buffer) {
        let (percent, most_gain) = match self.search {
            Search::Gain { most, .. } => (CURVATURE_PERCENT, Some(most)),
            Search::White(_) => (WHITE_PERCENT, None),
        };
        let params = NarrowParams {
            is_first: u32::from(pass.bits == 0),
            is_second: pass.look,
            side: self.lattice.side,
            shift: Self::shift(pass.bits),
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
        let rows = 0..run.surface.size[1];
        // With a pixel in every cell there are no more to look at.
        let is_whole = self.lattice.side == 1;
        for pass in Pass::all().take_while(|pass| !(is_whole && pass.begins_again())) {
            self.count(run, pass, planes, rows.clone(), 0);
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
            Search::White(_) => "auto-white",
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
            let lattice = lattice_over(&self.frame.mask);
            let search = Searching::new(self, Search::Gain { size, factor, most }, lattice);
            let chosen = self.chosen.clone();
            search.choose(self, shape.of_gain(), &chosen);
        }
    }
}

/// Bits that are ordered as `f32::total_cmp` orders the values.
#[cfg(test)]
pub(crate) fn key_of(value: f32) -> u32 {
    let bits = value.to_bits();
    let negative = ((bits as i32) >> 31) as u32;
    bits ^ (negative | SIGN)
}

/// The value with this key.
#[cfg(test)]
pub(crate) fn value_of(key: u32) -> f32 {
    f32::from_bits(if key & SIGN == 0 { !key } else { key ^ SIGN })
}

#[cfg(test)]
const SIGN: u32 = 1 << 31;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::cpu;
    use crate::engine::gpu::device::{Choice, Device, to_test_on};
    use crate::engine::gpu::runner::Runner;
    use crate::engine::inputs::Inputs;
    use crate::frame::{ColorPlanes, Frame, Plane};
    use crate::params::ShapeParams;
    use crate::plan::Goal;
    use crate::report::scenes::Scene;
    use crate::report::timing;

    /// 1.1 million pixels, of which one in nine is looked at. Curvature lies in six rows of ten: its sample falls short and
    /// is taken once more.
    #[test]
    fn large_pictures_are_sampled_as_on_the_cpu() {
        let Some(device) = to_test_on(Device::open(Choice::Any)) else {
            return;
        };
        let (width, height) = (1100, 1000);
        let mut frame: Frame = Scene::waves(width, height).frame;
        for (plane, flat) in [
            (&mut frame.normal.x, 0.0),
            (&mut frame.normal.y, 0.0),
            (&mut frame.normal.z, 1.0),
        ] {
            plane.samples_mut()[600 * width..].fill(flat);
        }
        let channel = |hue: f32| {
            Plane::from_fn(width, height, |x, y| {
                hue * (0.5 + 0.4 * ((x * x + 7 * y) as f32 / 9e3).sin())
            })
        };
        let [r, g, b] = [0.9, 0.7, 0.5].map(channel);
        frame.color = Some(ColorPlanes { r, g, b });
        let plan = timing::plan(Goal::Enhance, &frame, ShapeParams::default()).unwrap();
        let host = cpu::Runner::default();
        let expected = host.execute(&plan, &frame, Inputs::default()).unwrap();
        let runner = Runner::new(device);
        let whole = runner.execute(&plan, &frame, Inputs::default()).unwrap();
        // The traces of both differ by rounding, their sums of three products hardly.
        for (found, expected, allowed) in [
            (whole.gain, expected.gain, 1e-4),
            (whole.white_level, expected.white_level, 1e-6),
        ] {
            let off = found.unwrap() / expected.unwrap() - 1.0;
            assert!(off.abs() <= allowed, "{found:?} {expected:?}");
        }
    }

    #[test]
    fn keys_give_their_values_back_in_order() {
        let values = [-f32::MAX, -1.0, -1e-45, -0.0, 0.0, 1e-45, 1.0, f32::MAX];
        let is_ordered = |pair: &[f32]| key_of(pair[0]) < key_of(pair[1]);
        assert!(values.windows(2).all(is_ordered));
        for v in values {
            assert_eq!(value_of(key_of(v)).to_bits(), v.to_bits());
        }
    }
}
