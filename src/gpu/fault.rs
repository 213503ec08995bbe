//! Device faults.

use crate::error::Error;
use crate::gpu::device::Device;

/// Why a run failed.
#[derive(Debug)]
pub(crate) enum RunFault {
    /// The frame exceeds the limits of the device, or its free memory.
    TooLarge(Error),
    /// Anything else.
    Other(Error),
}

impl RunFault {
    pub(crate) fn into_error(self) -> Error {
        match self {
            Self::TooLarge(error) | Self::Other(error) => error,
        }
    }
}

impl From<Error> for RunFault {
    fn from(error: Error) -> Self {
        Self::Other(error)
    }
}

/// Does `work` and turns errors that the device reports meanwhile into its fault.
///
/// # Errors
/// The error that the device reported, or else the result of `work`.
pub(crate) fn watched<T>(
    device: &Device,
    work: impl FnOnce() -> Result<T, RunFault>,
) -> Result<T, RunFault> {
    let scope = |filter| device.device.push_error_scope(filter);
    let memory = scope(wgpu::ErrorFilter::OutOfMemory);
    let internal = scope(wgpu::ErrorFilter::Internal);
    let validation = scope(wgpu::ErrorFilter::Validation);
    let done = work();
    // The innermost scope ends first.
    let validation = pollster::block_on(validation.pop());
    let internal = pollster::block_on(internal.pop());
    let memory = pollster::block_on(memory.pop());
    match first([memory, internal, validation]) {
        None => done,
        Some(error @ wgpu::Error::OutOfMemory { .. }) => {
            let found = format!("has too little memory ({error})");
            Err(RunFault::TooLarge(device.error(found)))
        }
        Some(error) => Err(RunFault::Other(device.error(error))),
    }
}

/// The root error of a run: after an out-of-memory error, others follow from it.
fn first(errors: [Option<wgpu::Error>; 3]) -> Option<wgpu::Error> {
    errors.into_iter().flatten().next()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_from_a_want_of_memory_is_not_told_instead() {
        let source = || "test".into();
        let memory = || wgpu::Error::OutOfMemory { source: source() };
        let invalid = || wgpu::Error::Validation {
            source: source(),
            description: "buffer is invalid".into(),
        };
        let message = |errors| first(errors).map(|error| error.to_string());
        let both = message([Some(memory()), None, Some(invalid())]);
        assert_eq!(both, Some(memory().to_string()));
        let invalid_alone = message([None, None, Some(invalid())]);
        assert_eq!(invalid_alone, Some(invalid().to_string()));
        assert_eq!(message([None, None, None]), None);
    }
}
