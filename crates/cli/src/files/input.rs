//! Opens files for reading, with or without gzip compression.

use std::fs::File;
use std::io::{self, BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::path::Path;

use flate2::bufread::GzDecoder;

use super::file_error::{FileError, input_name, is_dash};
use super::memory_guard::MemoryGuard;
use super::used_files::record_input;

/// The number of bytes that are read from a file at a time.
const BUFFER: usize = 1 << 16;
/// The number of bytes that readers may inspect to detect the format of a file.
const HEAD: usize = 64;
/// The first bytes of a gzip file (RFC 1952).
const GZIP: [u8; 2] = [0x1f, 0x8b];

/// The content of a file, decompressed.
pub(super) struct Input(Kind);

enum Kind {
    /// A regular file that is not compressed.
    Regular(BufReader<File>),
    Stream(Box<dyn BufRead>),
}

impl Input {
    /// Returns whether this is a regular file that is not compressed.
    pub(super) fn is_regular(&self) -> bool {
        matches!(self.0, Kind::Regular(_))
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match &mut self.0 {
            Kind::Regular(file) => file.read(buffer),
            Kind::Stream(stream) => stream.read(buffer),
        }
    }
}

impl BufRead for Input {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        match &mut self.0 {
            Kind::Regular(file) => file.fill_buf(),
            Kind::Stream(stream) => stream.fill_buf(),
        }
    }

    fn consume(&mut self, amount: usize) {
        match &mut self.0 {
            Kind::Regular(file) => file.consume(amount),
            Kind::Stream(stream) => stream.consume(amount),
        }
    }
}

/// An input of which parts can be skipped.
pub(super) trait SkipBytes: Read + Sized {
    /// Skips this number of bytes, possibly beyond the end.
    ///
    /// # Errors
    ///
    /// If reading fails.
    fn skip_bytes(&mut self, bytes: u64) -> io::Result<()> {
        io::copy(&mut self.by_ref().take(bytes), &mut io::sink()).map(drop)
    }

    /// Moves to this position and returns true, if the input has positions.
    ///
    /// # Errors
    ///
    /// If the position is invalid.
    fn jump_to(&mut self, _position: u64) -> io::Result<bool> {
        Ok(false)
    }
}

impl SkipBytes for Input {
    fn skip_bytes(&mut self, bytes: u64) -> io::Result<()> {
        match &mut self.0 {
            Kind::Regular(file) => {
                let bytes = i64::try_from(bytes).map_err(io::Error::other)?;
                file.seek_relative(bytes)
            }
            Kind::Stream(stream) => {
                io::copy(&mut stream.by_ref().take(bytes), &mut io::sink()).map(drop)
            }
        }
    }

    fn jump_to(&mut self, position: u64) -> io::Result<bool> {
        match &mut self.0 {
            Kind::Regular(file) => file.seek(SeekFrom::Start(position)).map(|_| true),
            Kind::Stream(_) => Ok(false),
        }
    }
}

/// Returns the content of a file; the path `-` is standard input.
///
/// A file that starts with the magic bytes of gzip is decompressed while it is read, including all
/// its members, whatever its name. At least 64 bytes are in the buffer, unless the file is shorter.
///
/// # Errors
///
/// If the file does not exist, is not readable, or is a folder.
pub(super) fn open_input(path: &Path) -> Result<Input, FileError> {
    let read_error = |source| FileError::Read { path: input_name(path), source };
    let raw: Box<dyn BufRead> = if is_dash(path) {
        Box::new(io::stdin().lock())
    } else {
        let open_error = |source| FileError::Open { path: input_name(path), source };
        let file = File::open(path).map_err(open_error)?;
        let kind = file.metadata().map_err(open_error)?.file_type();
        // A folder can be opened, but the error of the first read would not state the cause.
        if kind.is_dir() {
            return Err(open_error(io::Error::from(io::ErrorKind::IsADirectory)));
        }
        record_input(path);
        let mut file = BufReader::with_capacity(BUFFER, file);
        if kind.is_file() && !file.fill_buf().map_err(read_error)?.starts_with(&GZIP) {
            return Ok(Input(Kind::Regular(file)));
        }
        Box::new(file)
    };
    decompressed(raw).map(|content| Input(Kind::Stream(content))).map_err(read_error)
}

/// Returns all bytes of a file, decompressed as by [`open_input`].
///
/// # Errors
///
/// As [`open_input`], or if reading fails or the content does not fit in memory.
pub(crate) fn read_whole(path: &Path) -> Result<Vec<u8>, FileError> {
    read_rest(open_input(path)?, &input_name(path))
}

/// Returns the rest of an input, limited by the available memory.
///
/// # Errors
///
/// If reading fails or the content does not fit in memory.
pub(super) fn read_rest(mut input: impl BufRead, name: &str) -> Result<Vec<u8>, FileError> {
    let mut bytes = Vec::new();
    let mut guard = MemoryGuard::default();
    loop {
        let chunk = match input.fill_buf() {
            Ok(chunk) => chunk,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(source) => return Err(FileError::Read { path: name.to_owned(), source }),
        };
        if chunk.is_empty() {
            return Ok(bytes);
        }
        bytes.extend_from_slice(chunk);
        let taken = chunk.len();
        input.consume(taken);
        guard.check(name, "the content of the file", bytes.len() as u64)?;
    }
}

/// Returns the content of an input that may be gzip-compressed, with its first bytes in the buffer.
fn decompressed(raw: Box<dyn BufRead>) -> io::Result<Box<dyn BufRead>> {
    let raw = with_head(raw)?;
    let Some(raw) = raw else {
        return Ok(Box::new(io::empty()));
    };
    if !raw.head.starts_with(&GZIP) {
        return Ok(raw.into_reader());
    }
    let decoder = Some(GzDecoder::new(raw.into_reader()));
    let gunzip = Gunzip { decoder, decompressed: 0, guard: MemoryGuard::default() };
    let content = with_head(Box::new(BufReader::with_capacity(BUFFER, gunzip)))?;
    Ok(content.map_or_else(|| Box::new(io::empty()) as Box<dyn BufRead>, WithHead::into_reader))
}

/// An input whose first bytes have been read.
struct WithHead {
    head: Vec<u8>,
    rest: Box<dyn BufRead>,
}

impl WithHead {
    fn into_reader(self) -> Box<dyn BufRead> {
        Box::new(Cursor::new(self.head).chain(self.rest))
    }
}

/// Reads the first bytes of an input, or returns `None` if it is empty.
///
/// A pipe may deliver its bytes one at a time.
fn with_head(mut rest: Box<dyn BufRead>) -> io::Result<Option<WithHead>> {
    let mut head = Vec::new();
    rest.by_ref().take(HEAD as u64).read_to_end(&mut head)?;
    Ok((!head.is_empty()).then_some(WithHead { head, rest }))
}

/// A decoder of all members of a gzip file, whose errors state that the file is damaged.
///
/// Zeros after the last member are padding to tape blocks, as in the program `gzip`. Readers
/// interpret `UnexpectedEof` as a truncated array and `InvalidData` as text in another encoding.
struct Gunzip<R> {
    /// `None` at the end of the file.
    decoder: Option<GzDecoder<R>>,
    decompressed: u64,
    guard: MemoryGuard,
}

impl<R: BufRead> Gunzip<R> {
    /// Returns the decoder of the next member, if there is one.
    fn next_member(mut input: R) -> io::Result<Option<GzDecoder<R>>> {
        let mut is_padded = false;
        loop {
            let chunk = input.fill_buf()?;
            let Some(&first) = chunk.first() else { return Ok(None) };
            let zeros = chunk.iter().take_while(|&&byte| byte == 0).count();
            if zeros == 0 {
                let is_member = first == GZIP[0] && !is_padded;
                return if is_member {
                    Ok(Some(GzDecoder::new(input)))
                } else {
                    Err(io::Error::other("other bytes follow the gzip data"))
                };
            }
            is_padded = true;
            input.consume(zeros);
        }
    }
}

impl<R: BufRead> Read for Gunzip<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        while let Some(decoder) = &mut self.decoder {
            let read = decoder.read(buffer).map_err(|error| match error.kind() {
                io::ErrorKind::UnexpectedEof => io::Error::other("the gzip data are truncated"),
                io::ErrorKind::InvalidInput | io::ErrorKind::InvalidData => {
                    io::Error::other(format!("the gzip data are damaged ({error})"))
                }
                _ => error,
            })?;
            if read > 0 {
                self.decompressed += read as u64;
                self.guard.check_decompressed(self.decompressed)?;
                return Ok(read);
            }
            let ended = self.decoder.take().map(GzDecoder::into_inner);
            self.decoder = ended.map(Self::next_member).transpose()?.flatten();
        }
        Ok(0)
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::io::{Read, Write};
    use std::path::PathBuf;

    use flate2::Compression;
    use flate2::write::GzEncoder;
    use tempfile::TempDir;

    use super::{open_input, read_whole};

    fn gzip(content: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(content).unwrap();
        encoder.finish().unwrap()
    }

    fn file(content: &[u8]) -> (TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("any name");
        fs::write(&path, content).unwrap();
        (folder, path)
    }

    /// More than the buffers hold, and not all equal.
    fn long() -> Vec<u8> {
        (0..300_000_u32).map(|k| k.wrapping_mul(2_654_435_761).to_le_bytes()[3]).collect()
    }

    #[test]
    fn content_is_the_same_with_and_without_compression() {
        for content in [&b""[..], b"\x1f", b"1", b"short text", &long()] {
            let (_folder, path) = file(content);
            assert_eq!(read_whole(&path).unwrap(), content);
            let (_folder, path) = file(&gzip(content));
            assert_eq!(read_whole(&path).unwrap(), content);
            let mut streamed = Vec::new();
            open_input(&path).unwrap().read_to_end(&mut streamed).unwrap();
            assert_eq!(streamed, content);
            // `cat a.gz b.gz` is the gzip file of both.
            let (_folder, path) = file(&[gzip(content), gzip(b"tail")].concat());
            assert_eq!(read_whole(&path).unwrap(), [content, b"tail"].concat());
            // Padded to tape blocks.
            let (_folder, path) = file(&[gzip(content), vec![0; 100_000]].concat());
            assert_eq!(read_whole(&path).unwrap(), content);
        }
        for tail in [&b"text"[..], b"\x1e", b"\0\0text", b"longer than a header"] {
            let (_folder, path) = file(&[&gzip(b"1 0 0"), tail].concat());
            let message = read_whole(&path).unwrap_err().to_string();
            assert!(message.contains("other bytes follow the gzip data"), "{message}");
        }
    }

    #[test]
    fn every_cut_of_a_gzip_file_is_an_error() {
        let whole = gzip(b"1 0 0\n0 1 0\n0 0 1\n");
        for length in 2..whole.len() {
            let (_folder, path) = file(&whole[..length]);
            let message = read_whole(&path).unwrap_err().to_string();
            assert!(message.contains("truncated"), "{length}: {message}");
        }
        let mut damaged = gzip(&long());
        let middle = damaged.len() / 2;
        damaged[middle..middle + 64].fill(0xa5);
        let (_folder, path) = file(&damaged);
        let message = read_whole(&path).unwrap_err().to_string();
        assert!(message.contains("damaged"), "{message}");
    }

    #[test]
    fn the_head_is_in_the_buffer() {
        let (_folder, path) = file(&gzip(&long()));
        let mut input = open_input(&path).unwrap();
        assert!(std::io::BufRead::fill_buf(&mut input).unwrap().len() >= 64);
    }
}
