//! Which column of a text file means what.

use crate::files::file_error::{FileError, Place};

/// The columns that together give a direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Coordinates {
    /// Cartesian components.
    Vector { x: usize, y: usize, z: usize },
    /// Colatitude and longitude in radians.
    Radians { theta: usize, phi: usize },
    /// Longitude and latitude, or right ascension and declination, in degrees.
    Degrees { lon: usize, lat: usize },
}

/// The meaning of the columns of one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    /// The name of every column, in the order of the file.
    pub(super) names: Vec<String>,
    /// Where the direction stands.
    pub(super) coordinates: Coordinates,
    /// Where the weight stands, if anywhere.
    pub(super) weight: Option<usize>,
    /// Where the value stands, if anywhere.
    pub(super) value: Option<usize>,
    /// Where the label of the set stands, if anywhere.
    pub(super) set: Option<usize>,
}

/// The ways to name a direction.
const SYSTEMS: [&[&str]; 4] =
    [&["x", "y", "z"], &["theta", "phi"], &["lon", "lat"], &["ra", "dec"]];
/// The same for messages.
const SYSTEMS_TEXT: &str = "x,y,z or theta,phi (radians) or lon,lat or ra,dec (degrees)";

impl Layout {
    /// Returns the layout of a file whose first line is a header.
    pub(super) fn of_header(
        header: &[impl AsRef<str>],
        chosen: Option<&[String]>,
        path: &str,
        line: usize,
    ) -> Result<Self, FileError> {
        let names: Vec<String> = header.iter().map(|name| canonical(name.as_ref())).collect();
        let Some(chosen) = chosen else {
            return Self::of_names(names, path, Place::Line(line));
        };
        let chosen: Vec<String> = chosen.iter().map(|name| canonical(name)).collect();
        if !names.iter().any(|name| chosen.contains(name)) && chosen.len() == names.len() {
            // A header in words of its own: the option names its columns from left to right.
            return Self::of_names(chosen, path, Place::Line(line));
        }
        if let Some(missing) = chosen.iter().find(|name| !names.contains(name)) {
            let header: Vec<&str> = header.iter().map(AsRef::as_ref).collect();
            return Err(FileError::Layout {
                path: path.to_owned(),
                place: Place::Line(line),
                expected: format!("the column {missing} that --columns asks for"),
                got: format!("the header {}", header.join(",")),
            });
        }
        let kept = names
            .into_iter()
            .map(|name| if chosen.contains(&name) { name } else { String::new() })
            .collect();
        Self::of_names(kept, path, Place::Line(line))
    }

    /// Returns the layout of a file without a header.
    pub(super) fn without_header(
        fields: usize,
        chosen: Option<&[String]>,
        path: &str,
        line: usize,
    ) -> Result<Self, FileError> {
        if let Some(chosen) = chosen {
            let names: Vec<String> = chosen.iter().map(|name| canonical(name)).collect();
            if names.len() != fields {
                return Err(FileError::Layout {
                    path: path.to_owned(),
                    place: Place::Line(line),
                    expected: format!(
                        "{} fields, as --columns {} says",
                        names.len(),
                        chosen.join(",")
                    ),
                    got: fields.to_string(),
                });
            }
            return Self::of_names(names, path, Place::Line(line));
        }
        if fields == 3 {
            let names = ["x", "y", "z"].map(str::to_owned).to_vec();
            return Self::of_names(names, path, Place::Line(line));
        }
        let example = match fields {
            2 => "--columns theta,phi or --columns lon,lat",
            4 => "--columns x,y,z,w",
            _ => "--columns x,y,z,_,_ (another name skips a field)",
        };
        Err(FileError::Layout {
            path: path.to_owned(),
            place: Place::Line(line),
            expected: format!(
                "3 fields (x y z), or a header, or names by the option --columns such as {example}"
            ),
            got: format!(
                "{fields} {} without a header",
                if fields == 1 { "field" } else { "fields" }
            ),
        })
    }

    fn of_names(names: Vec<String>, path: &str, place: Place) -> Result<Self, FileError> {
        let error = |expected: String| FileError::Layout {
            path: path.to_owned(),
            place,
            expected,
            got: format!("the columns {}", shown(&names)),
        };
        let find = |wanted: &str| names.iter().position(|name| name == wanted);
        let known = SYSTEMS.iter().copied().flatten().copied().chain(["w", "value", "set"]);
        for name in known {
            if names.iter().filter(|other| *other == name).count() > 1 {
                return Err(error(format!("the column {name} once")));
            }
        }
        let complete: Vec<&[&str]> = SYSTEMS
            .into_iter()
            .filter(|system| system.iter().all(|name| find(name).is_some()))
            .collect();
        let coordinates = match complete.as_slice() {
            [] => {
                let begun =
                    SYSTEMS.iter().find(|system| system.iter().any(|name| find(name).is_some()));
                let Some(begun) = begun else {
                    return Err(error(format!("columns named {SYSTEMS_TEXT}")));
                };
                let missing: Vec<&str> =
                    begun.iter().copied().filter(|name| find(name).is_none()).collect();
                return Err(error(format!(
                    "the column {} beside the others of {}",
                    missing.join(" and "),
                    begun.join(",")
                )));
            }
            [system] => match system.iter().filter_map(|name| find(name)).collect::<Vec<_>>()[..] {
                [x, y, z] => Coordinates::Vector { x, y, z },
                [theta, phi] if system[0] == "theta" => Coordinates::Radians { theta, phi },
                [lon, lat] => Coordinates::Degrees { lon, lat },
                _ => return Err(error(format!("columns named {SYSTEMS_TEXT}"))),
            },
            [first, ..] => {
                return Err(error(format!(
                    "one way to name the direction, chosen by the option --columns (such as {})",
                    first.join(",")
                )));
            }
        };
        let (weight, value, set) = (find("w"), find("value"), find("set"));
        Ok(Self { names, coordinates, weight, value, set })
    }
}

/// Returns a column's name in the form used here: lower case, and one word for each meaning.
fn canonical(name: &str) -> String {
    let name = name.trim().to_ascii_lowercase();
    match name.as_str() {
        "weight" => "w".to_owned(),
        "longitude" => "lon".to_owned(),
        "latitude" => "lat".to_owned(),
        _ => name,
    }
}

/// Returns column names for a message; wide tables are cut.
fn shown(names: &[String]) -> String {
    const MOST: usize = 12;
    let mut text = names.iter().take(MOST).map(String::as_str).collect::<Vec<_>>().join(",");
    if names.len() > MOST {
        text.push_str(",...");
    }
    text
}
