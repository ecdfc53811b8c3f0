//! The description of a plan, `manifest.json` in its folder.

use std::io;
use std::path::{Path, PathBuf};

use clap::ValueEnum;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::CliError;
use crate::files::read_regular;
use crate::message;
use crate::report::quoted;

/// The name of the file.
pub(super) const NAME: &str = "manifest.json";
/// The version of its form.
const FORM: u32 = 1;
/// The folder of the results of parts.
pub(super) const PARTS: &str = "parts";
/// The folder of logs.
pub(super) const LOGS: &str = "logs";
/// The minimum number of digits in the names of the files of parts.
const MIN_DIGITS: usize = 4;

/// A program that runs the parts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Engine {
    /// An array job and a merge that depends on it
    Slurm,
    /// A job of tasks, the last of which merges
    Hyperqueue,
    /// Tasks of Dask distributed
    Dask,
    /// Processes on this machine
    Shell,
}

/// What a folder of a plan is for: a command whose work is divided into parts.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub(crate) struct Manifest {
    /// The version of the form of this file.
    form: u32,
    /// The version of sphvar. Only parts of the same version can be merged.
    pub(super) version: String,
    /// The words of the command after the name `sphvar`.
    pub(super) words: Vec<String>,
    /// The number of parts.
    pub(super) parts: u64,
    /// The program that runs the parts: `slurm`, `hyperqueue`, `dask` or `shell`.
    #[schemars(with = "String")]
    pub(super) engine: Engine,
    /// The folder in which the command runs and which its relative paths refer to.
    pub(super) folder: String,
    /// The program that runs, unless the variable `SPHVAR` names another one.
    pub(super) program: String,
    /// The number of threads of a part; 0 for one per core.
    pub(super) threads: usize,
    /// The maximum number of parts at a time, for the shell; null for what the cores allow.
    pub(super) workers: Option<u64>,
    /// The time limit of a part, for Slurm.
    pub(super) time: Option<String>,
    /// The memory of a part, for Slurm.
    pub(super) mem: Option<String>,
    /// The number of digits in the names of the files of parts, such as `parts/0001.shard`.
    pub(super) digits: usize,
    /// The files of the plan beside this one, relative to its folder.
    pub(super) files: Vec<String>,
}

/// The settings of a plan besides its command.
#[derive(Clone, Debug)]
pub(super) struct Settings {
    pub(super) parts: u64,
    pub(super) engine: Engine,
    pub(super) threads: usize,
    pub(super) workers: Option<u64>,
    pub(super) time: Option<String>,
    pub(super) mem: Option<String>,
}

impl Manifest {
    /// Returns the manifest of a command that runs in `folder`; `program` is its absolute path.
    pub(super) fn new(
        words: &[String],
        settings: Settings,
        folder: String,
        program: String,
    ) -> Self {
        let Settings { parts, engine, threads, workers, time, mem } = settings;
        Self {
            form: FORM,
            version: env!("CARGO_PKG_VERSION").to_owned(),
            words: words.to_vec(),
            parts,
            engine,
            folder,
            program,
            threads,
            workers,
            time,
            mem,
            digits: parts.to_string().len().max(MIN_DIGITS),
            files: Vec::new(),
        }
    }

    /// Reads the manifest of a folder; `None` if the folder has none.
    ///
    /// # Errors
    ///
    /// If it cannot be read, is invalid, or has another form.
    pub(crate) fn read(folder: &Path) -> Result<Option<Self>, CliError> {
        let path = folder.join(NAME);
        let shown = path.display();
        let bytes = match read_regular(&path) {
            Ok(bytes) => bytes,
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(error) => return Err(CliError::File(format!("cannot read {shown}: {error}"))),
        };
        let manifest: Self = serde_json::from_slice(&bytes).map_err(|error| {
            CliError::File(format!("{shown}: expected a file of sphvar plan: {error}"))
        })?;
        if manifest.form != FORM || !(1..=super::MAX_PARTS).contains(&manifest.parts) {
            return Err(CliError::File(format!(
                "{shown}: expected form {FORM} and 1 to {} parts, got form {} and {} parts",
                super::MAX_PARTS,
                manifest.form,
                manifest.parts
            )));
        }
        Ok(Some(manifest))
    }

    /// Reads the manifest of a folder, which has one.
    ///
    /// # Errors
    ///
    /// Those of [`read`](Self::read), or if there is none.
    pub(crate) fn of_folder(folder: &Path) -> Result<Self, CliError> {
        let missing =
            || CliError::File(format!("{} has no {NAME} of sphvar plan", folder.display()));
        Self::read(folder)?.ok_or_else(missing)
    }

    /// Returns whether both plans have the same parts and scripts, wherever the program is.
    pub(super) fn is_same_plan(&self, other: &Self) -> bool {
        let plain = |manifest: &Self| Self {
            program: String::new(),
            files: Vec::new(),
            ..manifest.clone()
        };
        plain(self) == plain(other)
    }

    /// Returns the plan in one line.
    pub(super) fn line(&self) -> String {
        let engine = self.engine.to_possible_value();
        let engine = engine.map(|value| value.get_name().to_owned()).unwrap_or_default();
        let words: Vec<String> =
            self.words.iter().map(|word| quoted(&message::escape(word))).collect();
        let parts = match self.parts {
            1 => "1 part".to_owned(),
            n => format!("{n} parts"),
        };
        format!("sphvar {} in {parts} for {engine} (sphvar {})", words.join(" "), self.version)
    }

    /// Returns the folder in which the command runs.
    pub(crate) fn working_folder(&self) -> &Path {
        Path::new(&self.folder)
    }

    /// Returns the file of the results of a part in the folder of the plan.
    pub(crate) fn part_path(&self, folder: &Path, part: u64) -> PathBuf {
        folder.join(PARTS).join(format!("{}.shard", self.part_name(part)))
    }

    /// Returns the log of a part in the folder of the plan.
    pub(super) fn log_path(&self, folder: &Path, part: u64) -> PathBuf {
        folder.join(LOGS).join(format!("{}.jsonl", self.part_name(part)))
    }

    /// Returns the file of what a part printed in the folder of the plan.
    pub(super) fn output_path(&self, folder: &Path, part: u64) -> PathBuf {
        folder.join(LOGS).join(format!("{}.out", self.part_name(part)))
    }

    /// Returns the file of what Slurm reported about a part in the folder of the plan.
    pub(super) fn slurm_path(&self, folder: &Path, part: u64) -> PathBuf {
        folder.join(LOGS).join(format!("slurm-{part}.out"))
    }

    fn part_name(&self, part: u64) -> String {
        format!("{part:0digits$}", digits = self.digits)
    }

    /// Returns the files of the results that exist, in the order of the parts.
    pub(crate) fn existing_parts(&self, folder: &Path) -> Vec<PathBuf> {
        let all = (1..=self.parts).map(|part| self.part_path(folder, part));
        all.filter(|path| path.exists()).collect()
    }
}
