//! Tools for kernels: vectors as wide as the machine's, elementary functions, quantiles, shelves and caches. They know
//! nobody.

pub(crate) mod cancel;
pub(crate) mod fast_math;
pub(crate) mod lanes;
pub(crate) mod last;
pub(crate) mod quantile;
pub(crate) mod shelf;
pub(crate) mod simd;
pub(crate) mod timings;
