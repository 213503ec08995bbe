//! A fence around decoders of untrusted files: a panic inside becomes an error outside.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook, take_hook};
use std::sync::Once;

thread_local! {
    static FENCED: Cell<bool> = const { Cell::new(false) };
}

static HOOK: Once = Once::new();

/// The result of `decode`, or `None` if it panicked; then nothing is printed.
///
/// Only panics of the calling thread, inside `decode`, are silent: all others reach the hook that
/// was installed before the first call. An allocation that fails still ends the process, so sizes
/// have to be checked before.
pub(crate) fn fenced<T>(decode: impl FnOnce() -> T) -> Option<T> {
    HOOK.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |info| {
            if !FENCED.try_with(Cell::get).unwrap_or(false) {
                usual(info);
            }
        }));
    });
    let before = FENCED.replace(true);
    // State that `decode` may leave inconsistent is dropped with its result.
    let result = catch_unwind(AssertUnwindSafe(decode));
    FENCED.set(before);
    result.ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_none_and_the_fence_opens_again() {
        assert_eq!(fenced(|| 3), Some(3));
        let nothing: Option<()> = fenced(|| panic!("inside"));
        assert_eq!(nothing, None);
        assert!(!FENCED.get());
    }

    #[test]
    fn fences_nest() {
        let outer = fenced(|| {
            assert_eq!(fenced(|| -> u8 { panic!("inner") }), None);
            FENCED.get()
        });
        assert_eq!(outer, Some(true));
    }
}
