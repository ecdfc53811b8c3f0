//! Runs in parts, as tests of several commands compare them with one run.

use crate::workplace::Workplace;

/// A run that was made at once, with its results in every form.
pub(crate) struct WholeRun<'p> {
    place: &'p Workplace,
    /// The command, with a picture among its results.
    command: String,
    document: String,
    picture: Vec<u8>,
    rows: Vec<String>,
}

impl<'p> WholeRun<'p> {
    /// Runs a command that has a document, a picture and a table.
    pub(crate) fn new(place: &'p Workplace, command: &str) -> Self {
        place.run(&format!("{command} -o rows.csv --quiet")).ok();
        let rows = rows(place);
        let command = format!("{command} -o picture.svg");
        let document = place.run(&format!("{command} --json --quiet")).ok().stdout;
        Self { place, command, document, picture: place.bytes("picture.svg"), rows }
    }

    /// Runs one part, with one or two threads, and returns the name of its file.
    pub(crate) fn part(&self, part: u64, parts: u64) -> String {
        let (name, threads) = (format!("{part}-of-{parts}.shard"), 1 + part % 2);
        // Results of another command are not replaced.
        let _ = std::fs::remove_file(self.place.path(&name));
        let flags = format!("--shard {part}/{parts} --save {name} -j {threads} --quiet");
        let outcome = self.place.run(&format!("{} {flags}", self.command)).ok();
        let only = if parts == 1 { &outcome.stderr } else { &outcome.stdout };
        assert_eq!(only, "", "{}: {part}/{parts}", self.command);
        name
    }

    /// Runs all parts, from the last to the first in steps of 5, and asserts that they are merged to
    /// the bytes of the whole.
    pub(crate) fn check(&self, parts: u64) {
        assert!(!parts.is_multiple_of(5) || parts == 1, "steps of 5 must reach all parts");
        let part = |k: u64| self.part(parts - 5 * k % parts, parts);
        let files: Vec<String> = (0..parts).map(part).collect();
        self.check_merged(&files);
    }

    /// Asserts that files are merged to the bytes of the whole.
    pub(crate) fn check_merged(&self, files: &[String]) {
        std::fs::remove_file(self.place.path("picture.svg")).unwrap_or_default();
        let files = files.join(" ");
        let document = self.place.run(&format!("merge {files} --json --quiet")).ok().stdout;
        assert_eq!(document, self.document, "{}", self.command);
        assert!(self.place.bytes("picture.svg") == self.picture, "{}", self.command);
        self.place.run(&format!("merge {files} -o rows.csv --quiet")).ok();
        assert_eq!(rows(self.place), self.rows, "{}", self.command);
    }
}

/// Returns the table without its first line, which has the command.
fn rows(place: &Workplace) -> Vec<String> {
    place.text("rows.csv").lines().skip(1).map(str::to_owned).collect()
}
