//! Kernels: WGSL composed of shared parts.

use crate::gpu::constants::{STRIP_ROWS, constants};
use crate::gpu::uniforms::Uniforms;
use crate::gpu::wgsl::Wgsl;

/// A kernel, declared beside the pass that runs it.
#[derive(Debug)]
pub(crate) struct Kernel {
    /// Its unique name.
    pub(crate) name: &'static str,
    /// The definition of its uniform block.
    uniforms: &'static str,
    /// Its buffers in the order of their bindings: `covered: u32; normal_x, normal_y: f32; weights?: mut vec2<f32>`. `mut`
    /// ones are written; `?` ones only where a switch says that they are there.
    buffers: &'static str,
    /// Its WGSL, after the part common to all kernels.
    parts: &'static [Wgsl],
    /// Rows of pixels per invocation.
    pub(crate) rows: u32,
}

/// A buffer of a kernel.
pub(crate) struct Binding {
    /// Its WGSL variable, and the plane bound to it where none is named.
    pub(crate) name: &'static str,
    /// Its elements in WGSL: one for each pixel of a plane that the kernel makes.
    element: &'static str,
    pub(crate) is_written: bool,
    pub(crate) is_optional: bool,
}

impl Binding {
    /// Bytes of an element.
    pub(crate) fn element_bytes(&self) -> u64 {
        match self.element {
            "vec4<f32>" => 16,
            "vec2<f32>" => 8,
            _ => 4,
        }
    }
}

impl Kernel {
    /// A kernel with these uniforms and these buffers.
    pub(crate) const fn new<U: Uniforms>(
        name: &'static str,
        buffers: &'static str,
        parts: &'static [Wgsl],
    ) -> Self {
        Self {
            name,
            uniforms: U::WGSL,
            buffers,
            parts,
            rows: 1,
        }
    }

    /// With several rows of pixels per invocation.
    pub(crate) const fn by_strips(self) -> Self {
        Self {
            rows: STRIP_ROWS,
            ..self
        }
    }

    /// Its buffers.
    pub(crate) fn bindings(&self) -> impl Iterator<Item = Binding> {
        self.buffers.split(';').flat_map(|group| {
            let (names, kind) = group.split_once(':').expect("names have a type");
            let element = kind.trim().trim_start_matches("mut ");
            let is_written = element.len() < kind.trim().len();
            names.split(',').map(move |name| Binding {
                name: name.trim().trim_end_matches('?'),
                element,
                is_written,
                is_optional: name.contains('?'),
            })
        })
    }

    /// Whether it has these uniforms.
    pub(crate) fn takes<U: Uniforms>(&self) -> bool {
        self.uniforms == U::WGSL
    }

    /// The whole module.
    pub(crate) fn source(&self) -> String {
        let mut source = constants();
        source += self.uniforms;
        for (at, buffer) in (1..).zip(self.bindings()) {
            let Binding { name, element, .. } = buffer;
            let access = ["read", "read_write"][usize::from(buffer.is_written)];
            source += &format!(
                "@group(0) @binding({at}) var<storage, {access}> {name}: array<{element}>;\n"
            );
        }
        source += include_str!("../kernel/fast_math/fast_math.wgsl");
        source += include_str!("index.wgsl");
        if self.bindings().any(|buffer| buffer.name == "covered") {
            source += include_str!("coverage.wgsl");
        }
        for part in self.parts {
            for (name, number) in part.numbers {
                source += &number.declared(name);
            }
            source += part.text;
        }
        if !source.contains("@compute") {
            source += include_str!("pixels.wgsl");
        }
        source
    }
}
