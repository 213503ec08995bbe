//! Devices: kernels in WGSL with the parameters that they take, buffers, and work that is recorded and read back. They
//! know no stage.

pub(crate) mod buffers;
pub(crate) mod constants;
pub(crate) mod device;
pub(crate) mod fault;
pub(crate) mod kernels;
pub(crate) mod limits;
pub(crate) mod recorder;
pub(crate) mod sight;
pub(crate) mod surface;
pub(crate) mod uniforms;
pub(crate) mod wait;
pub(crate) mod wgsl;
