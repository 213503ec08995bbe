//! Names from files and arguments are untrusted text: each place that shows or uses one has its own spelling of it.

use std::borrow::Cow;
use std::fmt::{self, Display};
use std::path::Path;

/// Most characters of a name in a message: of longer ones the middle is left out.
const LONGEST_NAME: usize = 120;

/// As many of them are left for the folders of a path.
const LEAST_OF_FOLDERS: usize = 20;

/// Most characters of a word: a name in quotes or brackets, with a colon.
#[cfg(feature = "cli")]
const LONGEST_WORD: usize = LONGEST_NAME + 8;

/// Most characters of a list of names in a message.
const LONGEST_LIST: usize = 1000;

/// Most characters of a message, however many names it has.
#[cfg(feature = "cli")]
const LONGEST_LINE: usize = 2000;

/// Stands for what is left out.
const LEFT_OUT: &str = "\u{2026}";

/// A name from a file or an argument. Displayed as in a message: on one line, and cut in the middle where it is long.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Untrusted<'a>(pub(crate) &'a str);

impl Display for Untrusted<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // Pads it where a table asks for that.
        f.pad(&cut(&printable(self.0), LONGEST_NAME))
    }
}

impl Untrusted<'_> {
    /// The name as a word that a shell takes as it stands, if it is one; a word that begins with `-` would be an option.
    #[cfg(feature = "cli")]
    pub(crate) fn shell_word(&self) -> Option<&str> {
        let is_plain = |c: char| c.is_alphanumeric() || "._-:/+@,=".contains(c);
        let is_word =
            !self.0.is_empty() && !self.0.starts_with('-') && self.0.chars().all(is_plain);
        is_word.then_some(self.0)
    }

    /// The name as a word to be typed in a shell: as it stands, or in quotes.
    #[cfg(feature = "cli")]
    pub(crate) fn word(&self) -> String {
        self.shell_word()
            .map_or_else(|| self.quoted(), String::from)
    }

    /// The name in quotes that keep a shell from changing it, for flags that messages give to be typed.
    pub(crate) fn quoted(&self) -> String {
        let Self(text) = self;
        match text.contains(['"', '$', '`', '\\', '!']) {
            false => format!("\"{text}\""),
            true => format!("'{}'", text.replace('\'', r"'\''")),
        }
    }

    /// The name as text of HTML: all that may be markup is spelled as a number.
    #[cfg(feature = "cli")]
    pub(crate) fn html(&self) -> String {
        let spelled = self.to_string();
        let spelled = spelled.chars().map(|c| match c {
            _ if c.is_alphanumeric() || " _.-+,=@:/()%".contains(c) => c.to_string(),
            _ => format!("&#{};", u32::from(c)),
        });
        spelled.collect()
    }

    /// The name as one component of a path below a folder.
    #[cfg(feature = "cli")]
    pub(crate) fn path_component(&self) -> Option<&str> {
        let is_one =
            !matches!(self.0, "" | "." | "..") && !self.0.contains(std::path::is_separator);
        is_one.then_some(self.0)
    }
}

/// A path, displayed as [`Untrusted`] names are: its folders are cut first, so that the name of the file stays readable.
pub(crate) fn shown(path: &Path) -> String {
    let path = path.to_string_lossy();
    let path = printable(&path);
    let name_at = path.rfind(std::path::is_separator).map_or(0, |at| at + 1);
    if name_at == 0 || path.chars().count() <= LONGEST_NAME {
        return cut(&path, LONGEST_NAME).into();
    }
    let (folders, name) = path.split_at(name_at);
    let name = cut(name, LONGEST_NAME - LEAST_OF_FOLDERS);
    let folders = cut(folders, LONGEST_NAME - name.chars().count());
    [folders, name].concat()
}

/// Names in a message, as many as fit.
pub(crate) fn listed<T: AsRef<str>>(names: &[T]) -> String {
    let mut list = String::new();
    for (i, name) in names.iter().enumerate() {
        if list.len() > LONGEST_LIST {
            return format!("{list} and {} more", names.len() - i);
        }
        let comma = if i > 0 { ", " } else { "" };
        list += &format!("{comma}{}", Untrusted(name.as_ref()));
    }
    list
}

/// A message as printed: on one line, its words and itself of bounded length.
#[cfg(feature = "cli")]
pub(crate) fn bounded(line: &str) -> String {
    let line = printable(line);
    let words = line.split(' ').map(|word| match word.chars().count() {
        // Cut already, or short.
        ..=LONGEST_WORD => word.into(),
        _ => cut(word, LONGEST_NAME),
    });
    cut(&words.collect::<Vec<_>>().join(" "), LONGEST_LINE).into_owned()
}

/// `text` without its middle where it has more than `most` characters.
fn cut(text: &str, most: usize) -> Cow<'_, str> {
    // No character takes less than a byte.
    if text.len() <= most || text.chars().count() <= most {
        return text.into();
    }
    let kept = most - 1;
    let place = |(at, _)| at;
    let begin = text.char_indices().nth(kept.div_ceil(2)).map_or(0, place);
    let end = text.char_indices().rev().nth(kept / 2 - 1).map_or(0, place);
    [&text[..begin], LEFT_OUT, &text[end..]].concat().into()
}

/// `line` with characters escaped as in JSON that would control the terminal, end the line or change the writing
/// direction.
pub(crate) fn printable(line: &str) -> Cow<'_, str> {
    if !line.contains(steers) {
        return line.into();
    }
    let spelled = |c: char| match steers(c) {
        true => format!("\\u{:04x}", u32::from(c)),
        false => c.to_string(),
    };
    line.chars().map(spelled).collect::<String>().into()
}

/// Whether a terminal interprets `c` instead of showing it: control characters, line and paragraph separators, and
/// marks of writing direction. All have at most four hexadecimal digits.
fn steers(c: char) -> bool {
    let turns = |c| matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{206f}');
    c.is_control() || turns(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_steer_a_terminal_is_spelled_out() {
        let said = printable("a\u{1b}[31mb\u{7}\rc\nd\u{9b}2Je\u{202e}f\u{7f}");
        assert_eq!(
            said,
            r"a\u001b[31mb\u0007\u000dc\u000ad\u009b2Je\u202ef\u007f"
        );
        for plain in ["Übung 面 é 🦀 ViewLayer.Normal.X", ""] {
            assert!(matches!(printable(plain), Cow::Borrowed(text) if text == plain));
        }
        // JSON reads the same spelling back as the same characters.
        let json = serde_json::to_string("\u{1b}\u{202e}\u{85}").unwrap();
        let read: String = serde_json::from_str(&printable(&json)).unwrap();
        assert_eq!(read, "\u{1b}\u{202e}\u{85}");
    }

    #[cfg(feature = "cli")]
    #[test]
    fn long_names_lose_their_middle() {
        // 60 characters, the mark, and 59: 120 in all, of which each é has two bytes.
        let name = "é".repeat(60) + &"x".repeat(1000) + &"b".repeat(59);
        let expected = format!("{}{LEFT_OUT}{}", "é".repeat(60), "b".repeat(59));
        assert_eq!(Untrusted(&name).to_string(), expected);
        let whole = "é".repeat(120);
        assert_eq!(Untrusted(&whole).to_string(), whole);
        // 100 characters are left of the file's name, and of the folders the first 10, the mark and the last 9.
        let path = format!("/{}/{}", "folder/".repeat(99), "x".repeat(300));
        let expected_path = format!(
            "/folder/fo{LEFT_OUT}/folder//{}{LEFT_OUT}{}",
            "x".repeat(50),
            "x".repeat(49)
        );
        assert_eq!(shown(Path::new(&path)), expected_path);
        let path = format!("/{}{}.exr", "folder/".repeat(99), "n".repeat(80));
        assert!(shown(Path::new(&path)).ends_with(&format!("/{}.exr", "n".repeat(80))));
        // Marks do not make a name longer.
        let line = format!("'{expected_path}': no");
        assert_eq!(bounded(&line), line);
        // Words are cut each, and a line of many as a whole.
        let line = bounded(&format!("a.exr: {name} is no layer; name one"));
        assert_eq!(line, format!("a.exr: {expected} is no layer; name one"));
        let many = format!("first {}last", "many words ".repeat(10_000));
        let line = bounded(&many);
        assert_eq!(line.chars().count(), LONGEST_LINE);
        assert!(line.starts_with("first many") && line.ends_with("words last"));
        let names = vec!["n".repeat(500); 1000];
        // Nine names of 120 characters, and commas, are more than 1000.
        assert!(listed(&names).ends_with(" and 991 more"));
        assert_eq!(listed(&["a", "b"]), "a, b");
    }

    #[cfg(feature = "cli")]
    #[test]
    fn shells_are_offered_plain_words_and_given_quoted_ones() {
        for word in ["ViewLayer.Normal", "Übung_1-2:a/b+c@d,e=f"] {
            assert_eq!(Untrusted(word).shell_word(), Some(word));
        }
        for other in [
            "", "-o", "$(x)", "`x`", "a b", "a;b", "a\nb", "~", "{a}", "*", "'", "\\", "#",
        ] {
            assert_eq!(Untrusted(other).shell_word(), None, "{other:?}");
        }
        assert_eq!(Untrusted("a b").word(), "\"a b\"");
        assert_eq!(Untrusted("a.b").word(), "a.b");
        assert_eq!(Untrusted("$(x)'`y`").quoted(), r"'$(x)'\''`y`'");
    }

    #[cfg(feature = "cli")]
    #[test]
    fn html_is_given_text() {
        assert_eq!(Untrusted("my_shot (2).exr").html(), "my_shot (2).exr");
        assert_eq!(
            Untrusted("<b>&`|\n").html(),
            "&#60;b&#62;&#38;&#96;&#124;&#92;u000a"
        );
    }

    #[cfg(feature = "cli")]
    #[test]
    fn a_component_of_a_path_leads_nowhere_else() {
        assert_eq!(Untrusted("...").path_component(), Some("..."));
        for other in ["", ".", "..", "a/b"] {
            assert_eq!(Untrusted(other).path_component(), None, "{other:?}");
        }
    }
}
