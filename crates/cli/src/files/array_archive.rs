//! Archives of arrays, `.npz`.

use std::io::{self, Cursor, Write};

use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

/// Archives from this size on need 64-bit lengths.
const MAX_SMALL_ENTRY: u64 = 0xffff_ffff;

/// Arrays that become an `.npz` file, uncompressed.
pub(super) struct ArrayArchive {
    archive: ZipWriter<Cursor<Vec<u8>>>,
    options: SimpleFileOptions,
}

impl ArrayArchive {
    /// Returns an archive of arrays with at most `numbers` numbers of 8 bytes each.
    pub(super) fn new(numbers: u64) -> Self {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(8 * numbers + 1024 >= MAX_SMALL_ENTRY);
        Self { archive: ZipWriter::new(Cursor::new(Vec::new())), options }
    }

    /// Starts the array of a name, which the caller writes.
    pub(super) fn start(&mut self, name: &str) -> io::Result<&mut impl Write> {
        self.archive.start_file(format!("{name}.npy"), self.options)?;
        Ok(&mut self.archive)
    }

    /// Writes the complete archive.
    pub(super) fn write(self, out: &mut impl Write) -> io::Result<()> {
        out.write_all(&self.archive.finish()?.into_inner())
    }
}
