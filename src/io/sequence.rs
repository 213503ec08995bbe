//! Sequences: lists of frame numbers, and file names that hold one.

use crate::untrusted::Untrusted;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Frame numbers in order, each once; at least one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameList(Vec<i32>);

/// More frames than any sequence has: a longer list is a typing error.
const MOST_FRAMES: usize = 1_000_000;

impl FrameList {
    /// The numbers, rising.
    pub fn numbers(&self) -> &[i32] {
        &self.0
    }
}

impl std::str::FromStr for FrameList {
    type Err = String;

    /// `7`, `-3`, `1-12`, `1-12x2` or `1-12:2` for every second, `1-12y2` for the others, and several of them with
    /// commas between.
    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let mut numbers = Vec::new();
        for item in text.split(',') {
            numbers.extend(frames(item.trim())?);
            if numbers.len() > MOST_FRAMES {
                return Err(format!("more than {MOST_FRAMES} frames"));
            }
        }
        if numbers.is_empty() {
            return Err(format!("'{}' leaves no frame", Untrusted(text)));
        }
        numbers.sort_unstable();
        numbers.dedup();
        Ok(Self(numbers))
    }
}

/// The frames of one item of a list.
fn frames(item: &str) -> std::result::Result<Vec<i32>, String> {
    let name = Untrusted(item);
    let expected = || {
        format!("'{name}' is no list of frames; expected 7, 1-12, 1-12x2, 1-12:2, 1-12y2 or 1,5,9")
    };
    let (first, rest) = leading_number(item).ok_or_else(expected)?;
    let Some(rest) = rest.strip_prefix('-') else {
        return match rest.is_empty() {
            true => Ok(vec![first]),
            false => Err(expected()),
        };
    };
    let (last, rest) = leading_number(rest).ok_or_else(expected)?;
    if last < first {
        return Err(format!(
            "'{name}' runs backward; give the lower frame first"
        ));
    }
    let mut signs = rest.chars();
    let (sign, step) = (signs.next(), signs.as_str());
    let (others, step) = match sign {
        None => (false, 1),
        Some('x' | ':' | 'y') if step.bytes().all(|b| b.is_ascii_digit()) => {
            (sign == Some('y'), step.parse().map_err(|_| expected())?)
        }
        Some(_) => return Err(expected()),
    };
    if step == 0 {
        return Err(format!("'{name}' has a step of 0; give 1 or more"));
    }
    // One more than is allowed is enough to refuse them.
    let most = MOST_FRAMES + 1;
    let all = first..=last;
    Ok(match (others, step) {
        (false, _) => all.step_by(step).take(most).collect(),
        (true, 1) => Vec::new(),
        (true, _) => {
            let between = all.enumerate().filter(|(place, _)| place % step != 0);
            between.map(|(_, frame)| frame).take(most).collect()
        }
    })
}

/// The integer at the start of `text`, possibly negative, and the rest.
fn leading_number(text: &str) -> Option<(i32, &str)> {
    let digits = text.strip_prefix('-').unwrap_or(text);
    let count = digits.bytes().take_while(u8::is_ascii_digit).count();
    let (number, rest) = text.split_at(text.len() - digits.len() + count);
    Some((number.parse().ok()?, rest))
}

/// Whether `name` is a pattern for the file of each frame: it has `##` or more, or `%d`, `%04d`.
///
/// A single `#` is an ordinary character unless `frames` are given.
pub fn is_pattern(name: &str) -> bool {
    placeholders(name).any(|(place, _)| place.len() > 1)
}

/// The name for one frame: every run of `#` becomes the number, zero-padded to that many digits; so does `%04d`, and
/// `%d` without padding. `None` without a placeholder.
pub fn of_frame(name: &str, frame: i32) -> Option<String> {
    let mut made = String::new();
    let mut from = 0;
    for (place, digits) in placeholders(name) {
        made.push_str(&name[from..place.start]);
        made.push_str(&format!("{frame:0digits$}"));
        from = place.end;
    }
    (from > 0).then(|| made + &name[from..])
}

/// [`of_frame`] of a path.
pub fn path_of_frame(path: &Path, frame: i32) -> Option<PathBuf> {
    of_frame(path.to_str()?, frame).map(PathBuf::from)
}

/// The places of frame numbers in a name, and how many digits each has at least.
fn placeholders(name: &str) -> impl Iterator<Item = (Range<usize>, usize)> {
    let bytes = name.as_bytes();
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < bytes.len() {
            let start = at;
            if let Some((length, digits)) = placeholder(&bytes[start..]) {
                at += length;
                return Some((start..at, digits));
            }
            at += 1;
        }
        None
    })
}

/// Length and digits of the placeholder at the start of `text`.
fn placeholder(text: &[u8]) -> Option<(usize, usize)> {
    let hashes = text.iter().take_while(|&&b| b == b'#').count();
    if hashes > 0 {
        return Some((hashes, hashes));
    }
    let digits = text.strip_prefix(b"%")?;
    let count = digits.iter().take_while(|b| b.is_ascii_digit()).count();
    let is_number = digits.get(count) == Some(&b'd') && count <= 2;
    let width = std::str::from_utf8(&digits[..count]).ok()?;
    is_number.then(|| (count + 2, width.parse().unwrap_or(1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn list(text: &str) -> std::result::Result<Vec<i32>, String> {
        text.parse().map(|FrameList(numbers)| numbers)
    }

    #[test]
    fn frames_are_listed_in_order_and_once() {
        assert_eq!(list("7"), Ok(vec![7]));
        assert_eq!(list("1-4"), Ok(vec![1, 2, 3, 4]));
        assert_eq!(list("1-12x5"), Ok(vec![1, 6, 11]));
        assert_eq!(list("9, 1,5"), Ok(vec![1, 5, 9]));
        assert_eq!(
            list("1001-1003,1002-1005x3,1002"),
            Ok(vec![1001, 1002, 1003, 1005])
        );
        assert_eq!(list("0003-0003"), Ok(vec![3]));
        assert_eq!(list("1-10:3"), Ok(vec![1, 4, 7, 10]));
        assert_eq!(list("1-10x3,20"), Ok(vec![1, 4, 7, 10, 20]));
        assert_eq!(list("1-7y3"), Ok(vec![2, 3, 5, 6]));
        assert_eq!(list("-3"), Ok(vec![-3]));
        assert_eq!(list("-3-1"), Ok(vec![-3, -2, -1, 0, 1]));
        assert_eq!(list("-5--1:2"), Ok(vec![-5, -3, -1]));
        for wrong in [
            "",
            ",",
            "a",
            "1-",
            "--3",
            "1:2",
            "1-5z2",
            "1-5\u{e9}",
            "1-2-3",
            "1x2",
            "1-5x",
            "+1",
            "1-5x-1",
            "99999999999",
        ] {
            assert!(
                list(wrong).unwrap_err().contains("expected 7, 1-12"),
                "{wrong}"
            );
        }
        assert!(list("5-1").unwrap_err().contains("backward"));
        assert!(list("1--3").unwrap_err().contains("backward"));
        assert!(list("1-5x0").unwrap_err().contains("step of 0"));
        // Steps over long ranges do not visit every frame between.
        assert_eq!(
            list("1-2147483647x1000000000").unwrap(),
            [1, 1_000_000_001, 2_000_000_001]
        );
        assert!(
            list("1-2147483647y1")
                .unwrap_err()
                .contains("leaves no frame")
        );
        assert!(list("1-2147483647y2").unwrap_err().contains("more than"));
        // The complement of every frame is empty.
        assert!(list("-1-9y01").unwrap_err().contains("leaves no frame"));
        assert_eq!(list("1-9y1,4"), Ok(vec![4]));
        assert!(list("0-2147483647").unwrap_err().contains("more than"));
    }

    #[test]
    fn names_take_numbers() {
        let of = |name| of_frame(name, 42);
        assert_eq!(of("shot.####.exr").unwrap(), "shot.0042.exr");
        assert_eq!(of("shot.#.exr").unwrap(), "shot.42.exr");
        assert_eq!(of("%04d/shot.%d.exr").unwrap(), "0042/shot.42.exr");
        assert_eq!(of("s_###_%3d").unwrap(), "s_042_042");
        assert_eq!(of_frame("a.##.png", 12345).unwrap(), "a.12345.png");
        // In the format of C.
        assert_eq!(of_frame("a.####.png", -7).unwrap(), "a.-007.png");
        for none in ["shot.exr", "100%.png", "%s.png", "%x4d", "%123d"] {
            assert_eq!(of(none), None, "{none}");
        }
        assert!(is_pattern("a.##.png") && is_pattern("a.%d.png"));
        assert!(!is_pattern("take #1.png") && !is_pattern("100%.png"));
    }
}
