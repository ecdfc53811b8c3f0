use std::borrow::Cow;

/// The UTF-8 byte order mark.
const MARK: &[u8] = b"\xef\xbb\xbf";

/// Returns the statements of an OBJ text without comments, each with the 1-based number of its
/// first line.
///
/// Lines end in LF, CR LF or CR. A line without a comment that ends in `\` continues in the next
/// one.
pub(crate) fn lines(text: &[u8]) -> impl Iterator<Item = (usize, Cow<'_, [u8]>)> {
    let mut rest = Some(text.strip_prefix(MARK).unwrap_or(text));
    let mut number = 0;
    std::iter::from_fn(move || {
        let mut statement: Cow<'_, [u8]> = Cow::Borrowed(&[]);
        let mut first = None;
        loop {
            let Some(text) = rest.filter(|text| !text.is_empty() || first.is_some()) else {
                rest = None;
                return first.map(|first| (first, std::mem::take(&mut statement)));
            };
            let (line, after) = split_line(text);
            rest = after;
            number += 1;
            let first = *first.get_or_insert(number);
            let content = line.split(|&b| b == b'#').next().unwrap_or_default();
            let continued = line.trim_ascii_end().strip_suffix(b"\\");
            let part = match continued {
                Some(part) if content.len() == line.len() => part,
                _ => content,
            };
            if statement.is_empty() {
                statement = Cow::Borrowed(part);
            } else {
                statement.to_mut().push(b' ');
                statement.to_mut().extend(part);
            }
            if content.len() < line.len() || continued.is_none() {
                return Some((first, statement));
            }
        }
    })
}

/// Returns the first line without its end, and the remaining text; `None` if there is none.
fn split_line(text: &[u8]) -> (&[u8], Option<&[u8]>) {
    match text.iter().position(|&b| b == b'\n' || b == b'\r') {
        None => (text, None),
        Some(end) => {
            let width = if text[end..].starts_with(b"\r\n") { 2 } else { 1 };
            (&text[..end], Some(&text[end + width..]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::lines;

    fn read(text: &[u8]) -> Vec<(usize, String)> {
        lines(text).map(|(i, line)| (i, String::from_utf8_lossy(&line).into_owned())).collect()
    }

    #[test]
    fn ends_comments_and_continuations() {
        let text = b"\xef\xbb\xbfa b\r\nc \\\nd\\\r\ne\rg # h \\\ni\\";
        let expected = [(1, "a b"), (2, "c  d e"), (5, "g "), (6, "i")];
        assert_eq!(read(text), expected.map(|(i, s)| (i, s.to_owned())));
        assert_eq!(read(b""), []);
        assert_eq!(read(b"\n\n"), [(1, String::new()), (2, String::new())]);
        assert_eq!(read(b"\\\n\\\n"), [(1, String::new())]);
        assert_eq!(read(b"# C:\\models\\\nv"), [(1, String::new()), (2, "v".to_owned())]);
    }
}
