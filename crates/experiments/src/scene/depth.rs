//! The nesting depth of a text, found before anything is parsed.

use std::ops::Range;

/// The place where brackets, braces and dots in keys are first nested deeper than `limit`.
pub(super) fn beyond(text: &str, limit: usize) -> Option<Range<usize>> {
    // For each open bracket, the number of dots in the key before it.
    let (mut open, mut depth, mut dots) = (Vec::new(), 0_usize, 0);
    let mut at = 0;
    while let Some(&byte) = text.as_bytes().get(at) {
        let rest = text.get(at..).unwrap_or_default();
        let length = match byte {
            b'#' => rest.find('\n').unwrap_or(rest.len()),
            b'"' | b'\'' => quoted(rest),
            _ => 1,
        };
        match byte {
            b'[' | b'{' => {
                open.push(dots);
                (depth, dots) = (depth + 1, 0);
            }
            b']' | b'}' => {
                let before = open.pop();
                depth = depth.saturating_sub(dots + usize::from(before.is_some()));
                dots = before.unwrap_or(0);
            }
            b'.' => (depth, dots) = (depth + 1, dots + 1),
            b',' | b'\n' => (depth, dots) = (depth - dots, 0),
            _ => {}
        }
        if depth > limit {
            return Some(at..at + 1);
        }
        at += length;
    }
    None
}

/// The length of the quoted text that begins here, or of its line if the quotation does not end.
fn quoted(text: &str) -> usize {
    let long = ["\"\"\"", "'''"].into_iter().find(|mark| text.starts_with(mark));
    let mark = long.unwrap_or(text.get(..1).unwrap_or_default());
    let (mut at, mut escaped) = (mark.len(), false);
    while let Some(rest) = text.get(at..).filter(|rest| !rest.is_empty()) {
        if !escaped && rest.starts_with(mark) {
            // Up to two more quotation marks may precede the closing three.
            let more =
                rest.bytes().take_while(|&byte| mark.as_bytes().first() == Some(&byte)).count();
            return at + if long.is_some() { more.min(5) } else { 1 };
        }
        if long.is_none() && rest.starts_with('\n') {
            return at;
        }
        escaped = !escaped && mark.starts_with('"') && rest.starts_with('\\');
        at += rest.chars().next().map_or(1, char::len_utf8);
    }
    text.len()
}

#[cfg(test)]
mod tests {
    use super::beyond;

    #[test]
    fn brackets_braces_and_dots_of_keys_count() {
        for text in [
            "[[[[",
            "a.b.c.d = 1",
            "[a.b.c.d]",
            "a.b = { c.d = 1 }",
            "x = [{ a = [[1]] }]",
            "\"a\" . 'b'.c.d",
        ] {
            assert!(beyond(text, 2).is_some(), "{text}");
        }
    }

    #[test]
    fn what_is_quoted_or_remarked_does_not() {
        for text in [
            "# ......... [[[[[[",
            "a = \"[[[[ .....\" # '\n b = '......'",
            "a = \"\\\" ......\"",
            "a = '\\' # ......",
            "a = \"\"\"\n....\n\\\"\"\" ....\n\"\"....\"\"\" # ......\nb = 1",
            "a = '''...\\'''\nb = '.....'''''",
            "a = [0.5, 0.5, 0.5, 0.5]\nb = 0.5\nc = 0.5\nd = 0.5",
            "a = [[1.5]]",
            "a = { b = 1.5, c = 2.5 }\nd = { e = 3.5, f = 4.5 }",
        ] {
            assert_eq!(beyond(text, 3), None, "{text}");
        }
    }
}
