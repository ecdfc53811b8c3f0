use std::path::Path;

/// A spectrum recorded by an independent program, from `tests/data`.
#[derive(Clone, Debug)]
pub struct ReferenceSpectrum {
    name: &'static str,
    power: Vec<f64>,
    stderr: Vec<f64>,
}

impl ReferenceSpectrum {
    /// Returns the spectrum of the file `data/<name>.csv`.
    ///
    /// # Panics
    ///
    /// Panics if the file cannot be read, or if its degrees are not consecutive from 1.
    #[must_use]
    pub fn load(name: &'static str) -> Self {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join("data").join(name).with_extension("csv");
        let file = csv::ReaderBuilder::new().comment(Some(b'#')).from_path(&path);
        let mut file = file.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        // Degree 0 is not in the file: it is N for every set.
        let (mut power, mut stderr) = (vec![f64::NAN], vec![f64::NAN]);
        for row in file.deserialize::<(usize, f64, f64, f64)>() {
            let (l, _, mean, error) = row.unwrap_or_else(|e| panic!("{}: {e}", path.display()));
            assert_eq!(l, power.len(), "{}: degrees must ascend from 1", path.display());
            power.push(mean);
            stderr.push(error);
        }
        assert!(power.len() > 1, "{}: no rows", path.display());
        Self { name, power, stderr }
    }

    /// Returns the name of the file.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.name
    }

    /// Returns the largest degree.
    #[must_use]
    pub fn lmax(&self) -> usize {
        self.power.len() - 1
    }

    /// Returns the mean power, index l from 0, where it is NaN.
    #[must_use]
    pub fn power(&self) -> &[f64] {
        &self.power
    }

    /// Returns the standard errors, index l from 0; 0 for exact spectra.
    #[must_use]
    pub fn stderr(&self) -> &[f64] {
        &self.stderr
    }
}
