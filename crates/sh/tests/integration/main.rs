//! Legendre functions, harmonics and quadrature against identities and tables.

mod identities;
mod quadrature;
