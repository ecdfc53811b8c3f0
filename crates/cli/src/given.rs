//! Arrays that an embedding program gives in place of files.

mod points;
mod reading;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

use sphvar_integrands::Integrand;
use sphvar_samplers::ProfileTable;
use sphvar_sh::Alm;

use crate::files::{FitsMap, PictureArray, SpectrumRow};
use crate::session::lock;

pub use self::points::PointTable;

/// A function that an embedding program gives.
pub(crate) type GivenFunction = Arc<dyn Integrand + Send + Sync>;

/// Energies by degree from 0, with their standard errors if they are known.
pub(crate) struct EnergyArray {
    pub(crate) values: Vec<f64>,
    pub(crate) errors: Option<Vec<f64>>,
}

/// Arrays by their names, which have precedence over files of the same name. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Given(Arc<Mutex<Tables>>);

#[derive(Default)]
struct Tables {
    points: BTreeMap<String, Arc<PointTable>>,
    pictures: BTreeMap<String, Arc<PictureArray>>,
    maps: BTreeMap<String, Arc<FitsMap>>,
    coefficients: BTreeMap<String, Arc<Alm>>,
    energies: BTreeMap<String, Arc<EnergyArray>>,
    profiles: BTreeMap<String, Arc<ProfileTable>>,
    spectra: BTreeMap<String, Arc<[SpectrumRow]>>,
    functions: BTreeMap<String, GivenFunction>,
}

/// Defines the pair of functions that adds and returns the arrays of a kind.
macro_rules! kind {
    ($add:ident, $get:ident, $field:ident, $array:ty) => {
        pub(crate) fn $add(&self, name: &str, array: $array) {
            lock(&self.0).$field.insert(name.to_owned(), array);
        }

        pub(crate) fn $get(&self, name: &Path) -> Option<$array> {
            lock(&self.0).$field.get(name.to_str()?).cloned()
        }
    };
}

impl Given {
    kind!(add_points, points, points, Arc<PointTable>);
    kind!(add_picture, picture, pictures, Arc<PictureArray>);
    kind!(add_map, map, maps, Arc<FitsMap>);
    kind!(add_coefficients, coefficients, coefficients, Arc<Alm>);
    kind!(add_energies, energies, energies, Arc<EnergyArray>);
    kind!(add_profile, profile, profiles, Arc<ProfileTable>);
    kind!(add_spectrum, spectrum, spectra, Arc<[SpectrumRow]>);
    kind!(add_function, function, functions, GivenFunction);

    /// Returns whether a message on the content of an input is about one of the arrays: it has the
    /// name at the start, or before the place of the error.
    pub(crate) fn is_about(&self, message: &str) -> bool {
        let tables = lock(&self.0);
        let names = tables.points.keys().chain(tables.pictures.keys()).chain(tables.maps.keys());
        let names = names.chain(tables.coefficients.keys()).chain(tables.energies.keys());
        let names = names.chain(tables.profiles.keys()).chain(tables.functions.keys());
        names.chain(tables.spectra.keys()).any(|name| {
            message.match_indices(name.as_str()).any(|(at, name)| {
                let (before, after) = (&message[..at], &message[at + name.len()..]);
                let is_start = before.is_empty() && after.starts_with(' ');
                is_start
                    || (!before.ends_with(char::is_alphanumeric) && after.starts_with([':', '[']))
            })
        })
    }
}
