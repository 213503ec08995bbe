//! The buffers of a kernel.

/// Buffers with the names and types of the WGSL variables that they are bound to, after the uniform block.
pub(crate) trait Bindings {
    /// Declarations in WGSL, in the order of the struct.
    const WGSL: &'static [&'static str];

    /// The buffers in that order.
    fn buffers(&self) -> Vec<&wgpu::Buffer>;
}

/// Defines a struct of buffers for each kernel. Their WGSL is that of slices: `&[f32]` or `&mut [f32]`.
macro_rules! bindings {
    ($($kernel:ident { $($(#[$doc:meta])* $buffer:ident: & $($mutable:ident)? [$($element:tt)+],)* })*) => {
        $(
            pub(crate) struct $kernel<'b> {
                $($(#[$doc])* pub(crate) $buffer: &'b wgpu::Buffer,)*
            }

            impl $crate::engine::gpu::bindings::Bindings for $kernel<'_> {
                const WGSL: &'static [&'static str] = &[$(concat!(
                    "var<storage, ", $crate::engine::gpu::bindings::access!($($mutable)?), "> ",
                    stringify!($buffer), ": array<", stringify!($($element)+), ">;\n",
                )),*];

                fn buffers(&self) -> Vec<&wgpu::Buffer> {
                    vec![$(self.$buffer),*]
                }
            }
        )*
    };
}

macro_rules! access {
    () => {
        "read"
    };
    (mut) => {
        "read_write"
    };
}

pub(crate) use {access, bindings};
