//! References for tested values: arithmetic in twice the working precision, associated Legendre
//! functions computed in it, and a table of them with 25 digits.
//!
//! The references are slow, and they do not depend on the tested crates.
//!
//! ```
//! use sphvar_accuracy::reference::{DoubleDouble, LegendreTable};
//!
//! let (sin, cos) = DoubleDouble::from(2.5).sin_cos();
//! let rest = sin * sin + cos * cos - DoubleDouble::ONE;
//! assert!(rest.value().abs() < 1e-30);
//! assert_eq!(LegendreTable::rows().count(), 263);
//! ```

mod acute_angle;
mod double_double;
mod legendre;
mod legendre_table;
mod power;
mod trigonometry;

pub use acute_angle::AcuteAngle;
pub use double_double::DoubleDouble;
pub use legendre::{LegendreColumn, LegendreValue, lambda};
pub use legendre_table::{LegendreRow, LegendreTable};
pub use power::power;
