//! The header of an NPY file: a Python dictionary with the item type, the order and the shape.

use super::ItemType;

/// The content of a header such as `{'descr': '<i8', 'fortran_order': False, 'shape': (5, 2), }`.
pub(super) struct Description {
    /// The item type, as it is written.
    pub(super) descr: String,
    /// The fields of a record, or `None` for a plain item type.
    pub(super) fields: Option<Vec<Field>>,
    pub(super) fortran_order: bool,
    pub(super) shape: Vec<usize>,
}

/// A field of a record of a structured array.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(in crate::files) struct Field {
    pub(in crate::files) name: String,
    /// The type of its items, or `None` if they are neither floats nor integers nor booleans.
    pub(in crate::files) item: Option<ItemType>,
    /// The number of items.
    pub(in crate::files) items: usize,
    /// The first byte within a record.
    pub(in crate::files) offset: usize,
    /// The number of bytes of all items.
    pub(in crate::files) bytes: usize,
}

impl Description {
    pub(super) fn parse(text: &str) -> Option<Self> {
        let value = value_of(text, "descr")?;
        let (descr, fields) = if value.starts_with('[') {
            let mut parser = Parser { rest: value };
            let fields = parser.fields()?;
            (value[..value.len() - parser.rest.len()].to_owned(), Some(fields))
        } else {
            (Parser { rest: value }.string()?, None)
        };
        let order = value_of(text, "fortran_order")?;
        let fortran_order = order.starts_with("True");
        if !fortran_order && !order.starts_with("False") {
            return None;
        }
        let shape = Parser { rest: value_of(text, "shape")? }.shape()?;
        Some(Self { descr, fields, fortran_order, shape })
    }
}

/// Returns the text after the colon of a quoted key.
fn value_of<'t>(text: &'t str, key: &str) -> Option<&'t str> {
    ['\'', '"'].iter().find_map(|quote| {
        let quoted = format!("{quote}{key}{quote}");
        // A field of a record may have the name of a key, but no colon follows it.
        text.match_indices(&quoted).find_map(|(at, _)| {
            let after = text[at + quoted.len()..].trim_start();
            Some(after.strip_prefix(':')?.trim_start())
        })
    })
}

/// Reads the Python literals of a header.
struct Parser<'t> {
    rest: &'t str,
}

impl Parser<'_> {
    /// Consumes a character, and the spaces before it, if it is next.
    fn take(&mut self, character: char) -> Option<()> {
        self.rest = self.rest.trim_start().strip_prefix(character)?;
        Some(())
    }

    fn string(&mut self) -> Option<String> {
        let text = self.rest.trim_start();
        let quote = text.chars().next().filter(|c| matches!(c, '\'' | '"'))?;
        let mut value = String::new();
        let mut characters = text[1..].char_indices();
        while let Some((at, c)) = characters.next() {
            if c == quote {
                self.rest = &text[1 + at + 1..];
                return Some(value);
            }
            value.push(if c == '\\' { characters.next()?.1 } else { c });
        }
        None
    }

    /// `(5, 2)`, `(5,)` or `()`.
    fn shape(&mut self) -> Option<Vec<usize>> {
        self.take('(')?;
        let (inside, rest) = self.rest.split_once(')')?;
        self.rest = rest;
        // The final comma of Python distinguishes (5,) from a number.
        let inside = inside.trim();
        let inside = inside.strip_suffix(',').unwrap_or(inside);
        match inside {
            "" => Some(Vec::new()),
            _ => inside.split(',').map(|n| n.trim().parse().ok()).collect(),
        }
    }

    /// `[('ra', '<f8'), ('pos', '<f4', (3,))]`; a name may be `('title', 'name')`.
    fn fields(&mut self) -> Option<Vec<Field>> {
        self.take('[')?;
        let mut fields = Vec::new();
        let mut offset = 0_usize;
        while self.take(']').is_none() {
            self.take('(')?;
            let name = if self.take('(').is_some() {
                self.string()?;
                self.take(',')?;
                let name = self.string()?;
                self.take(')')?;
                name
            } else {
                self.string()?
            };
            self.take(',')?;
            let descr = self.string()?;
            let shape = match self.take(',') {
                Some(()) if self.rest.trim_start().starts_with('(') => self.shape()?,
                _ => Vec::new(),
            };
            let _ = self.take(',');
            self.take(')')?;
            let _ = self.take(',');
            let items = shape.iter().try_fold(1_usize, |items, &n| items.checked_mul(n))?;
            let bytes = size_of_descr(&descr)?.checked_mul(items)?;
            fields.push(Field { name, item: item_of_descr(&descr), items, offset, bytes });
            offset = offset.checked_add(bytes)?;
        }
        Some(fields)
    }
}

fn item_of_descr(descr: &str) -> Option<ItemType> {
    // A boolean is a byte that is 0 or 1.
    ItemType::of_descr(if descr == "|b1" { "|u1" } else { descr })
}

/// Returns the number of bytes of an item of any type of fixed size.
fn size_of_descr(descr: &str) -> Option<usize> {
    let kind = descr.strip_prefix(['<', '>', '|', '='])?;
    let letter = kind.chars().next().filter(char::is_ascii)?;
    // The unit of a time follows the size, as in M8[ns].
    let digits = kind[1..].split('[').next()?;
    let size: usize = digits.parse().ok()?;
    match letter {
        'b' | 'i' | 'u' | 'f' | 'c' | 'S' | 'a' | 'V' | 'm' | 'M' => Some(size),
        // Characters of 4 bytes.
        'U' => size.checked_mul(4),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::Description;

    #[test]
    fn records_have_their_offsets() {
        let text = "{'descr': [('shape', '<f8'), (('a title', 'dec'), '>f4'), ('', '|V4'), \
                    ('pos', '<i2', (3,)), ('name', '<U5'), ('ok', '|b1'), ('t', '<M8[ns]'), ], \
                    'fortran_order': False, 'shape': (7,), }";
        let description = Description::parse(text).unwrap();
        let fields: Vec<_> = description
            .fields
            .unwrap()
            .into_iter()
            .map(|f| (f.name, f.item.is_some(), f.items, f.offset, f.bytes))
            .collect();
        let expected = [
            ("shape", true, 1, 0, 8),
            ("dec", true, 1, 8, 4),
            ("", false, 1, 12, 4),
            ("pos", true, 3, 16, 6),
            ("name", false, 1, 22, 20),
            ("ok", true, 1, 42, 1),
            ("t", false, 1, 43, 8),
        ]
        .map(|(name, is_number, items, offset, bytes)| {
            (name.to_owned(), is_number, items, offset, bytes)
        });
        assert_eq!(fields, expected);
        assert_eq!(description.shape, [7]);
        for wrong in [
            "{'descr': [('a', '|O')], 'fortran_order': False, 'shape': (7,), }",
            "{'descr': [('a', [('b', '<f8')])], 'fortran_order': False, 'shape': (7,), }",
            "{'descr': [('a', '<f8', (99999999999, 99999999999))], 'fortran_order': False, \
             'shape': (7,), }",
            "{'descr': [('a', '<f8'",
            "{'descr': [",
        ] {
            assert!(Description::parse(wrong).is_none(), "{wrong}");
        }
    }
}
