//! Figures are complete, well formed and robust for any data.

use std::fs;

use glam::DVec3;

use super::figure::svg;
use super::orthographic_view::Sight;
use super::square_view::SquarePoints;
use super::{
    Chart, ImageFormat, Ink, OrthographicView, Panel, Scale, Series, Spread, SquareView, Style,
};

const STYLES: [Style; 4] = [Style::Line, Style::Markers, Style::Joined, Style::Dashed];
/// The first four colours in the notation of SVG.
const COLOURS: [&str; 4] = ["#0072B2", "#D55E00", "#009E73", "#D65CE8"];

fn chart(series: Vec<Series>, scale: Scale) -> Chart {
    Chart {
        title: "power <P> & \"error\"".to_owned(),
        x_label: "omega".to_owned(),
        x_scale: scale,
        panels: vec![Panel { y_scale: scale, ..Panel::log("P'", series) }],
        notes: vec!["seed 0\u{1}".to_owned()],
    }
}

fn series(index: usize, points: Vec<(f64, f64)>) -> Series {
    let spread = Spread::Errors(points.iter().map(|&(_, y)| 0.3 * y.abs()).collect());
    Series {
        label: format!("series-{index}"),
        points,
        spread,
        style: STYLES[index % STYLES.len()],
        ink: Ink::Rank(index),
    }
}

/// Returns the chart as SVG.
fn drawn(chart: &Chart) -> String {
    svg(&chart.layout(Chart::WIDTH).unwrap()).unwrap()
}

/// Returns the number of polylines of a colour in a document.
fn polylines(document: &str, colour: &str) -> usize {
    document.lines().filter(|l| l.starts_with("<polyline") && l.contains(colour)).count()
}

/// Checks the subset of XML that these documents use; returns the name of every element.
fn elements(document: &str) -> Vec<String> {
    let mut open: Vec<String> = Vec::new();
    let mut seen = Vec::new();
    let mut rest = document;
    while let Some(start) = rest.find('<') {
        let text = &rest[..start];
        assert!(!text.contains('>') && !text.contains('"'), "unescaped text {text:?}");
        for reference in text.split('&').skip(1) {
            let end = reference.find(';').unwrap_or(0);
            assert!(["lt", "gt", "amp", "quot", "apos"].contains(&&reference[..end]), "{text:?}");
        }
        assert!(
            !text.chars().any(|c| c.is_control() && c != '\n'),
            "control character in {text:?}"
        );
        let tag_end = start + rest[start..].find('>').expect("an open tag");
        let tag = &rest[start + 1..tag_end];
        rest = &rest[tag_end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop().as_deref(), Some(name), "closed in the wrong order");
            continue;
        }
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of {tag}");
        let name = tag.split([' ', '/']).next().unwrap_or_default().to_owned();
        if !tag.ends_with('/') {
            open.push(name.clone());
        }
        seen.push(name);
    }
    assert!(open.is_empty(), "left open: {open:?}");
    assert!(rest.trim().is_empty(), "after the end: {rest:?}");
    seen
}

#[test]
fn svg_is_well_formed_and_complete() {
    let data =
        |k: usize| (1..20).map(|i| (f64::from(i), f64::from(i).powi(2) + k as f64)).collect();
    let document = drawn(&chart((0..4).map(|k| series(k, data(k))).collect(), Scale::Log));
    let names = elements(&document);
    assert_eq!(names[0], "svg");
    assert!(document.starts_with("<svg width=\"960\" height=\""), "{}", &document[..80]);
    assert!(document.contains("viewBox=\"0 0 9600 "));
    for text in ["power &lt;P&gt; &amp; &quot;error&quot;", "omega", "P&apos;", "seed 0", "10²"] {
        assert!(document.contains(text), "{text} is missing");
    }
    assert!(document.contains(", sans-serif\""), "no generic family");
    for (k, colour) in COLOURS.iter().enumerate() {
        assert!(
            document.contains(&format!("\nseries-{k}\n")),
            "the label of series {k} is missing"
        );
        let drawn = document.lines().filter(|line| line.contains(colour)).count();
        // The series and its name.
        assert!(drawn >= 2, "series {k} in {colour}: {drawn} elements");
    }
}

#[test]
fn png_has_the_size_and_the_colours() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("chart.PNG");
    let points = vec![(1.0, 1.0), (2.0, 4.0), (3.0, 9.0)];
    chart(vec![series(0, points)], Scale::Linear).render(&path).unwrap();
    let image = image::load_from_memory(&fs::read(&path).unwrap()).unwrap().into_rgb8();
    assert_eq!(image.width(), 1920, "two pixels to a unit");
    assert_eq!(image.get_pixel(0, 0).0, [255; 3]);
    assert!(image.pixels().any(|pixel| pixel.0 == [0x00, 0x72, 0xb2]), "the line is missing");
    let dark = image.pixels().filter(|pixel| pixel.0.iter().all(|&c| c < 0x60)).count();
    assert!(dark > 1000, "no letters: {dark} dark pixels");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "a temporary was left behind");
}

#[test]
fn log_axis_skips_what_has_no_logarithm() {
    let good = vec![(1.0, 10.0), (10.0, 1.0), (100.0, 5.0), (1000.0, 20.0)];
    let mut bad = good.clone();
    bad.insert(0, (0.0, 3.0));
    bad.insert(1, (-2.0, 3.0));
    bad.push((50.0, 0.0));
    bad.push((f64::NAN, 1.0));
    bad.push((70.0, f64::INFINITY));
    let document = |points| {
        let one = Series { spread: Spread::None, label: String::new(), ..series(0, points) };
        drawn(&chart(vec![one], Scale::Log))
    };
    assert_eq!(document(good), document(bad), "points without a logarithm changed the drawing");

    // In the middle, such a point splits the line: a line across the gap would suggest data.
    let broken = document(vec![(1.0, 1.0), (2.0, 2.0), (3.0, 0.0), (4.0, 2.0), (5.0, 1.0)]);
    assert_eq!(polylines(&broken, COLOURS[0]), 2, "two parts");
}

#[test]
fn odd_data_draw_without_panic() {
    let extremes = [0.0, -1.0, 1.0, 5e-324, 1e300, f64::MAX, f64::NAN, f64::INFINITY];
    let wild: Vec<_> = extremes.iter().flat_map(|&x| extremes.map(|y| (x, y))).collect();
    let long = "a label that goes on and on until it has to be broken and then goes on".repeat(3);
    let cases: Vec<Vec<Series>> = vec![
        vec![],
        vec![series(0, vec![])],
        STYLES.iter().enumerate().map(|(k, _)| series(k, vec![])).collect(),
        (0..4).map(|k| series(k, vec![(3.0, 4.0)])).collect(),
        (0..4).map(|k| series(k, vec![(3.0, 4.0), (3.0, 4.0)])).collect(),
        (0..4).map(|k| series(k, wild.clone())).collect(),
        (0..40).map(|k| series(k, vec![(1.0, 1.0), (2.0, k as f64)])).collect(),
        vec![Series { label: long, ..series(1, vec![(1.0, 2.0)]) }],
        vec![Series {
            spread: Spread::Errors(vec![f64::NAN, -1.0]),
            ..series(2, vec![(1.0, 1.0); 3])
        }],
        vec![Series { label: String::new(), ..series(3, vec![(1.0, 1.0), (2.0, 5.0)]) }],
    ];
    for (index, case) in cases.into_iter().enumerate() {
        for scale in [Scale::Linear, Scale::Log] {
            let names = elements(&drawn(&chart(case.clone(), scale)));
            assert!(names.len() > 10, "case {index} drew only {names:?}");
        }
    }
    let bare = Chart {
        title: String::new(),
        x_label: String::new(),
        notes: vec![],
        panels: vec![],
        ..chart(vec![], Scale::Linear)
    };
    elements(&drawn(&bare));
}

#[test]
fn view_shows_the_near_side_only() {
    let view = OrthographicView { viewpoint: DVec3::Z, ..OrthographicView::default() };
    let circles = |points: &[DVec3]| {
        let document = svg(&Sight { view: &view, directions: points }).unwrap();
        elements(&document).iter().filter(|name| *name == "circle").count()
    };
    assert_eq!(circles(&[DVec3::Z, DVec3::NEG_Z, DVec3::X, DVec3::Y]), 3);
    assert_eq!(circles(&[]), 0);
    assert_eq!(circles(&[DVec3::NAN, DVec3::INFINITY]), 0);

    // Seen from +z, x points right and y up.
    let document = svg(&Sight { view: &view, directions: &[DVec3::X] }).unwrap();
    let circle = document.lines().find(|line| line.starts_with("<circle")).unwrap();
    let number = |name: &str| {
        let from = circle.find(&format!(" {name}=\"")).unwrap() + name.len() + 3;
        circle[from..].split('"').next().unwrap().parse::<f64>().unwrap()
    };
    assert!(number("cx") > 8000.0, "{circle}");
    assert!((number("cy") - 4500.0).abs() < 100.0, "{circle}");
}

#[test]
fn any_viewpoint_draws() {
    let points = [DVec3::X, DVec3::NEG_Y, DVec3::Z];
    for viewpoint in [DVec3::ZERO, DVec3::NAN, DVec3::NEG_Z, DVec3::splat(1e200), DVec3::Y] {
        let view = OrthographicView { viewpoint, ..OrthographicView::default() };
        elements(&svg(&Sight { view: &view, directions: &points }).unwrap());
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("view.png");
    OrthographicView::default().render(&points, &path).unwrap();
    let image = image::open(&path).unwrap();
    assert_eq!((image.width(), image.height()), OrthographicView::SIZE);
}

#[test]
fn unknown_extension_is_named() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["chart.pdf", "chart"] {
        let path = folder.path().join(name);
        assert_eq!(ImageFormat::of_path(&path), None);
        let message = chart(vec![], Scale::Log).render(&path).unwrap_err().to_string();
        assert!(message.contains("expected a name that ends in .svg or .png"), "{message}");
        assert!(message.contains(name), "{message}");
    }
    let message = chart(vec![], Scale::Log).render(&folder.path().join("no/c.svg")).unwrap_err();
    assert!(message.to_string().contains("create it first"), "{message}");
}

#[test]
fn points_of_the_square_are_where_they_should_be() {
    let view = SquareView { title: "<title>".to_owned(), notes: vec!["seed 0".to_owned()] };
    let points = [[0.0, 0.0], [0.999, 0.0], [0.0, 0.999], [f64::NAN, 0.5]];
    let document = svg(&SquarePoints { view: &view, points: &points }).unwrap();
    elements(&document);
    assert!(document.contains("&lt;title&gt;") && document.contains("seed 0"));
    let circles = document.lines().filter(|line| line.starts_with("<circle"));
    let at = |line: &str, key: &str| -> f64 {
        let value = line.split(&format!("{key}=\"")).nth(1).unwrap();
        value.split('"').next().unwrap().parse().unwrap()
    };
    let places: Vec<_> = circles.map(|line| (at(line, "cx"), at(line, "cy"))).collect();
    let [origin, right, up] = places[..] else { panic!("{places:?}") };
    assert!(right.0 > origin.0 + 1000.0 && (right.1 - origin.1).abs() <= 0.0, "{places:?}");
    assert!((up.0 - origin.0).abs() <= 0.0 && up.1 < origin.1 - 1000.0, "{places:?}");
}
