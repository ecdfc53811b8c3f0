use glam::DVec3;

/// The content of a panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Content {
    /// Series over a common axis.
    Curves(Curves),
    /// A set of directions.
    Directions(Directions),
    /// Points of the unit square.
    SquarePoints(SquarePoints),
    /// Values on a grid, as colours.
    Field(Field),
    /// A picture of a scene.
    Picture(Picture),
}

/// An axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Quantity and unit.
    pub label: String,
    /// Whether it is logarithmic.
    pub logarithmic: bool,
    /// The first and last displayed value; `None` for all values, as for logarithmic axes.
    pub range: Option<(f64, f64)>,
}

impl Axis {
    /// Returns a linear axis over all values.
    pub(crate) fn linear(label: &str) -> Self {
        Self { label: label.to_owned(), logarithmic: false, range: None }
    }

    /// Returns a logarithmic axis over all values.
    pub(crate) fn log(label: &str) -> Self {
        Self { label: label.to_owned(), logarithmic: true, range: None }
    }

    /// Returns the same axis from `low` to `high`.
    pub(crate) fn over(self, low: f64, high: f64) -> Self {
        Self { range: Some((low, high)), ..self }
    }
}

/// Series over a common axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// The horizontal axis.
    pub x: Axis,
    /// The vertical axis.
    pub y: Axis,
    /// The series, the later drawn over the earlier.
    pub curves: Vec<Curve>,
}

/// One series.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Its entry in the legend, and its name in the data.
    pub label: String,
    /// x, y and the standard error of y (0 if it is exact).
    pub points: Vec<[f64; 3]>,
    /// The drawing style.
    pub mark: Mark,
    /// Series with the same number have the same colour: measured and predicted values of one
    /// pattern.
    pub colour: usize,
}

impl Curve {
    /// Returns a line through exact values.
    pub(crate) fn line(
        label: impl Into<String>,
        colour: usize,
        points: impl IntoIterator<Item = (f64, f64)>,
    ) -> Self {
        let points = points.into_iter().map(|(x, y)| [x, y, 0.0]).collect();
        Self { label: label.into(), points, mark: Mark::Line, colour }
    }

    /// Returns a series of values with standard errors.
    pub(crate) fn new(
        label: impl Into<String>,
        colour: usize,
        mark: Mark,
        points: impl IntoIterator<Item = [f64; 3]>,
    ) -> Self {
        Self { label: label.into(), points: points.into_iter().collect(), mark, colour }
    }
}

/// The drawing style of a series.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mark {
    /// A line; errors as a band.
    Line,
    /// Markers; errors as bars.
    Markers,
}

/// A set of directions, viewed from a distance.
#[derive(Clone, Debug, PartialEq)]
pub struct Directions {
    /// Unit vectors.
    pub points: Vec<DVec3>,
    /// The viewing direction; any nonzero vector.
    pub viewpoint: DVec3,
    /// Lines on the sphere that belong to the pattern, such as the borders of its strata, each
    /// through unit vectors.
    pub lines: Vec<Vec<DVec3>>,
}

/// Points of the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct SquarePoints {
    /// Points [u, v], each coordinate in [0, 1).
    pub points: Vec<[f64; 2]>,
}

/// Values on a grid, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Columns and rows.
    pub size: [usize; 2],
    /// The values; NaN for empty cells.
    pub values: Vec<f64>,
    /// The quantity, for the scale of colours.
    pub label: String,
    /// The colours.
    pub palette: Palette,
    /// The horizontal quantity, with the values at the left and right edges.
    pub x: Axis,
    /// The vertical quantity, with the values at the top and bottom edges.
    pub y: Axis,
    /// Centres of rings around cells of interest, in values of `x` and `y`.
    pub rings: Vec<[f64; 2]>,
}

/// The mapping from values to colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Palette {
    /// From 0 (dark) to the largest value.
    Heat,
    /// Black for 0 to white for the largest value.
    Grey,
    /// From minus the largest magnitude over white at 0 to the largest magnitude.
    Signed,
}

/// A picture of a scene, with its error if it is not the reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns and rows.
    pub size: [usize; 2],
    /// Linear grey, 1 is white, row by row from the top.
    pub values: Vec<f64>,
    /// A line below it: its number of directions and its mean squared error.
    pub caption: String,
}

impl From<Curves> for Content {
    fn from(curves: Curves) -> Self {
        Self::Curves(curves)
    }
}

impl From<Directions> for Content {
    fn from(directions: Directions) -> Self {
        Self::Directions(directions)
    }
}

impl From<SquarePoints> for Content {
    fn from(points: SquarePoints) -> Self {
        Self::SquarePoints(points)
    }
}

impl From<Field> for Content {
    fn from(field: Field) -> Self {
        Self::Field(field)
    }
}

impl From<Picture> for Content {
    fn from(picture: Picture) -> Self {
        Self::Picture(picture)
    }
}
