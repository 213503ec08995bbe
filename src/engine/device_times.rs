//! What the times of a run on a device are called that are of no stage.

/// Copies to the device.
pub(crate) const UPLOAD: &str = "upload";

/// Telling the device what to run.
pub(crate) const RECORD: &str = "record";

/// All kernels together, on a device without a clock for each stage.
pub(crate) const KERNELS: &str = "kernels";

/// Copies from the device.
pub(crate) const READ_BACK: &str = "read-back";
