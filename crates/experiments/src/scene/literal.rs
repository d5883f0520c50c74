//! Quoted text as it is written in a TOML file.

use std::ops::Range;

/// The place of a part of a text between the quotation marks it is written in, in bytes as written.
/// `None` if nothing is quoted.
pub(super) fn part_of(written: &str, part: &Range<usize>) -> Option<Range<usize>> {
    let mark = ["\"\"\"", "'''", "\"", "'"].into_iter().find(|mark| written.starts_with(mark))?;
    let inner = written.get(mark.len()..)?.strip_suffix(mark)?;
    // A line break right after three marks does not belong to the text.
    let body = match mark.len() {
        3 => inner.strip_prefix('\n').or_else(|| inner.strip_prefix("\r\n")).unwrap_or(inner),
        _ => inner,
    };
    let start = mark.len() + inner.len() - body.len();
    if mark.starts_with('\'') {
        return Some(start + part.start..start + part.end);
    }
    let (mut read, mut from, mut to) = (0, None, 0);
    let mut rest = body;
    while let Some((length, meant)) = piece(rest) {
        let at = body.len() - rest.len();
        if read == part.start && meant > 0 {
            from = Some(at);
        }
        read += meant;
        rest = rest.get(length..)?;
        if meant > 0 && read <= part.end {
            to = at + length;
        }
    }
    let from = from.unwrap_or(body.len());
    Some(start + from..start + to.max(from))
}

/// The number of bytes of the first character as written, and of the character it stands for.
fn piece(text: &str) -> Option<(usize, usize)> {
    let first = text.chars().next()?;
    if first != '\\' {
        return Some((first.len_utf8(), first.len_utf8()));
    }
    let behind = text.get(1..)?;
    let digits = match behind.chars().next()? {
        'x' => 2,
        'u' => 4,
        'U' => 8,
        // A backslash at the end of a line removes the line break and the blanks that follow.
        c if c.is_ascii_whitespace() => {
            let blanks = behind.len() - behind.trim_start_matches([' ', '\t', '\r', '\n']).len();
            return Some((1 + blanks, 0));
        }
        c => return Some((1 + c.len_utf8(), 1)),
    };
    let code = u32::from_str_radix(behind.get(1..1 + digits)?, 16).ok()?;
    Some((2 + digits, char::from_u32(code)?.len_utf8()))
}

#[cfg(test)]
mod tests {
    use super::part_of;

    #[test]
    fn a_part_is_found_behind_escapes_and_line_breaks() {
        for (written, part, found) in [
            (r#""c*p1""#, 2..4, "p1"),
            ("'c*p1'", 2..4, "p1"),
            (r#""c\u002ap1 + x""#, 7..8, "x"),
            (r#""c\u002ap1 + x""#, 1..2, r"\u002a"),
            (r#""\U0000002d\x71\t1 + é+x""#, 10..11, "x"),
            ("\"\"\"\nq1 +\n x\"\"\"", 6..7, "x"),
            ("\"\"\"\r\nq1 +\r\n x\"\"\"", 7..8, "x"),
            ("'''\nq1 +\n x'''", 6..7, "x"),
            ("\"\"\"q1 + \\\n   x\"\"\"", 5..6, "x"),
            ("\"\"\"q1 + \\\n   x\"\"\"", 3..6, "+ \\\n   x"),
        ] {
            let range = part_of(written, &part).unwrap();
            assert_eq!(&written[range], found, "{written}");
        }
        assert_eq!(part_of(r#""q1 +""#, &(4..4)), Some(5..5));
        assert_eq!(part_of(r#""""#, &(0..0)), Some(1..1));
        assert_eq!(part_of("1.5", &(0..1)), None);
    }
}
