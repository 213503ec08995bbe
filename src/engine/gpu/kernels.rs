//! Kernels: WGSL composed of shared parts.

use crate::engine::gpu::bindings::Bindings;
use crate::engine::gpu::constants::constants;
use crate::engine::gpu::uniforms::Uniforms;
use crate::engine::gpu::wgsl::Wgsl;

/// A kernel, declared beside the pass that runs it.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// Its unique name.
    pub(crate) name: &'static str,
    /// The definition of its uniform block.
    uniforms: &'static str,
    /// Declarations of its buffers.
    buffers: &'static [&'static str],
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
            buffers: B::WGSL,
            parts,
        }
    }

    /// Whether it has these uniforms and these buffers.
    pub(crate) fn takes<U: Uniforms, B: Bindings>(&self) -> bool {
        self.uniforms == U::WGSL && self.buffers == B::WGSL
    }

    /// The whole module.
    pub(crate) fn source(&self) -> String {
        let mut source = constants();
        source += self.uniforms;
        for (binding, declared) in (1..).zip(self.buffers) {
            source += &format!("@group(0) @binding({binding}) {declared}");
        }
        source += include_str!("../../kernel/fast_math/fast_math.wgsl");
        source += include_str!("index.wgsl");
        if source.contains("> covered:") {
            source += include_str!("coverage.wgsl");
        }
        for part in self.parts {
            for (name, number) in part.numbers {
                source += &number.declared(name);
            }
            source += part.text;
        }
        source
    }
}
