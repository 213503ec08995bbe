//! Uniform blocks shared by Rust and WGSL.

/// A struct of numbers and vectors, in WGSL layout order; the size of the frame precedes them.
pub(crate) trait Uniforms {
    /// The struct and the variable in WGSL.
    const WGSL: &'static str;

    /// Adds the numbers as bytes.
    fn add_to(&self, bytes: &mut Vec<u8>);
}

/// A field of a uniform block: a number, or a vector.
pub(crate) trait UniformField: bytemuck::Pod {
    /// Bytes that its place is a multiple of.
    const ALIGNMENT: usize = 4;

    fn add_to(&self, bytes: &mut Vec<u8>) {
        bytes.resize(bytes.len().next_multiple_of(Self::ALIGNMENT), 0);
        bytes.extend(bytemuck::bytes_of(self));
    }
}

impl UniformField for f32 {}
impl UniformField for u32 {}
impl UniformField for i32 {}

impl UniformField for [f32; 2] {
    const ALIGNMENT: usize = 8;
}

impl UniformField for [u32; 2] {
    const ALIGNMENT: usize = 8;
}

impl UniformField for [f32; 3] {
    const ALIGNMENT: usize = 16;
}

impl UniformField for [f32; 4] {
    const ALIGNMENT: usize = 16;
}

/// The bytes of a block for a frame of this size; blocks end as their widest vectors do.
pub(crate) fn bytes_of(size: [u32; 2], uniforms: &impl Uniforms) -> Vec<u8> {
    let mut bytes = bytemuck::bytes_of(&size).to_vec();
    uniforms.add_to(&mut bytes);
    bytes.resize(bytes.len().next_multiple_of(16), 0);
    bytes
}

/// Defines structs in both languages. Fields are `f32`, `u32`, `i32`, or vectors: `vec2`, `vec3` and `vec4` of `f32`,
/// `vec2u` of `u32`.
macro_rules! uniforms {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $kind:ident,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub(crate) struct $name {
                $($(#[$field_doc])* pub(crate) $field: $crate::gpu::uniforms::field!($kind),)*
            }

            impl $crate::gpu::uniforms::Uniforms for $name {
                const WGSL: &'static str = concat!(
                    "struct ", stringify!($name), " {\n    width: u32,\n    height: u32,\n",
                    $("    ", stringify!($field), ": ", $crate::gpu::uniforms::wgsl_field!($kind), ",\n",)*
                    "}\n@group(0) @binding(0) var<uniform> params: ", stringify!($name), ";\n",
                );

                fn add_to(&self, bytes: &mut Vec<u8>) {
                    $($crate::gpu::uniforms::UniformField::add_to(&self.$field, bytes);)*
                }
            }
        )*
    };
}

#[rustfmt::skip]
macro_rules! field {
    (vec2) => { [f32; 2] };
    (vec2u) => { [u32; 2] };
    (vec3) => { [f32; 3] };
    (vec4) => { [f32; 4] };
    ($kind:ident) => { $kind };
}

#[rustfmt::skip]
macro_rules! wgsl_field {
    (vec2) => { "vec2<f32>" };
    (vec2u) => { "vec2<u32>" };
    (vec3) => { "vec3<f32>" };
    (vec4) => { "vec4<f32>" };
    ($kind:ident) => { stringify!($kind) };
}

pub(crate) use {field, uniforms, wgsl_field};
