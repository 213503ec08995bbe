//! Formulas in WGSL against the Rust functions of the same names, on a software device.
//!
//! A formula depends on its arguments, the uniform block and switches only, and takes or returns a float; each has a row
//! in [`table`], a method `Type::name` as `type_name`. Functions that read buffers are compared by `tests/backends`, in
//! their pictures. A device may contract and reorder operations, so rows state how far its results may be off.

mod shader;
mod table;
mod words;

use crate::gpu::device::{AdapterKind, Device, to_test_on};
use crate::gpu::kernels::Kernel;
use crate::stages::kernels::kernel_sources;
use rand_core::{Rng, SeedableRng};
use rand_pcg::Pcg32;
use shader::{Shader, formulas};
use std::collections::BTreeSet;
use wgpu::naga::ScalarKind;
use words::Namesake;

/// Values compared per function.
const SAMPLES: usize = 50_000;

/// A function from words to words.
type FromWords = Box<dyn Fn(&[u32], &mut Vec<u32>)>;

/// A function of WGSL and its Rust twin.
struct Twin {
    name: &'static str,
    /// A kernel that contains it.
    kernel: &'static Kernel,
    rust: FromWords,
    /// Fields of the uniform block and switches passed after the arguments.
    with: &'static [&'static str],
    /// Ranges of the first inputs, each for so many of them.
    ranges: &'static [(usize, f32, f32)],
    domain: fn(&mut [u32]),
    /// How far the device may be off: so many f32 steps, or by this difference.
    ulps: u64,
    absolute: f32,
}

fn twin<A>(name: &'static str, kernel: &'static Kernel, rust: impl Namesake<A> + 'static) -> Twin {
    Twin {
        name,
        kernel,
        rust: Box::new(move |words, out| rust.run(&mut words.iter().copied(), out)),
        with: &[],
        ranges: &[],
        domain: |_| {},
        ulps: 0,
        absolute: 0.0,
    }
}

impl Twin {
    fn with(self, with: &'static [&'static str]) -> Self {
        Self { with, ..self }
    }

    fn within(self, ranges: &'static [(usize, f32, f32)]) -> Self {
        Self { ranges, ..self }
    }

    /// Maps random inputs to those that occur.
    fn on(self, domain: fn(&mut [u32])) -> Self {
        Self { domain, ..self }
    }

    fn ulps(self, ulps: u64) -> Self {
        Self { ulps, ..self }
    }

    fn absolute(self, absolute: f32) -> Self {
        Self { absolute, ..self }
    }

    /// The sample that is off the most, beyond what is allowed.
    fn difference(&self, device: &Device) -> Option<String> {
        let shader = Shader::new(self.kernel, self.name, self.with);
        let given = self.samples(&shader.inputs);
        let found = shader.run(device, &given, SAMPLES);
        let given = given.chunks(shader.inputs.len());
        let samples = given.zip(found.chunks(shader.outputs.len()));
        let (mut worst, mut report) = (0, String::new());
        for (given, found) in samples {
            let mut own = Vec::new();
            (self.rust)(given, &mut own);
            assert_eq!(own.len(), found.len(), "the result of {}", self.name);
            let pairs = own.iter().zip(found).zip(&shader.outputs);
            let off = pairs.map(|((&a, &b), &kind)| self.ulps_between(kind, a, b));
            let off = off.max().unwrap_or(0);
            if off > worst {
                worst = off;
                report = format!(
                    "{} is off by {off} ulps at {}\n  Rust gives {}\n  WGSL gives {}",
                    self.name,
                    show(given, &shader.inputs),
                    show(&own, &shader.outputs),
                    show(found, &shader.outputs),
                );
            }
        }
        (worst > self.ulps).then_some(report)
    }

    fn samples(&self, kinds: &[ScalarKind]) -> Vec<u32> {
        let seed = self.name.bytes().fold(1, |seed: u64, byte| {
            seed.wrapping_mul(31).wrapping_add(byte.into())
        });
        let mut random = TwinInputs {
            bits: Pcg32::seed_from_u64(seed),
            last: 0,
        };
        let ranges = self.ranges.iter();
        let ranges: Vec<_> = ranges
            .flat_map(|&(count, lo, hi)| vec![(lo, hi); count])
            .collect();
        let mut all = Vec::new();
        for _ in 0..SAMPLES {
            let words = kinds.iter().enumerate();
            let words = words.map(|(i, &kind)| random.word(kind, ranges.get(i).copied()));
            let mut words: Vec<u32> = words.collect();
            (self.domain)(&mut words);
            all.extend(words);
        }
        all
    }

    /// How far results are apart, beyond the absolute difference allowed. WGSL leaves open what is not finite, and
    /// devices flush subnormals.
    fn ulps_between(&self, kind: ScalarKind, own: u32, found: u32) -> u64 {
        let [x, y] = [own, found].map(f32::from_bits);
        let is_flushed = x.is_subnormal() && y == 0.0;
        match kind {
            _ if own == found => 0,
            ScalarKind::Float if !x.is_finite() || is_flushed => 0,
            ScalarKind::Float if (x - y).abs() <= self.absolute => 0,
            ScalarKind::Float => steps(x).abs_diff(steps(y)),
            _ => u64::MAX,
        }
    }
}

/// Number of f32 steps from 0.
fn steps(v: f32) -> i64 {
    let size = i64::from(v.abs().to_bits());
    if v.is_sign_negative() { -size } else { size }
}

fn show(words: &[u32], kinds: &[ScalarKind]) -> String {
    let shown = words.iter().zip(kinds).map(|(&word, kind)| match kind {
        ScalarKind::Float => format!("{:?}", f32::from_bits(word)),
        _ => format!("{word:#x}"),
    });
    shown.collect::<Vec<_>>().join(", ")
}

/// Reproducible inputs.
struct TwinInputs {
    bits: Pcg32,
    /// The previous value, since equal arguments are a case of their own.
    last: u32,
}

impl TwinInputs {
    fn word(&mut self, kind: ScalarKind, range: Option<(f32, f32)>) -> u32 {
        let bits = self.bits.next_u32();
        self.last = match (kind, range) {
            (ScalarKind::Float, range) => self.float(range.unwrap_or((-100.0, 100.0))).to_bits(),
            (ScalarKind::Bool, _) => bits & 1,
            (_, Some((lo, hi))) => lo as u32 + bits % (hi as u32 - lo as u32 + 1),
            // Most integers are counts.
            (_, None) if bits.is_multiple_of(2) => bits,
            (_, None) => bits >> 28,
        };
        self.last
    }

    /// Mostly -1..1, where that is in the range; and all of it, its ends, and numbers at which formulas branch.
    fn float(&mut self, (lo, hi): (f32, f32)) -> f32 {
        let random = self.bits.next_u32() as f32 / u32::MAX as f32;
        let [choice, which] = [8, 7].map(|count| self.bits.next_u32() as usize % count);
        let last = f32::from_bits(self.last);
        let number = match choice {
            0 => [lo, hi, 0.0, 1.0, -1.0, 0.5, last][which],
            1 | 2 => lo + random * (hi - lo),
            _ => 2.0 * random - 1.0,
        };
        if number.is_nan() {
            lo
        } else {
            number.clamp(lo, hi)
        }
    }
}

#[test]
fn every_formula_has_a_row() {
    let rows: BTreeSet<&str> = table::twins().iter().map(|twin| twin.name).collect();
    let sources = kernel_sources();
    let all: BTreeSet<String> = sources.flat_map(|(_, source)| formulas(&source)).collect();
    let lacking: Vec<_> = all
        .iter()
        .filter(|&name| !rows.contains(name.as_str()))
        .collect();
    assert!(lacking.is_empty(), "WGSL without a Rust twin: {lacking:?}");
}

#[test]
fn formulas_are_those_of_rust() {
    // Hardware rounds in its own ways.
    let Some(device) = to_test_on(Device::open(AdapterKind::Software)) else {
        return;
    };
    let twins = table::twins();
    let differences: Vec<_> = twins
        .iter()
        .filter_map(|twin| twin.difference(&device))
        .collect();
    assert!(differences.is_empty(), "{}", differences.join("\n\n"));
}
