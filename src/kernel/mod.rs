//! Tools for kernels: vectors as wide as the machine's, rows in parallel, recycled planes, elementary functions,
//! quantiles. They know no stage.

pub(crate) mod cancel;
pub(crate) mod fast_math;
pub(crate) mod lanes;
pub(crate) mod last;
pub(crate) mod memory;
pub(crate) mod percentile;
pub(crate) mod quantile;
pub(crate) mod rows;
pub(crate) mod simd;
