//! Arrays that an embedding program gives in place of files.

mod picture;
mod points;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex};

use sphvar_integrands::{EnergyEstimates, Integrand};
use sphvar_samplers::ProfileTable;
use sphvar_sh::Alm;

use crate::files::FitsMap;
use crate::session::lock;

pub(crate) use self::picture::GivenPicture;
pub use self::points::PointTable;

/// A function that an embedding program gives.
pub(crate) type GivenFunction = Arc<dyn Integrand + Send + Sync>;

/// Arrays by their names, which have precedence over files of the same name. Clones share them.
#[derive(Clone, Default)]
pub(crate) struct Given(Arc<Mutex<Tables>>);

#[derive(Default)]
struct Tables {
    points: BTreeMap<String, Arc<PointTable>>,
    pictures: BTreeMap<String, Arc<GivenPicture>>,
    maps: BTreeMap<String, Arc<FitsMap>>,
    coefficients: BTreeMap<String, Arc<Alm>>,
    energies: BTreeMap<String, Arc<EnergyEstimates>>,
    profiles: BTreeMap<String, Arc<ProfileTable>>,
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
    kind!(add_picture, picture, pictures, Arc<GivenPicture>);
    kind!(add_map, map, maps, Arc<FitsMap>);
    kind!(add_coefficients, coefficients, coefficients, Arc<Alm>);
    kind!(add_energies, energies, energies, Arc<EnergyEstimates>);
    kind!(add_profile, profile, profiles, Arc<ProfileTable>);
    kind!(add_function, function, functions, GivenFunction);
}
