use std::collections::BTreeMap;
use std::fmt;

/// The contents of an OBJ text other than the triangles of the mesh.
///
/// It is displayed with one line per kind; without remarks the text is empty.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ObjRemarks {
    /// The number of faces whose sides cross in the projection along the largest component of their
    /// area vector; their triangles overlap.
    pub crossed_faces: usize,
    /// The number of faces with one or two corners, which are left out.
    pub small_faces: usize,
    /// The number of triangles without area and repeated triangles, which are left out.
    pub left_out_triangles: usize,
    /// The number of occurrences of each ignored keyword, except those of structure (`o`, `g`,
    /// `s`).
    pub ignored: BTreeMap<String, usize>,
}

/// Keywords that only structure a text.
const STRUCTURE: [&str; 4] = ["o", "g", "s", "mg"];

/// Ignored keywords and their meaning.
const KNOWN: [(&str, &[&str]); 5] = [
    ("vertex normals", &["vn"]),
    ("texture coordinates", &["vt"]),
    ("points and lines", &["p", "l"]),
    ("materials", &["mtllib", "usemtl", "usemap", "maplib"]),
    (
        "free-form curves and surfaces",
        &[
            "vp", "cstype", "deg", "bmat", "step", "curv", "curv2", "surf", "parm", "trim", "hole",
            "scrv", "sp", "end", "con",
        ],
    ),
];

/// The maximum number of unknown keywords in a remark, and their maximum length.
const MAX_NAMED: usize = 5;
const MAX_KEYWORD: usize = 20;

impl ObjRemarks {
    /// Counts an ignored keyword.
    pub(crate) fn count(&mut self, keyword: &str) {
        if STRUCTURE.contains(&keyword) {
            return;
        }
        match self.ignored.get_mut(keyword) {
            Some(count) => *count += 1,
            None => {
                self.ignored.insert(keyword.to_owned(), 1);
            }
        }
    }

    /// Returns the number of statements with unknown keywords.
    #[must_use]
    pub fn unknown(&self) -> usize {
        self.unknown_keywords().map(|(_, count)| count).sum()
    }

    fn unknown_keywords(&self) -> impl Iterator<Item = (&str, usize)> {
        let all = self.ignored.iter().map(|(keyword, &count)| (keyword.as_str(), count));
        all.filter(|(keyword, _)| !KNOWN.iter().any(|(_, keywords)| keywords.contains(keyword)))
    }
}

impl fmt::Display for ObjRemarks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut parts = Vec::new();
        let known = KNOWN.iter().filter_map(|(what, keywords)| {
            let count: usize = keywords.iter().filter_map(|&k| self.ignored.get(k)).sum();
            (count > 0).then(|| format!("{what} ({count})"))
        });
        let known = known.collect::<Vec<_>>();
        if !known.is_empty() {
            parts.push(format!("ignored: {}", known.join(", ")));
        }
        let unknown = self.unknown_keywords().map(|(keyword, count)| {
            let shown: String = keyword.chars().take(MAX_KEYWORD).collect();
            let rest = if shown.len() < keyword.len() { "..." } else { "" };
            format!("`{shown}{rest}` ({count})")
        });
        let unknown = unknown.collect::<Vec<_>>();
        if !unknown.is_empty() {
            let more = unknown.len().saturating_sub(MAX_NAMED);
            let more = if more > 0 { format!(" and {more} others") } else { String::new() };
            let named = unknown[..unknown.len().min(MAX_NAMED)].join(", ");
            parts.push(format!("unknown keywords, skipped: {named}{more}"));
        }
        for (count, what) in [
            (self.crossed_faces, "faces with crossing sides, whose triangles overlap"),
            (self.small_faces, "faces of fewer than three corners, left out"),
            (self.left_out_triangles, "triangles without area or given before, left out"),
        ] {
            if count > 0 {
                parts.push(format!("{what}: {count}"));
            }
        }
        f.write_str(&parts.join("\n"))
    }
}
