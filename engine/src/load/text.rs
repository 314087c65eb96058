//! Numbers and names out of files: what programs write for numbers, and what is safe to show of a name.

use std::borrow::Cow;

/// A number as some program writes it: plain; `1.5D+03` (Fortran); `nan`, `-nan(ind)`, `1.#QNAN`, `1.#INF` and their kin.
pub(super) fn number(word: &str) -> Option<f64> {
    if let Ok(number) = word.parse() {
        return Some(number);
    }
    let lower = word.to_ascii_lowercase();
    let bare = lower.trim_start_matches(['+', '-']);
    // `1.#J` is what is left of `1.#IND` when it is written with one digit, rounded.
    let odd = |start: &&str| bare.starts_with(*start);
    if ["inf", "1.#inf", "#inf"].iter().any(odd) {
        return Some(if lower.starts_with('-') { f64::NEG_INFINITY } else { f64::INFINITY });
    }
    if ["nan", "qnan", "snan", "ind", "1.#", "1#", "1.$", "#"].iter().any(odd) {
        return Some(f64::NAN);
    }
    let digits = |c: char| c.is_ascii_digit() || "+-.d".contains(c);
    if lower.matches('d').count() == 1 && lower.chars().all(digits) {
        return lower.replace('d', "e").parse().ok();
    }
    None
}

/// The text with what could change how a terminal shows the rest replaced: control characters, and marks that turn the direction of
/// writing.
pub fn printable(text: &str) -> Cow<'_, str> {
    let unsafe_to_show = |c: char| {
        c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}')
    };
    if text.contains(unsafe_to_show) {
        Cow::Owned(text.chars().map(|c| if unsafe_to_show(c) { '?' } else { c }).collect())
    } else {
        Cow::Borrowed(text)
    }
}

/// So many of something.
pub(super) fn counted(count: u64, one: &str) -> String {
    format!("{count} {one}{}", if count == 1 { "" } else { "s" })
}

/// At most 40 characters of text from a file, made safe to print on one line.
pub(super) fn quoted(text: &str) -> String {
    let mut short: String = text.chars().take(40).collect();
    if text.chars().nth(40).is_some() {
        short.push_str("...");
    }
    format!("'{}'", printable(&short))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_programs_write_for_numbers_is_understood() {
        for (word, expected) in [
            ("0.25", 0.25),
            ("-1e-3", -1e-3),
            ("+.5", 0.5),
            ("5.", 5.0),
            ("1.5D+03", 1500.0),
            ("1d2", 100.0),
            ("inf", f64::INFINITY),
            ("-Infinity", f64::NEG_INFINITY),
            ("1.#INF", f64::INFINITY),
            ("-1.#INF00", f64::NEG_INFINITY),
        ] {
            assert_eq!(number(word), Some(expected), "{word}");
        }
        for word in [
            "nan",
            "NaN",
            "-nan",
            "-nan(ind)",
            "nan(snan)",
            "1.#IND",
            "-1.#IND00",
            "1.#QNAN",
            "1.#SNAN",
            "+NaN",
            "1.#R",
            "-1.#IO",
            "1.$",
            "-1.#J",
            "qnan",
            "-SNaN",
        ] {
            assert!(number(word).is_some_and(f64::is_nan), "{word}");
        }
        for word in ["", "zero", "1,5", "0x10", "d", "dd", "1e", "banana", "1.5.2", "--1"] {
            assert_eq!(number(word), None, "{word}");
        }
    }

    #[test]
    fn what_could_change_a_terminal_is_replaced() {
        assert_eq!(printable("rot \u{e9}"), "rot \u{e9}");
        assert_eq!(printable("a\u{1b}[31mb\u{7}\u{9b}\u{202e}"), "a?[31mb???");
        assert_eq!(quoted(&"x".repeat(50)), format!("'{}...'", "x".repeat(40)));
    }
}
