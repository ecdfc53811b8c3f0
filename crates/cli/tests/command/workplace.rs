use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::outcome::Outcome;

/// An empty folder in which the command runs; it is removed at the end.
#[derive(Debug)]
pub(crate) struct Workplace {
    folder: TempDir,
}

impl Workplace {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self, name: impl AsRef<Path>) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Returns the command with these arguments, which are separated by spaces, before it is
    /// started.
    ///
    /// A backtrace is requested, so that a panic would be visible.
    pub(crate) fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_sphvar"));
        command
            .args(arguments.split_whitespace())
            .current_dir(self.folder.path())
            .env("RUST_BACKTRACE", "1")
            .env_remove("RAYON_NUM_THREADS")
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    /// Runs the command to its end.
    pub(crate) fn run(&self, arguments: &str) -> Outcome {
        Outcome::new(arguments, self.command(arguments).output().unwrap())
    }

    /// Runs the command with this text on standard input.
    pub(crate) fn run_on(&self, arguments: &str, input: &str) -> Outcome {
        let mut child = self.command(arguments).stdin(Stdio::piped()).spawn().unwrap();
        // Dropped immediately, which ends the input. All inputs here fit in the pipe.
        child.stdin.take().unwrap().write_all(input.as_bytes()).unwrap();
        Outcome::new(arguments, child.wait_with_output().unwrap())
    }

    pub(crate) fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.path(name), content).unwrap();
    }

    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    pub(crate) fn text(&self, name: &str) -> String {
        String::from_utf8(self.bytes(name)).unwrap()
    }

    /// Returns the sorted names of all files and folders, including hidden ones.
    pub(crate) fn names(&self) -> Vec<String> {
        self.names_in("")
    }

    /// Returns the same for a folder inside this one.
    pub(crate) fn names_in(&self, folder: &str) -> Vec<String> {
        let entries = fs::read_dir(self.path(folder)).unwrap();
        let mut names: Vec<String> =
            entries.map(|e| e.unwrap().file_name().to_string_lossy().into_owned()).collect();
        names.sort();
        names
    }
}

/// Returns the path of a file of the repository's folder `data`.
pub(crate) fn data(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data").join(name);
    path.to_str().unwrap().to_owned()
}

/// Returns a minimal grey OpenEXR image whose texels increase in brightness.
pub(crate) fn small_exr(width: u32, height: u32) -> Vec<u8> {
    grey_exr(width, height, |x, y| (1 + x + width * y) as f32)
}

/// Returns a grey OpenEXR image.
pub(crate) fn grey_exr(width: u32, height: u32, texel: impl Fn(u32, u32) -> f32) -> Vec<u8> {
    let texel = |x, y| image::Rgb([texel(x, y); 3]);
    let map = image::Rgb32FImage::from_fn(width, height, texel);
    let mut bytes = std::io::Cursor::new(Vec::new());
    map.write_to(&mut bytes, image::ImageFormat::OpenExr).unwrap();
    bytes.into_inner()
}
