//! Suggests values of `--columns` for a file whose columns do not determine the direction.

use std::collections::HashMap;

use super::ReadOptions;
use super::column::Column;
use super::space::Space;

/// The maximum number of suggestions that a message lists.
const LISTED: usize = 3;
/// Prefixes of names that denote a role, besides the role itself.
const STEMS: [(&str, &str); 9] = [
    ("ra", "alphawin"),
    ("ra", "alphapeak"),
    ("ra", "alpha"),
    ("dec", "deltawin"),
    ("dec", "deltapeak"),
    ("dec", "delta"),
    ("dec", "de"),
    ("lon", "longitude"),
    ("lat", "latitude"),
];
/// Suffixes of names in catalogues: the equinox or the unit.
const ENDINGS: [&str; 7] = ["", "j2000", "b1950", "icrs", "deg", "deg2000", "sky"];

/// Returns the values of `--columns` that form a point from the columns, the most likely first.
/// Values that a shell takes only with more than quotes are left out. With `values`, the columns of
/// values and of their standard errors belong to the points.
pub(super) fn suggestions(columns: &[Column], space: Space, values: bool) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    for system in space.systems() {
        // Names that differ in the role only belong together, as TARGET_RA and TARGET_DEC do.
        let mut families: Vec<Vec<Option<usize>>> = Vec::new();
        let mut numbers: HashMap<String, usize> = HashMap::new();
        for (index, column) in columns.iter().enumerate().filter(|(_, column)| column.items == 1) {
            for (slot, role) in system.iter().enumerate() {
                let Some(family) = family(&column.name, role) else { continue };
                let at = *numbers.entry(family).or_insert_with(|| {
                    families.push(vec![None; system.len()]);
                    families.len() - 1
                });
                families[at][slot].get_or_insert(index);
            }
        }
        for members in families {
            let names = members.iter().map(|index| Some(columns[(*index)?].name.trim()));
            if let Some(names) = names.collect::<Option<Vec<_>>>() {
                let pairs = system.iter().zip(names).map(|(role, name)| pair(role, name));
                found.push(pairs.collect::<Vec<_>>().join(","));
            }
        }
    }
    // Vectors in one column.
    let roles = space.default_roles();
    for column in columns.iter().filter(|column| column.items == roles.len()) {
        let name = column.name.trim();
        let pairs = roles.iter().enumerate();
        let pairs = pairs.map(|(i, role)| pair(role, &format!("{name}[{i}]")));
        found.push(pairs.collect::<Vec<_>>().join(","));
    }
    // Most catalogues mean right ascension and declination; x and y may be positions on a detector.
    found.sort_by_key(|flag| !flag.starts_with("ra="));
    let others: &[&str] = if values { &["value", "w", "sigma"] } else { &["w", "set"] };
    let others: String = others
        .iter()
        .filter_map(|role| {
            let mut named =
                columns.iter().filter(|c| space.role_of(&c.name) == Some(*role) && c.items == 1);
            let single = named.next().filter(|_| named.next().is_none());
            single.map(|column| format!(",{}", pair(role, column.name.trim())))
        })
        .collect();
    found.truncate(LISTED);
    found
        .iter()
        .map(|value| format!("{value}{others}"))
        .filter(|value| is_quotable(value))
        .collect()
}

/// Returns the suggestions as words of a message, or an empty text if there are none.
pub(super) fn suggested(columns: &[Column], options: &ReadOptions) -> String {
    let suggestions = suggestions(columns, options.space, options.values);
    let columns: Vec<String> =
        suggestions.iter().map(|value| options.spelling.columns(value)).collect();
    columns.join(" or ")
}

/// Returns a name without the part that denotes a role, or `None` if it has no such part.
fn family(name: &str, role: &str) -> Option<String> {
    let name = name.trim().to_lowercase();
    let stems = STEMS.iter().filter(|(other, _)| *other == role).map(|(_, stem)| *stem);
    let stems: Vec<&str> = std::iter::once(role).chain(stems).collect();
    let is_end = |c: char| !c.is_alphanumeric();
    let mut start = 0;
    for token in name.split(is_end) {
        for stem in &stems {
            let ending = token.strip_prefix(stem).filter(|ending| ENDINGS.contains(ending));
            if let Some(ending) = ending {
                let after = &name[start + token.len()..];
                return Some(format!("{}*{ending}{after}", &name[..start]));
            }
        }
        start += token.len() + name[start + token.len()..].chars().next().map_or(0, char::len_utf8);
    }
    None
}

/// Returns `ROLE=NAME`, with quotes if the name needs them.
fn pair(role: &str, name: &str) -> String {
    if name.contains([',', '"']) {
        format!("{role}=\"{}\"", name.replace('"', "\"\""))
    } else {
        format!("{role}={name}")
    }
}

/// Returns whether quotes make a text a word of a shell.
fn is_quotable(text: &str) -> bool {
    !text.contains(['\'', '!']) && !text.contains(char::is_control)
}

#[cfg(test)]
mod tests {
    use super::{Column, Space, suggestions};

    #[test]
    fn flags_fit_the_columns() {
        let cases: [(&[&str], &[&str]); 13] = [
            (&["id", "TARGET_RA", "TARGET_DEC", "Z"], &["ra=TARGET_RA,dec=TARGET_DEC"]),
            (
                &["dec_1", "ra_1", "ra_2", "dec_2", "Weight"],
                &["ra=ra_1,dec=dec_1,w=Weight", "ra=ra_2,dec=dec_2,w=Weight"],
            ),
            (
                &["_RAJ2000", "_DEJ2000", "RA_ICRS", "DE_ICRS"],
                &["ra=_RAJ2000,dec=_DEJ2000", "ra=RA_ICRS,dec=DE_ICRS"],
            ),
            (
                &["ALPHAWIN_SKY", "DELTAWIN_SKY", "x", "y", "z"],
                &["ra=ALPHAWIN_SKY,dec=DELTAWIN_SKY", "x=x,y=y,z=z"],
            ),
            (&["sky.ra", "sky.dec", "w", "weights"], &["ra=sky.ra,dec=sky.dec"]),
            (&["ecl_lon", "ecl_lat", "set"], &["lon=ecl_lon,lat=ecl_lat,set=set"]),
            (&["RA (deg)", "Dec (deg)"], &["ra=RA (deg),dec=Dec (deg)"]),
            (&["ra, J2000", "dec, J2000"], &["ra=\"ra, J2000\",dec=\"dec, J2000\""]),
            (&["RA", "DEC", "X", "Y", "Z"], &["ra=RA,dec=DEC", "x=X,y=Y,z=Z"]),
            (&["pos_x", "pos_y", "vel_z"], &[]),
            (&["radius", "decay", "delay"], &[]),
            (&["ra'", "dec'"], &[]),
            (&["", "\u{e9}", "_", "__ra"], &[]),
        ];
        for (names, flags) in cases {
            let columns: Vec<Column> = names.iter().map(|name| Column::single(*name)).collect();
            assert_eq!(suggestions(&columns, Space::Sphere, false), flags, "{names:?}");
        }
        let names = ["TARGET_RA", "TARGET_DEC", "value", "sigma", "set"];
        let columns = names.map(Column::single);
        let with_values = "ra=TARGET_RA,dec=TARGET_DEC,value=value,sigma=sigma";
        assert_eq!(suggestions(&columns, Space::Sphere, true), [with_values]);
        let vectors = Column { name: "coord".to_owned(), items: 3, unit: String::new() };
        assert_eq!(
            suggestions(&[vectors], Space::Sphere, false),
            ["x=coord[0],y=coord[1],z=coord[2]"]
        );
    }
}
