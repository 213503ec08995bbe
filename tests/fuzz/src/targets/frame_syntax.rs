//! Any text as a list of frames, and as a name with their numbers.

use relievo::io::sequence::{FrameList, is_pattern, of_frame};

pub(super) fn run(data: &[u8]) {
    let Ok(text) = std::str::from_utf8(data) else {
        return;
    };
    if let Ok(list) = text.parse::<FrameList>() {
        let numbers = list.numbers();
        assert!(!numbers.is_empty());
        assert!(numbers.windows(2).all(|pair| pair[0] < pair[1]));
    }
    let named = of_frame(text, -7);
    assert!(!is_pattern(text) || named.is_some());
    if let Some(name) = named {
        assert!(name.contains('7'));
    }
}
