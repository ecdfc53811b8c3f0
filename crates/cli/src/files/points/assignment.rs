//! The assignment of roles to the columns of a file: by their names, by their positions, or by the
//! option `--columns`.

use super::columns::{Assigned, Table};
use super::space::Space;
use super::suggestion::suggested;
use crate::files::file_error::FileError;
use crate::files::text_rows::shortened;

impl Table<'_> {
    /// Rejects a value of `--columns` that forms a point of another space.
    pub(super) fn check_choice(&self) -> Result<(), FileError> {
        let Some(choice) = &self.options.columns else { return Ok(()) };
        let (roles, space) = (choice.roles(), self.options.space);
        let is_of = |space: Space| {
            space.systems().iter().any(|system| system.iter().all(|role| roles.contains(role)))
        };
        if is_of(space) {
            return Ok(());
        }
        let option = self.options.spelling.name("columns");
        let remedy = match space {
            Space::Sphere => "points of the unit square are read with --square",
            Space::Square => "directions are read without --square",
        };
        Err(self.error(
            format!("{option} with {}", space.systems_in_words()),
            format!("{}; {remedy}", roles.join(",")),
        ))
    }

    /// Returns the roles that the column names imply.
    pub(super) fn by_header(&self) -> Result<Vec<Assigned>, FileError> {
        let spelling = self.options.spelling;
        let mut assigned: Vec<Assigned> = Vec::new();
        for (index, column) in self.columns.iter().enumerate() {
            let Some(role) = self.role_of(&column.name) else { continue };
            if let Some(&(_, other, _)) = assigned.iter().find(|(taken, ..)| *taken == role) {
                let got = format!("{} and {}", self.name(other), self.name(index));
                let expected = format!("the column {role} once");
                let advice = match suggested(self.columns, self.options) {
                    flags if flags.is_empty() || role == "w" || role == "set" => {
                        let chosen = spelling.columns(&format!("{role}=NAME,..."));
                        format!("{chosen} chooses by name")
                    }
                    flags => format!("use {flags}"),
                };
                return Err(self.error(expected, format!("{got}; {advice}")));
            }
            assigned.push((role, index, None));
        }
        Ok(assigned)
    }

    /// Returns the roles of columns without names.
    pub(super) fn without_names(&self) -> Result<Vec<Assigned>, FileError> {
        let count = self.columns.len();
        let (space, values) = (self.options.space, self.options.values);
        let roles = space.default_roles();
        if count == roles.len() || (values && (roles.len()..=roles.len() + 2).contains(&count)) {
            let roles = roles.iter().chain(&["value", "w"]).take(count).zip(0..);
            return Ok(roles.map(|(role, i)| (*role, i, None)).collect());
        }
        let spelling = self.options.spelling;
        let skipping = |roles: &str| format!("{} (_ skips a field)", spelling.columns(roles));
        let example = match (space, count) {
            (Space::Sphere, _) if values => skipping("x,y,z,value,_,_"),
            (Space::Sphere, 2) => {
                format!("{} or {}", spelling.columns("theta,phi"), spelling.columns("lon,lat"))
            }
            (Space::Sphere, 4) => spelling.columns("x,y,z,w"),
            (Space::Sphere, _) => skipping("x,y,z,_,_"),
            (Space::Square, 3) => spelling.columns("u,v,w"),
            (Space::Square, _) => skipping("u,v,_,_"),
        };
        let option = spelling.name("columns");
        let noun = if count == 1 { "field" } else { "fields" };
        let known = match space {
            Space::Sphere if values => "4 fields (x y z value), 5 (x y z value w)",
            Space::Sphere => "3 fields (x y z)",
            Space::Square => "2 fields (u v)",
        };
        let directions = match (space, count) {
            (Space::Square, 3) => "; directions x y z are read without --square",
            _ => "",
        };
        Err(self.error(
            format!("{known}, or a header, or names by the option {option} such as {example}"),
            format!("{count} {noun} without a header{directions}"),
        ))
    }

    /// Returns the roles that `--columns` gives to columns from left to right.
    ///
    /// If the file has names that imply all these roles, the names take precedence over the order,
    /// unless a `_` shows that the order is meant.
    pub(super) fn by_position(
        &self,
        roles: &[Option<&'static str>],
    ) -> Result<Vec<Assigned>, FileError> {
        let spelling = self.options.spelling;
        if self.has_names && roles.iter().all(Option::is_some) {
            let of_role = |role: &&'static str| {
                let mut found =
                    (0..).zip(self.columns).filter(|(_, c)| self.role_of(&c.name) == Some(*role));
                let (index, _) = found.next()?;
                found.next().is_none().then_some((*role, index, None))
            };
            let by_name: Option<Vec<Assigned>> = roles.iter().flatten().map(of_role).collect();
            if let Some(by_name) = by_name {
                return Ok(by_name);
            }
        }
        let count = self.columns.len();
        if roles.len() > count || (!self.has_names && roles.len() < count) {
            let written: Vec<&str> = roles.iter().map(|role| role.unwrap_or("_")).collect();
            return Err(self.error(
                format!("{} fields for {}", roles.len(), spelling.columns(&written.join(","))),
                count.to_string(),
            ));
        }
        let named: Vec<&'static str> =
            self.columns.iter().filter_map(|column| self.role_of(&column.name)).collect();
        let complete = self.systems().iter().filter(|s| s.iter().all(|role| named.contains(role)));
        let coordinates: Vec<&str> = complete.copied().flatten().copied().collect();
        let mut assigned = Vec::new();
        for (index, role) in roles.iter().enumerate() {
            let Some(role) = *role else { continue };
            let own = self.role_of(&self.columns[index].name);
            // A column with a contradicting name in the file is more likely to be an oversight.
            if own.is_some_and(|own| own != role && coordinates.contains(&own)) {
                let name = self.name(index);
                return Err(self.error(
                    format!("the column {role} named in {}", spelling.name("columns")),
                    format!("the header {}; use {role}={name} to read {name}", self.names()),
                ));
            }
            assigned.push((role, index, None));
        }
        Ok(assigned)
    }

    /// Returns the roles that `--columns` assigns to names.
    pub(super) fn by_name(
        &self,
        names: &[(&'static str, String)],
    ) -> Result<Vec<Assigned>, FileError> {
        let spelling = self.options.spelling;
        let option = spelling.name("columns");
        if !self.has_names {
            let roles = match self.options.values {
                true => "ra,dec,value",
                false => self.options.space.weighted_example(),
            };
            let by_position = spelling.columns(roles);
            return Err(self.error(
                format!(
                    "a header with the names of {option} (without one: {by_position} by position)"
                ),
                "none".to_owned(),
            ));
        }
        names
            .iter()
            .map(|(role, name)| {
                if let Some(column) = self.find(name)? {
                    return Ok((*role, column, None));
                }
                let indexed = name.strip_suffix(']').and_then(|n| n.rsplit_once('['));
                if let Some((name, item)) = indexed
                    && let Ok(item) = item.trim().parse()
                    && let Some(column) = self.find(name)?
                {
                    return Ok((*role, column, Some(item)));
                }
                let expected = format!("the column {} of {option}", shortened(name));
                Err(self.error(expected, format!("the columns {}", self.names())))
            })
            .collect()
    }

    /// Returns the column of a name: an exact match, or else a match in any case.
    fn find(&self, name: &str) -> Result<Option<usize>, FileError> {
        let matching = |equal: &dyn Fn(&str) -> bool| {
            let columns = self.columns.iter().enumerate();
            columns.filter(|(_, c)| equal(c.name.trim())).map(|(i, _)| i).collect::<Vec<_>>()
        };
        let mut found = matching(&|other| other == name);
        if found.is_empty() {
            found = matching(&|other| other.eq_ignore_ascii_case(name));
        }
        match found[..] {
            [] => Ok(None),
            [column] => Ok(Some(column)),
            _ => {
                let expected = format!("one column {}", shortened(name));
                let got = format!("{} of them; choose by position", found.len());
                Err(self.error(expected, got))
            }
        }
    }
}
