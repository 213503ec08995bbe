//! The buffers of a kernel, by their names in WGSL.

/// Buffers with the names of the variables they are bound to.
pub(crate) trait Bindings {
    /// The names, in the order of the struct.
    const NAMES: &'static [&'static str];

    /// Each name with its buffer.
    fn named(&self) -> Vec<(&'static str, &wgpu::Buffer)>;
}

/// Defines a struct of buffers for each kernel.
macro_rules! bindings {
    ($($kernel:ident { $($buffer:ident),* })*) => {
        $(
            pub(crate) struct $kernel<'b> {
                $(pub(crate) $buffer: &'b wgpu::Buffer,)*
            }

            impl $crate::engine::gpu::bindings::Bindings for $kernel<'_> {
                const NAMES: &'static [&'static str] = &[$(stringify!($buffer)),*];

                fn named(&self) -> Vec<(&'static str, &wgpu::Buffer)> {
                    vec![$((stringify!($buffer), self.$buffer)),*]
                }
            }
        )*
    };
}

pub(crate) use bindings;
