//! Uniform blocks shared by Rust and WGSL.

/// A struct of 32-bit numbers, in WGSL layout order.
pub(crate) trait Uniforms {
    /// The struct and the variable in WGSL.
    const WGSL: &'static str;

    /// The numbers as bytes, in order.
    fn bytes(&self) -> Vec<u8>;
}

/// Defines structs in both languages. Fields are `f32`, `u32` or `i32`.
macro_rules! uniforms {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $kind:ident,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub(crate) struct $name {
                $($(#[$field_doc])* pub(crate) $field: $kind,)*
            }

            impl $crate::engine::gpu::uniforms::Uniforms for $name {
                const WGSL: &'static str = concat!(
                    "struct ", stringify!($name), " {\n",
                    $("    ", stringify!($field), ": ", stringify!($kind), ",\n",)*
                    "}\n@group(0) @binding(0) var<uniform> params: ", stringify!($name), ";\n",
                );

                fn bytes(&self) -> Vec<u8> {
                    let mut bytes = Vec::new();
                    $(bytes.extend(self.$field.to_ne_bytes());)*
                    bytes
                }
            }
        )*
    };
}

pub(crate) use uniforms;
