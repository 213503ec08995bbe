//! Words of lists, and texts of messages.

/// Whether `word` is one of `words`, which have blanks between them.
pub(in crate::io) fn is_one_of(word: &str, words: &str) -> bool {
    words.split_whitespace().any(|own| own == word)
}

/// `text` with every run of white space and control characters as one blank.
pub(in crate::io) fn one_line(text: &str) -> String {
    let visible = |c: char| if c.is_control() { ' ' } else { c };
    let spaced: String = text.chars().map(visible).collect();
    spaced.split_whitespace().collect::<Vec<_>>().join(" ")
}
