//! The existing frames of a sequence.

use crate::io::sequence::{is_pattern, path_of_frame};
use std::path::Path;

/// Numbers of the frames on disk that match `pattern`, ascending; `None` for a single picture.
#[cfg_attr(
    not(feature = "host"),
    allow(unreachable_pub, reason = "public as part of the host")
)]
pub fn frames_on_disk(pattern: &Path) -> Option<Vec<i32>> {
    let name = pattern
        .file_name()?
        .to_str()
        .filter(|name| is_pattern(name))?;
    let folder = match pattern.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let place = name.find(['#', '%'])?;
    let mut frames: Vec<i32> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .filter_map(|entry| {
            let found = entry.ok()?.file_name().into_string().ok()?;
            let number = number_at(&found, place)?;
            let expected = path_of_frame(Path::new(name), number)?;
            (expected == Path::new(&found)).then_some(number)
        })
        .collect();
    frames.sort_unstable();
    frames.dedup();
    Some(frames)
}

/// The whole number in `name` from byte `place` on.
fn number_at(name: &str, place: usize) -> Option<i32> {
    let rest = name.get(place..)?;
    let sign = usize::from(rest.starts_with('-'));
    let digits = rest[sign..].bytes().take_while(u8::is_ascii_digit).count();
    rest[..sign + digits].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_found_by_their_names() {
        let folder = tempfile::tempdir().unwrap();
        let names = [
            "a.0007.exr",
            "a.0101.exr",
            "a.12.exr",
            "b.0003.exr",
            "a.x.exr",
            "a.0008.png",
        ];
        for name in names {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        let of = |name: &str| frames_on_disk(&folder.path().join(name));
        assert_eq!(of("a.####.exr"), Some(vec![7, 101]));
        assert_eq!(of("a.%d.exr"), Some(vec![12]));
        assert_eq!(of("c.####.exr"), Some(vec![]));
        assert_eq!(of("a.0007.exr"), None);
    }
}
