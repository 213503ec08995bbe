//! Device faults, and the reaction to running out of memory.

use crate::engine::gpu::device::Device;
use crate::error::Error;

/// Why a run failed.
#[derive(Debug)]
pub(crate) enum Fault {
    /// Out of memory.
    Memory(Error),
    /// Even a strip of one row exceeds the requested plane size.
    Strips(Error),
    /// Anything else.
    Other(Error),
}

impl Fault {
    pub(crate) fn into_error(self) -> Error {
        match self {
            Self::Memory(error) | Self::Strips(error) | Self::Other(error) => error,
        }
    }
}

impl From<Error> for Fault {
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
    work: impl FnOnce() -> Result<T, Fault>,
) -> Result<T, Fault> {
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
            Err(Fault::Memory(device.error(found)))
        }
        Some(error) => Err(Fault::Other(device.error(error))),
    }
}

/// The root error of a run: after an out-of-memory error, others follow from it.
fn first(errors: [Option<wgpu::Error>; 3]) -> Option<wgpu::Error> {
    errors.into_iter().flatten().next()
}

/// Attempts work with planes of at most `plane_bytes`, halving that while the device is out of memory.
///
/// # Errors
/// Those of the attempts; out of memory if strips cannot be made smaller.
pub(crate) fn in_memory<T>(
    mut plane_bytes: u64,
    mut attempt: impl FnMut(u64) -> Result<T, Fault>,
) -> Result<T, Error> {
    let mut wanting = None;
    loop {
        match (attempt(plane_bytes), wanting.take()) {
            (Err(Fault::Memory(error)), before) if plane_bytes > 1 => {
                wanting = before.or(Some(error));
                plane_bytes /= 2;
            }
            (Err(Fault::Strips(_)), Some(memory)) => return Err(memory),
            (done, _) => return done.map_err(Fault::into_error),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn error(found: &str) -> Error {
        Error::Gpu {
            device: "test".into(),
            found: found.into(),
        }
    }

    #[test]
    fn planes_are_halved_until_there_is_memory() {
        let mut asked = Vec::new();
        let done = in_memory(1000, |bytes| {
            asked.push(bytes);
            match bytes {
                0..=300 => Ok(bytes),
                _ => Err(Fault::Memory(error("too little"))),
            }
        });
        assert_eq!((done.unwrap(), asked), (250, vec![1000, 500, 250]));
    }

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

    #[test]
    fn where_strips_end_the_want_of_memory_is_told() {
        let failed = in_memory(64, |bytes| -> Result<(), Fault> {
            match bytes {
                0..=20 => Err(Fault::Strips(error("takes 0 rows"))),
                _ => Err(Fault::Memory(error("too little"))),
            }
        });
        assert_eq!(
            failed.unwrap_err().to_string(),
            error("too little").to_string()
        );
        let never = in_memory(64, |_| -> Result<(), Fault> {
            Err(Fault::Memory(error("none at all")))
        });
        assert!(never.unwrap_err().to_string().contains("none at all"));
        let strips = in_memory(64, |_| -> Result<(), Fault> {
            Err(Fault::Strips(error("takes 0 rows")))
        });
        assert!(strips.unwrap_err().to_string().contains("0 rows"));
    }
}
