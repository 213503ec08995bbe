//! Kernels: WGSL composed of shared parts.

use crate::engine::gpu::bindings::Bindings;
use crate::engine::gpu::constants::constants;
use crate::engine::gpu::uniforms::Uniforms;
use crate::engine::gpu::wgsl::{Wgsl, wgsl};

/// Pixel indexing of a frame.
pub(crate) const INDEX: Wgsl = wgsl!("index.wgsl");

/// Neighbouring pixels.
pub(crate) const AROUND: Wgsl = wgsl!("around.wgsl");

/// The mask.
pub(crate) const COVERAGE: Wgsl = wgsl!("coverage.wgsl");

/// A kernel, declared beside the pass that runs it.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// Its unique name.
    pub(crate) name: &'static str,
    /// The definition of its uniform block.
    uniforms: &'static str,
    /// Names of its buffers.
    pub(super) buffers: &'static [&'static str],
    /// Its WGSL, after the part common to all kernels.
    parts: &'static [Wgsl],
}

impl Kernel {
    /// A kernel with these uniforms and these buffers.
    pub(crate) const fn new<U: Uniforms, B: Bindings>(
        name: &'static str,
        parts: &'static [Wgsl],
    ) -> Self {
        Self {
            name,
            uniforms: U::WGSL,
            buffers: B::NAMES,
            parts,
        }
    }

    /// Whether it has these uniforms and these buffers.
    pub(crate) fn takes<U: Uniforms, B: Bindings>(&self) -> bool {
        self.uniforms == U::WGSL && self.buffers == B::NAMES
    }

    /// The whole module.
    pub(crate) fn source(&self) -> String {
        let mut source = constants();
        source += self.uniforms;
        source += include_str!("../../fast_math/fast_math.wgsl");
        for part in self.parts {
            for (name, number) in part.numbers {
                source += &number.declared(name);
            }
            source += part.text;
        }
        source
    }

    /// The names of its bindings, in order of their numbers.
    pub(crate) fn bindings(&self) -> Vec<String> {
        let source = self.source();
        let mut bound: Vec<(u32, String)> = source.lines().filter_map(binding).collect();
        bound.sort();
        bound.into_iter().map(|(_, name)| name).collect()
    }
}

/// Number and variable name of a binding in a line of WGSL: `@group(0) @binding(1) var<storage> covered: array<u32>;`.
fn binding(line: &str) -> Option<(u32, String)> {
    let (number, variable) = line.strip_prefix("@group(0) @binding(")?.split_once(')')?;
    let (_, named) = variable.split_once("> ")?;
    let (name, _) = named.split_once(':')?;
    Some((number.parse().ok()?, name.into()))
}
