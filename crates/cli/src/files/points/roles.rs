//! The possible meanings of columns, and the option `--columns` that assigns them.

use std::str::FromStr;

use super::space::Space;
use crate::files::text_rows::shortened;

/// The roles of columns with their names in headers, in any case.
const ROLES: [(&str, &[&str]); 19] = [
    ("x", &["x"]),
    ("y", &["y"]),
    ("z", &["z"]),
    ("u", &["u"]),
    ("v", &["v"]),
    ("theta", &["theta"]),
    ("phi", &["phi"]),
    ("lon", &["lon", "longitude"]),
    ("lat", &["lat", "latitude"]),
    (
        "ra",
        &[
            "ra",
            "raj2000",
            "_raj2000",
            "ra_icrs",
            "ra_deg",
            "radeg",
            "alpha_j2000",
            "alphawin_j2000",
            "right ascension",
            "right_ascension",
        ],
    ),
    (
        "dec",
        &[
            "dec",
            "dej2000",
            "_dej2000",
            "decj2000",
            "de_icrs",
            "dec_icrs",
            "dec_deg",
            "decdeg",
            "delta_j2000",
            "deltawin_j2000",
            "declination",
        ],
    ),
    ("glon", &["glon", "_glon"]),
    ("glat", &["glat", "_glat"]),
    ("l", &["l"]),
    ("b", &["b"]),
    ("w", &["w", "weight", "weights"]),
    ("value", &["value", "values"]),
    ("sigma", &["sigma"]),
    ("set", &["set"]),
];

/// The combinations of roles that form a direction.
pub(super) const SPHERE_SYSTEMS: [&[&str]; 6] = [
    &["x", "y", "z"],
    &["theta", "phi"],
    &["lon", "lat"],
    &["ra", "dec"],
    &["glon", "glat"],
    &["l", "b"],
];
/// The combinations that catalogues provide side by side for the same places.
pub(super) const CELESTIAL: [&[&str]; 3] = [&["ra", "dec"], &["glon", "glat"], &["l", "b"]];
/// The combinations of roles that form a point of the square.
pub(super) const SQUARE_SYSTEMS: [&[&str]; 2] = [&["u", "v"], &["x", "y"]];

/// Returns the role of a column name.
pub(super) fn role_of(name: &str) -> Option<&'static str> {
    let name = name.trim();
    let (role, _) =
        ROLES.iter().find(|(_, aliases)| aliases.iter().any(|a| name.eq_ignore_ascii_case(a)))?;
    Some(role)
}

/// The value of the option `--columns`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ColumnChoice {
    /// The roles of the columns from left to right; `None`, written `_`, skips one.
    Positions(Vec<Option<&'static str>>),
    /// Roles with the names of their columns.
    Names(Vec<(&'static str, String)>),
}

impl ColumnChoice {
    /// Returns the assigned roles.
    pub(super) fn roles(&self) -> Vec<&'static str> {
        match self {
            Self::Positions(roles) => roles.iter().flatten().copied().collect(),
            Self::Names(names) => names.iter().map(|(role, _)| *role).collect(),
        }
    }

    /// Checks that the roles form exactly one point, of any space.
    fn check(&self) -> Result<(), String> {
        let roles = self.roles();
        if let Some(twice) = (1..roles.len()).find(|&i| roles[..i].contains(&roles[i])) {
            return Err(format!("{} is given twice", roles[twice]));
        }
        let complete = |system: &&&[&str]| system.iter().all(|role| roles.contains(role));
        let mut systems = SPHERE_SYSTEMS.iter().chain(&SQUARE_SYSTEMS);
        let Some(system) = systems.find(complete) else {
            let [sphere, square] = [Space::Sphere, Space::Square].map(Space::systems_in_words);
            return Err(format!("expected all of {sphere}, or with --square {square}"));
        };
        let others = ["w", "value", "sigma", "set"];
        match roles.iter().find(|role| !system.contains(role) && !others.contains(role)) {
            Some(extra) => Err(format!("{extra} does not go with {}", system.join(","))),
            None => Ok(()),
        }
    }
}

impl FromStr for ColumnChoice {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let role = |name: &str| {
            role_of(name).ok_or_else(|| {
                let known: Vec<&str> = ROLES.iter().map(|(role, _)| *role).collect();
                format!(
                    "unknown {:?}; expected {}, or _ to skip a column, or as in ra=RAJ2000",
                    shortened(name),
                    known.join(", ")
                )
            })
        };
        let mut positions = Vec::new();
        let mut names = Vec::new();
        for part in parts(text) {
            let part = part.trim();
            match part.split_once('=') {
                Some((left, name)) => {
                    let name = name.trim();
                    let inner = name.strip_prefix('"').and_then(|n| n.strip_suffix('"'));
                    let name = inner.map_or_else(|| name.to_owned(), |n| n.replace("\"\"", "\""));
                    if name.is_empty() {
                        return Err(format!("no name after {left}="));
                    }
                    names.push((role(left)?, name));
                }
                None if part == "_" => positions.push(None),
                None => positions.push(Some(role(part)?)),
            }
        }
        let choice = match (positions.is_empty(), names.is_empty()) {
            (_, true) => Self::Positions(positions),
            (true, _) => Self::Names(names),
            _ => {
                return Err("expected either positions (ra,dec,w) or names (ra=A,dec=B,w=C), \
                            not both"
                    .to_owned());
            }
        };
        choice.check()?;
        Ok(choice)
    }
}

/// Returns the parts between commas outside of quotes.
fn parts(text: &str) -> Vec<&str> {
    let mut quoted = false;
    text.split(|c| {
        quoted ^= c == '"';
        c == ',' && !quoted
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::{ColumnChoice, role_of};

    #[test]
    fn choices_by_position_and_by_name() {
        let positions = |roles: &[Option<&'static str>]| ColumnChoice::Positions(roles.to_vec());
        let names = |pairs: &[(&'static str, &str)]| {
            ColumnChoice::Names(pairs.iter().map(|(r, n)| (*r, (*n).to_owned())).collect())
        };
        let cases = [
            ("ra,dec,w", positions(&[Some("ra"), Some("dec"), Some("w")])),
            ("_,Z, y,x", positions(&[None, Some("z"), Some("y"), Some("x")])),
            (
                "ra=RAJ2000,dec=DEJ2000,w=WEIGHT",
                names(&[("ra", "RAJ2000"), ("dec", "DEJ2000"), ("w", "WEIGHT")]),
            ),
            ("lon=\"RA, deg\",lat=a=b", names(&[("lon", "RA, deg"), ("lat", "a=b")])),
        ];
        for (text, expected) in cases {
            assert_eq!(text.parse(), Ok(expected), "{text}");
        }
        let wrong = [
            ("", "unknown \"\""),
            ("ra,dec,wieght", "unknown \"wieght\""),
            ("ra,dec,w=W", "not both"),
            ("ra,w", "expected all of x,y,z or"),
            ("ra,dec,ra", "ra is given twice"),
            ("ra,dec,lon", "lon does not go with ra,dec"),
            ("ra=,dec=D", "no name after ra="),
        ];
        for (text, part) in wrong {
            let message = text.parse::<ColumnChoice>().unwrap_err();
            assert!(message.contains(part), "{text}: {message}");
        }
    }

    #[test]
    fn names_of_catalogues_are_known_in_any_case() {
        for (name, role) in [
            ("RAJ2000", "ra"),
            ("delta_J2000", "dec"),
            ("Right Ascension", "ra"),
            ("Declination", "dec"),
            ("Glon", "glon"),
            (" WEIGHTS ", "w"),
        ] {
            assert_eq!(role_of(name), Some(role), "{name}");
        }
        assert_eq!((role_of("redshift"), role_of("")), (None, None));
    }
}
