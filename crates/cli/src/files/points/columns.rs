//! The meaning of the columns of a file, for all formats.

use super::ReadOptions;
use super::column::Column;
use super::roles::{CELESTIAL, ColumnChoice};
use super::space::Space;
use super::suggestion::{suggested, suggestions};
use crate::files::file_error::{FileError, Place};
use crate::files::text_rows::shortened;

/// The maximum number of names that a message lists.
const LISTED: usize = 12;

/// The position of a number of a point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Slot {
    /// Its meaning.
    pub(super) role: &'static str,
    /// The column, from 0.
    pub(super) column: usize,
    /// The index of the number among those of the column in a row, from 0.
    pub(super) item: usize,
    /// Its name for messages.
    pub(super) label: String,
}

/// The meaning of the columns of one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Layout {
    /// The coordinates in the order of their combination, then the weight, the value and its
    /// standard error, then the set.
    pub(super) slots: Vec<Slot>,
    /// The slot of the weight, if there is one.
    pub(super) weight: Option<usize>,
    /// The slot of the value, if values are read.
    pub(super) value: Option<usize>,
    /// The slot of the standard error of the value, if values are read.
    pub(super) sigma: Option<usize>,
    /// The slot of the label of the set, if there is one.
    pub(super) set: Option<usize>,
    /// The columns that are not used, for a remark.
    pub(super) unused: Vec<String>,
    /// The columns of other directions that could be used, as a value of `--columns`, for a remark.
    pub(super) others: Option<String>,
}

impl Layout {
    /// Adds a column of another table: the weight, the value or its standard error.
    pub(super) fn add(&mut self, role: &'static str, column: usize) {
        let index = Some(self.slots.len());
        match role {
            "value" => self.value = index,
            "sigma" => self.sigma = index,
            _ => self.weight = index,
        }
        self.slots.push(Slot { role, column, item: 0, label: role.to_owned() });
    }
}

/// The columns of a file together with the user's options.
#[derive(Debug, Clone, Copy)]
pub(super) struct Table<'a> {
    pub(super) path: &'a str,
    /// The place of the column names, for messages.
    pub(super) place: Place,
    pub(super) columns: &'a [Column],
    /// Whether the file names its columns.
    pub(super) has_names: bool,
    pub(super) options: &'a ReadOptions,
}

/// A role with its column and item.
pub(super) type Assigned = (&'static str, usize, Option<usize>);

impl Table<'_> {
    /// Returns the meaning of the columns.
    ///
    /// # Errors
    ///
    /// If the columns form no direction or more than one, a name of `--columns` is not
    /// among them, or a required column has no numbers.
    pub(super) fn layout(&self) -> Result<Layout, FileError> {
        self.check_choice()?;
        let assigned = match &self.options.columns {
            Some(ColumnChoice::Names(names)) => self.by_name(names)?,
            Some(ColumnChoice::Positions(roles)) => self.by_position(roles)?,
            None if self.has_names => self.by_header()?,
            None => self.without_names()?,
        };
        let system = self.system(&assigned)?;
        if self.options.space == Space::Square
            && system.contains(&"x")
            && assigned.iter().any(|(role, ..)| *role == "z")
        {
            return Err(self.error(
                "two columns u,v or x,y of points of the unit square".to_owned(),
                "the columns x,y,z; directions are read without --square".to_owned(),
            ));
        }
        let mut slots = Vec::new();
        let of_value: &[&str] = if self.options.values { &["value", "sigma"] } else { &[] };
        let others = ["w"].iter().chain(of_value).chain(&["set"]);
        for role in system.iter().chain(others).copied() {
            if let Some(&assigned) = assigned.iter().find(|(other, ..)| *other == role) {
                slots.push(self.slot(assigned, &slots)?);
            }
        }
        let find = |role: &str| slots.iter().position(|slot| slot.role == role);
        let (weight, set) = (find("w"), find("set"));
        let (value, sigma) = (find("value"), find("sigma"));
        let mut is_used = vec![false; self.columns.len()];
        for slot in &slots {
            is_used[slot.column] = true;
        }
        let unread = assigned.iter().find(|(role, ..)| *role == "value");
        let name = |index: usize| match unread {
            Some((role, column, _)) if *column == index => (*role).to_owned(),
            _ => self.name(index),
        };
        // A column without a name and numbers is the padding of a record.
        let is_padding = |column: &Column| column.name.is_empty() && column.items == 0;
        let unused = (0..self.columns.len())
            .filter(|&i| !is_used[i] && !is_padding(&self.columns[i]))
            .map(name)
            .collect();
        let others = self.other_system(system, &assigned);
        Ok(Layout { slots, weight, value, sigma, set, unused, others })
    }

    /// Returns the combinations of roles that form a point.
    pub(super) fn systems(&self) -> &'static [&'static [&'static str]] {
        self.options.space.systems()
    }

    /// Returns the role of a column name.
    pub(super) fn role_of(&self, name: &str) -> Option<&'static str> {
        self.options.space.role_of(name)
    }

    /// Returns the only combination of roles that forms a direction.
    fn system(&self, assigned: &[Assigned]) -> Result<&'static [&'static str], FileError> {
        let spelling = self.options.spelling;
        let has = |role: &&str| assigned.iter().any(|(other, ..)| other == role);
        let complete: Vec<&'static [&'static str]> =
            self.systems().iter().copied().filter(|system| system.iter().all(&has)).collect();
        let columns = || {
            // With --columns, or without names, no better combination can exist.
            let flags = match self.options.columns {
                None if self.has_names => suggested(self.columns, self.options),
                _ => String::new(),
            };
            let advice = if flags.is_empty() { flags } else { format!("; use {flags}") };
            format!("the columns {}{advice}", self.names())
        };
        match complete[..] {
            [system] => Ok(system),
            // They denote the same places, which differ by a rotation.
            [system, ..] if complete.iter().all(|system| CELESTIAL.contains(system)) => Ok(system),
            [] => {
                // A single b or l more likely denotes something else.
                let begun = self.systems().iter().find(|s| **s != ["l", "b"] && s.iter().any(&has));
                let Some(begun) = begun else {
                    let space = self.options.space;
                    let is_named = |role: &&str| {
                        self.columns.iter().any(|c| Space::Square.role_of(&c.name) == Some(*role))
                    };
                    let is_of_square = space == Space::Sphere && ["u", "v"].iter().all(is_named);
                    let remedy = match is_of_square {
                        true => "; points of the unit square are read with --square",
                        false => "",
                    };
                    let expected = format!("columns named {}", space.systems_in_words());
                    return Err(self.error(expected, columns() + remedy));
                };
                let missing: Vec<&str> = begun.iter().copied().filter(|r| !has(r)).collect();
                Err(self.error(
                    format!(
                        "the column {} beside the others of {}",
                        missing.join(" and "),
                        begun.join(",")
                    ),
                    columns(),
                ))
            }
            _ => Err(self.error(
                format!(
                    "one way to name the point, chosen by the option {}",
                    spelling.name("columns")
                ),
                columns(),
            )),
        }
    }

    /// Returns the value of `--columns` for a direction other than the one in use, if the file has
    /// one.
    fn other_system(&self, used: &[&str], assigned: &[Assigned]) -> Option<String> {
        let has = |role: &&str| assigned.iter().any(|(other, ..)| other == role);
        let other =
            self.systems().iter().find(|system| **system != used && system.iter().all(has))?;
        let start = format!("{}=", other[0]);
        let is_other = |value: &String| value.starts_with(&start);
        suggestions(self.columns, self.options.space, self.options.values)
            .into_iter()
            .find(is_other)
    }

    fn slot(&self, (role, column, item): Assigned, others: &[Slot]) -> Result<Slot, FileError> {
        let Column { name, items, unit } = &self.columns[column];
        let item = match (items, item) {
            (0, _) => {
                let got = "strings, complex numbers, or lists of any length".to_owned();
                return Err(self.error(format!("numbers in the column {}", shortened(name)), got));
            }
            (1, None) => 0,
            (_, Some(item)) if item < *items => item,
            _ => {
                let name = shortened(name);
                let expected = format!("one of the numbers {name}[0] to {name}[{}]", items - 1);
                return Err(self.error(expected, format!("{role}, which takes one number")));
            }
        };
        if let Some(right) = right_unit(role, unit) {
            let expected = format!("{role} in {right}");
            let got = format!("{} in the unit {}", self.name(column), shortened(unit));
            return Err(self.error(expected, got));
        }
        if others.iter().any(|slot| (slot.column, slot.item) == (column, item)) {
            let expected = format!("a separate column for {role}");
            return Err(self.error(expected, format!("{} twice", self.name(column))));
        }
        // A name that begins like the role adds no information.
        let is_plain = name.is_empty() || name.trim().to_lowercase().starts_with(role);
        let label =
            if is_plain { role.to_owned() } else { format!("{role} ({})", shortened(name)) };
        Ok(Slot { role, column, item, label })
    }

    /// Returns the name of a column for messages.
    pub(super) fn name(&self, index: usize) -> String {
        match self.columns[index].name.trim() {
            "" => format!("column {}", index + 1),
            name => shortened(name),
        }
    }

    pub(super) fn names(&self) -> String {
        let names: Vec<String> =
            (0..self.columns.len().min(LISTED + 1)).map(|i| self.name(i)).collect();
        listed(&names, self.columns.len())
    }

    pub(super) fn error(&self, expected: String, got: String) -> FileError {
        FileError::Layout { path: self.path.to_owned(), place: self.place, expected, got }
    }
}

/// Returns the unit that a role requires if a column states another one.
///
/// A unit without letters, such as `-`, counts as none.
fn right_unit(role: &str, unit: &str) -> Option<&'static str> {
    let unit = unit.trim().to_lowercase();
    let states_nothing = unit != "°" && !unit.contains(char::is_alphabetic) && !unit.contains('"');
    let (is_right, right) = match role {
        "lon" | "lat" | "ra" | "dec" | "glon" | "glat" | "l" | "b" => {
            let in_degrees = ["deg", "d", "°", "decimal deg", "angle[deg"];
            let is_right = in_degrees.iter().any(|name| match unit.strip_prefix(name) {
                Some(rest) => rest.is_empty() || name.ends_with("deg"),
                None => false,
            });
            (is_right, "degrees")
        }
        "theta" | "phi" => (matches!(&*unit, "rad" | "radian" | "radians"), "radians"),
        _ => (true, ""),
    };
    (!is_right && !states_nothing).then_some(right)
}

/// Returns the first of `count` names for a message, with the number of the others.
pub(super) fn listed(names: &[String], count: usize) -> String {
    let mut text = names.iter().take(LISTED).map(String::as_str).collect::<Vec<_>>().join(",");
    if count > LISTED {
        text.push_str(&format!(",... ({} more)", count - LISTED));
    }
    text
}

#[cfg(test)]
mod tests {
    use super::right_unit;

    /// A stated unit must be that of the role.
    #[test]
    fn units_of_angles() {
        let degrees = [
            "deg",
            "DEGREES",
            "Degree",
            "decimal degrees",
            "Angle[deg]",
            "d",
            "\u{b0}",
            "",
            "-",
            " ",
        ];
        for unit in degrees {
            assert_eq!(right_unit("ra", unit), None, "{unit}");
        }
        let others = [
            "rad",
            "arcsec",
            "arcmin",
            "mas",
            "hourangle",
            "h",
            "mdeg",
            "rad (J2000)",
            "\"",
            "dex",
        ];
        for unit in others {
            assert_eq!(right_unit("glat", unit), Some("degrees"), "{unit}");
        }
        for (unit, right) in [
            ("rad", None),
            ("Radians", None),
            ("", None),
            ("deg", Some("radians")),
            ("mrad", Some("radians")),
            ("arcmin", Some("radians")),
        ] {
            assert_eq!(right_unit("theta", unit), right, "{unit}");
        }
        assert_eq!(right_unit("w", "kg"), None);
        assert_eq!(right_unit("x", "mm"), None);
    }
}
