//! Foreign text made fit to print: a broken file must not break the terminal that tells of it.

/// Characters of a cell or column name that a message repeats, counted as shown: an escape is several.
const MAX_QUOTED: usize = 40;

/// A cell or column name as messages show it: control characters escaped, long text cut.
pub(crate) fn quoted(text: &str) -> String {
    let mut shown = String::new();
    let mut length = 0;
    for character in text.chars() {
        let piece = printable([character].into_iter());
        length += piece.chars().count();
        if length > MAX_QUOTED {
            shown.push('…');
            break;
        }
        shown += &piece;
    }
    shown
}

/// A file name as messages show it: control characters escaped, never cut.
pub(crate) fn file_name(name: &str) -> String {
    if name.trim().is_empty() { "(no name)".to_string() } else { printable(name.chars()) }
}

/// Several names in a row, cut after the first dozen.
pub(crate) fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const MAX_LISTED: usize = 12;
    let names: Vec<&str> = names.into_iter().collect();
    let mut shown: Vec<String> = names.iter().take(MAX_LISTED).map(|name| quoted(name)).collect();
    if names.len() > MAX_LISTED {
        shown.push(format!("and {} more", names.len() - MAX_LISTED));
    }
    shown.join(", ")
}

fn printable(characters: impl Iterator<Item = char>) -> String {
    let mut shown = String::new();
    for character in characters {
        // Line and paragraph separators and the marks that turn the writing direction are no control characters to Unicode.
        let hidden = matches!(character, '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}');
        if character.is_control() || hidden {
            shown.extend(character.escape_default());
        } else {
            shown.push(character);
        }
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terminal_codes_are_escaped_and_long_text_is_cut() {
        assert_eq!(quoted("\u{1b}[31mred\t"), "\\u{1b}[31mred\\t");
        assert_eq!(quoted("a\u{202e}b"), "a\\u{202e}b");
        assert_eq!(quoted(&"x".repeat(41)), format!("{}…", "x".repeat(40)));
        assert_eq!(quoted("größe"), "größe");
        // Found by fuzzing: forty control characters are two hundred to read.
        assert_eq!(quoted(&"\u{f}".repeat(40)), format!("{}…", "\\u{f}".repeat(8)));
    }
}
