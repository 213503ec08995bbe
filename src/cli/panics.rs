//! Panics: reported in one line each, and a sequence continues.

use crate::error::{Error, Result};
use std::any::Any;
use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::path::Path;
use std::sync::{Mutex, Once, PoisonError};

/// Location of the last panic, as "src/file.rs:12".
static PLACE: Mutex<String> = Mutex::new(String::new());

static HOOK: Once = Once::new();

/// Keeps panics from printing: [`caught`] makes an error of one line of them. With RUST_BACKTRACE set they still do.
pub(crate) fn keep_quiet() {
    HOOK.call_once(|| {
        let usual = take_hook();
        set_hook(Box::new(move |info: &PanicHookInfo| {
            if let Some(place) = info.location() {
                let mut last = PLACE.lock().unwrap_or_else(PoisonError::into_inner);
                *last = format!("{}:{}", place.file(), place.line());
            }
            if std::env::var_os("RUST_BACKTRACE").is_some_and(|value| value != "0") {
                usual(info);
            }
        }));
    });
}

/// The result of `work` on `path`; a panic becomes an error.
///
/// State that `work` shares is either immutable or behind locks that keep it consistent.
pub(super) fn caught<T>(path: &Path, work: impl FnOnce() -> Result<T>) -> Result<T> {
    unless_panicked(work).unwrap_or_else(|found| {
        Err(Error::Fault {
            path: path.into(),
            found,
        })
    })
}

/// The result of `work`, or the message of a panic and where it was.
pub(crate) fn unless_panicked<T>(work: impl FnOnce() -> T) -> std::result::Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).map_err(|panic| {
        let place = PLACE.lock().unwrap_or_else(PoisonError::into_inner);
        format!("{} at {place}", message_of(&*panic))
    })
}

fn message_of(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<&str>().copied();
    text.or_else(|| panic.downcast_ref::<String>().map(String::as_str))
        .unwrap_or("a panic")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_of_one_line() {
        assert_eq!(caught(Path::new("a.exr"), || Ok(3)).unwrap(), 3);
        let none: Vec<u8> = Vec::new();
        let failed = caught(Path::new("a.exr"), || Ok(none[7])).unwrap_err();
        let line = failed.to_string();
        assert!(
            line.starts_with("a.exr: a fault of relievo itself (index out of bounds"),
            "{line}"
        );
        assert!(!line.contains('\n'), "{line}");
    }
}
