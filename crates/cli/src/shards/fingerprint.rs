//! Whether a file is the one that was read before.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use serde::{Deserialize, Serialize};

/// The length of a file and a checksum of its content.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Fingerprint {
    bytes: u64,
    checksum: u32,
}

/// Longer files, such as large catalogues, are compared in samples.
const WHOLE: u64 = 256 << 20;
/// The number and the length of these samples.
const SAMPLES: u64 = 64;
const SAMPLE: u64 = 1 << 20;

impl Fingerprint {
    /// Returns the fingerprint of a file.
    ///
    /// # Errors
    ///
    /// If it cannot be read.
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        let mut file = File::open(path)?;
        let bytes = file.metadata()?.len();
        let mut hasher = crc32fast::Hasher::new();
        let (samples, length) = if bytes <= WHOLE { (1, bytes) } else { (SAMPLES, SAMPLE) };
        let mut buffer = vec![0; 1 << 16];
        for i in 0..samples {
            let gaps = (samples - 1).max(1);
            // The last sample ends with the file.
            let start = (bytes - length) / gaps * i + (bytes - length) % gaps * i / gaps;
            file.seek(SeekFrom::Start(start))?;
            let mut part = Read::by_ref(&mut file).take(length);
            loop {
                let read = part.read(&mut buffer)?;
                if read == 0 {
                    break;
                }
                hasher.update(&buffer[..read]);
            }
        }
        Ok(Self { bytes, checksum: hasher.finalize() })
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Seek, SeekFrom, Write};

    use super::{Fingerprint, WHOLE};

    #[test]
    fn other_content_has_another_fingerprint() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a");
        let mut seen = Vec::new();
        for content in ["", "a", "b", "ab", "ba"] {
            std::fs::write(&path, content).unwrap();
            let fingerprint = Fingerprint::of(&path).unwrap();
            assert!(!seen.contains(&fingerprint), "{content:?}");
            assert_eq!(fingerprint, Fingerprint::of(&path).unwrap());
            seen.push(fingerprint);
        }
        // A sparse file takes no space; its last bytes count.
        let mut file = std::fs::File::create(&path).unwrap();
        file.set_len(WHOLE + 10).unwrap();
        let before = Fingerprint::of(&path).unwrap();
        file.seek(SeekFrom::End(-1)).unwrap();
        file.write_all(b"x").unwrap();
        assert_ne!(before, Fingerprint::of(&path).unwrap());
    }
}
