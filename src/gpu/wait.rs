//! Waiting for a device that may be lost meanwhile.

use std::cell::Cell;
use std::panic::{self, AssertUnwindSafe};
use std::sync::Once;

thread_local! {
    /// Whether this thread is waiting for a device.
    static WAITS: Cell<bool> = const { Cell::new(false) };
}

/// Waits until the device has finished the submission with that index, or else all submissions.
///
/// # Errors
/// Why the device was lost.
pub(crate) fn wait_for(
    device: &wgpu::Device,
    submission_index: Option<wgpu::SubmissionIndex>,
) -> Result<(), String> {
    let wait = || {
        device.poll(wgpu::PollType::Wait {
            submission_index,
            timeout: None,
        })
    };
    match without_panic(wait)? {
        Ok(_) => Ok(()),
        Err(error) => Err(error.to_string()),
    }
}

/// Polls the device for its callbacks, without waiting.
pub(crate) fn look_after(device: &wgpu::Device) {
    // Errors arrive in the callback.
    let _ = without_panic(|| device.poll(wgpu::PollType::Poll));
}

/// Runs a poll that panics if the device is lost: wgpu has no error for that.
///
/// # Errors
/// The message of the panic, which is not printed.
fn without_panic<T>(poll: impl FnOnce() -> T) -> Result<T, String> {
    static QUIET: Once = Once::new();
    QUIET.call_once(|| {
        let usual = panic::take_hook();
        panic::set_hook(Box::new(move |panicked| {
            if !WAITS.get() {
                usual(panicked);
            }
        }));
    });
    WAITS.set(true);
    let polled = panic::catch_unwind(AssertUnwindSafe(poll));
    WAITS.set(false);
    polled.map_err(|payload| match payload.downcast::<String>() {
        Ok(message) => *message,
        Err(_) => "it does not answer".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_while_waiting_is_an_error() {
        let lost = "parent device is lost";
        let failed = without_panic(|| -> () { panic!("{lost}") });
        assert_eq!(failed, Err(lost.to_string()));
        assert_eq!(without_panic(|| 3), Ok(3));
        // Other panics pass through.
        assert!(!WAITS.get());
    }
}
