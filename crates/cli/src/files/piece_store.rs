//! Finished pieces of a long run, each in a separate file.

use std::fs;
use std::path::{Path, PathBuf};

use sphvar_thesis::Store;

use super::{FileError, read_regular, write_regular};

/// A folder of pieces. A file is `checksum (4 bytes, little-endian CRC-32), length of the key (4
/// bytes), key, piece`; a file that is damaged or has another key counts as missing.
#[derive(Debug)]
pub(crate) struct PieceStore {
    folder: PathBuf,
}

impl PieceStore {
    /// Opens the store in `folder`, which is created if it is missing.
    ///
    /// # Errors
    ///
    /// If it cannot be created.
    pub(crate) fn open(folder: &Path) -> Result<Self, FileError> {
        fs::create_dir_all(folder)
            .map_err(|source| FileError::Write { path: folder.display().to_string(), source })?;
        Ok(Self { folder: folder.to_owned() })
    }

    /// Returns the path of a key. Names contain the key, for inspection by people; a checksum
    /// distinguishes keys that differ only in characters that file names cannot contain.
    fn path(&self, key: &str) -> PathBuf {
        let plain = |c: char| if c.is_ascii_alphanumeric() || ".=".contains(c) { c } else { '-' };
        // File systems allow 255 bytes, some of which a temporary name adds.
        let name: String = key.chars().map(plain).take(180).collect();
        self.folder.join(format!("{name}.{:08x}.piece", crc32fast::hash(key.as_bytes())))
    }
}

impl Store for PieceStore {
    fn load(&self, key: &str) -> Option<Vec<u8>> {
        let mut bytes = read_regular(&self.path(key)).ok()?;
        let (checksum, rest) = bytes.split_at_checked(4)?;
        if crc32fast::hash(rest).to_le_bytes() != checksum {
            return None;
        }
        let (length, rest) = rest.split_at_checked(4)?;
        let length = u32::from_le_bytes(length.try_into().ok()?) as usize;
        (rest.get(..length)? == key.as_bytes()).then(|| bytes.split_off(8 + length))
    }

    fn save(&self, key: &str, bytes: &[u8]) -> Result<(), String> {
        let length = u32::try_from(key.len()).map_err(|error| error.to_string())?;
        let body = [&length.to_le_bytes(), key.as_bytes(), bytes].concat();
        let checksum = crc32fast::hash(&body).to_le_bytes();
        write_regular(&self.path(key), &[&checksum[..], &body].concat())
            .map_err(|error| error.to_string())
    }
}

#[cfg(test)]
mod tests {
    use super::{PieceStore, Store, fs};

    #[test]
    fn pieces_come_back_and_damaged_ones_do_not() {
        let folder = tempfile::tempdir().unwrap();
        let store = PieceStore::open(&folder.path().join("a/b")).unwrap();
        let keys = ["spectrum n=4 sets=0..3", "spectrum n=4 sets=0/.3", "", &"long ".repeat(100)];
        for (i, key) in (0_u8..).zip(keys) {
            assert_eq!(store.load(key), None);
            store.save(key, &[i, 1, 2]).unwrap();
        }
        for (i, key) in (0_u8..).zip(keys) {
            assert_eq!(store.load(key).unwrap(), [i, 1, 2], "{key}");
        }
        let path = store.path(keys[0]);
        let whole = fs::read(&path).unwrap();
        for cut in 0..whole.len() {
            fs::write(&path, &whole[..cut]).unwrap();
            assert_eq!(store.load(keys[0]), None, "cut at {cut}");
            let mut flipped = whole.clone();
            flipped[cut] ^= 4;
            fs::write(&path, flipped).unwrap();
            assert_eq!(store.load(keys[0]), None, "flipped at {cut}");
        }
        fs::copy(store.path(keys[1]), &path).unwrap();
        assert_eq!(store.load(keys[0]), None, "another key's");
    }
}
