//! Names of device timings that belong to no stage.

/// Copies to the device.
pub(crate) const UPLOAD: &str = "upload";

/// Recording of commands for the device.
pub(crate) const RECORD: &str = "record";

/// All kernels together, on a device without a clock per stage.
pub(crate) const KERNELS: &str = "kernels";

/// Copies from the device.
pub(crate) const READ_BACK: &str = "read-back";
