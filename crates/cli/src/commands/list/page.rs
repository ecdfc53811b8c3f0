//! Names with descriptions, wrapped to the width of a terminal.

/// The minimum width of a terminal.
const WIDTH: usize = 80;
/// The indentation of the details of an entry.
const INDENT: usize = 4;
/// The width of the column of detail names, with the gap.
const LABELS: usize = 18;
/// The width of the column of names in overviews, with the gap.
const NAMES: usize = 18;

/// A space at which lines are not wrapped; it is printed as an ordinary one.
pub(super) const UNBREAKABLE: &str = "\u{a0}";

/// A text with lines of at most 80 columns.
#[derive(Default)]
pub(super) struct Page {
    text: String,
}

impl Page {
    pub(super) fn text(&self) -> &str {
        &self.text
    }

    /// Adds a heading, after an empty line unless it is the first.
    pub(super) fn heading(&mut self, heading: &str) {
        if !self.text.is_empty() {
            self.text.push('\n');
        }
        self.text.push_str(heading);
        self.text.push('\n');
    }

    /// Adds a name with its description.
    pub(super) fn line(&mut self, name: &str, meaning: &str) {
        self.labelled(2, name, NAMES, meaning);
    }

    /// Adds a detail of the entry above, unless it is empty.
    pub(super) fn detail(&mut self, label: &str, detail: &str) {
        if !detail.is_empty() {
            self.labelled(INDENT, label, LABELS, detail);
        }
    }

    /// Adds a paragraph after an empty line.
    pub(super) fn paragraph(&mut self, text: &str) {
        self.text.push('\n');
        self.labelled(0, "", 0, text);
    }

    fn labelled(&mut self, indent: usize, label: &str, width: usize, text: &str) {
        let start = indent + width;
        let mut line = format!("{:indent$}{label:width$}", "");
        // A long label has a separate line.
        if label.chars().count() >= width && width > 0 {
            self.push_line(&line);
            line = " ".repeat(start);
        }
        let mut is_empty = true;
        for word in text.split(' ').filter(|word| !word.is_empty()) {
            if !is_empty && line.chars().count() + 1 + word.chars().count() > WIDTH {
                self.push_line(&line);
                line = " ".repeat(start);
                is_empty = true;
            }
            if !is_empty {
                line.push(' ');
            }
            line.push_str(&word.replace(UNBREAKABLE, " "));
            is_empty = false;
        }
        self.push_line(&line);
    }

    fn push_line(&mut self, line: &str) {
        self.text.push_str(line.trim_end());
        self.text.push('\n');
    }
}

#[cfg(test)]
mod tests {
    use super::Page;

    #[test]
    fn lines_are_wrapped_below_their_beginning() {
        let mut page = Page::default();
        page.heading("name");
        page.detail("label", &"words ".repeat(20));
        page.detail("a label that is very long", "text");
        page.detail("nothing", "");
        let lines: Vec<&str> = page.text().lines().collect();
        assert_eq!(lines[1], format!("    label             {}", ["words"; 9].join(" ")));
        assert_eq!(lines[2].trim_start(), ["words"; 9].join(" "));
        assert_eq!(lines[2].find("words"), Some(22));
        assert_eq!(lines[4..], ["    a label that is very long", "                      text"]);
        assert!(lines.iter().all(|line| line.len() <= 80));
    }
}
