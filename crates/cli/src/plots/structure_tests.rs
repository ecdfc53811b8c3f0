//! Names and labels never overlap, colours are few, and every value has a position, for any data.

use std::collections::BTreeSet;

use proptest::prelude::*;

use super::figure::svg;
use super::palette::COLOURS;
use super::plane::Frame;
use super::{Chart, Ink, Panel, Scale, Series, Spread, Style};

/// Returns a chart of curves, each with its own rank, with a lower panel.
fn chart(curves: Vec<(String, Vec<(f64, f64)>)>, x_scale: Scale, y_scale: Scale) -> Chart {
    let series = |(rank, (label, points)): (usize, (String, Vec<(f64, f64)>))| Series {
        label,
        spread: Spread::Errors(points.iter().map(|p| 0.2 * p.1.abs()).collect()),
        points,
        style: [Style::Line, Style::Joined, Style::Markers, Style::Dashed][rank % 4],
        ink: Ink::Rank(rank),
    };
    let series: Vec<Series> = curves.into_iter().enumerate().map(series).collect();
    let lower = series.iter().map(|s| Series { label: String::new(), ..s.clone() }).collect();
    let lower = Panel { reference: Some(1.0), side_by_side: true, ..Panel::log("ratio", lower) };
    Chart {
        title: "Variance of integrating cap:degrees=60".to_owned(),
        x_label: "number of points N".to_owned(),
        x_scale,
        panels: vec![Panel { y_scale, ..Panel::log("variance of the estimate", series) }, lower],
        notes: vec!["sphvar variance (sphvar 0.1.0, seed 0)".to_owned()],
    }
}

fn overlap(a: Frame, b: Frame) -> bool {
    const SLACK: f64 = 1e-6;
    let along = |a: (f64, f64), b: (f64, f64)| a.0 + SLACK < b.1 && b.0 + SLACK < a.1;
    along((a.left, a.right), (b.left, b.right)) && along((a.top, a.bottom), (b.top, b.bottom))
}

fn label() -> impl Strategy<Value = String> {
    const NAMES: [&str; 4] =
        ["jittered", "healpix", "ccvt:capacity=64,mass=white", "file:/a/b/points.npy"];
    prop_oneof![
        4 => prop::sample::select(&NAMES[..]).prop_map(str::to_owned),
        1 => "[a-z]{1,12}:[a-z]{1,9}=[0-9]{1,12},[a-z]{1,40}=[a-z/]{0,60}",
        1 => Just(String::new()),
    ]
}

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        8 => (-30.0..3.0_f64).prop_map(|exponent| 10.0_f64.powf(exponent)),
        1 => Just(0.0),
        1 => Just(f64::NAN),
        1 => Just(1.0),
    ]
}

fn curve() -> impl Strategy<Value = (String, Vec<(f64, f64)>)> {
    let points = prop::collection::vec((1_u32..5000, value()), 0..7);
    (label(), points).prop_map(|(label, mut points)| {
        points.sort_by_key(|point| point.0);
        (label, points.into_iter().map(|(n, y)| (f64::from(n), y)).collect())
    })
}

fn scale() -> impl Strategy<Value = Scale> {
    prop_oneof![Just(Scale::Linear), Just(Scale::Log)]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, ..ProptestConfig::default() })]

    #[test]
    fn no_text_touches_another(
        curves in prop::collection::vec(curve(), 0..50),
        width in 420.0..1600.0_f64,
        x_scale in scale(),
        y_scale in scale(),
    ) {
        let chart = chart(curves, x_scale, y_scale);
        let layout = chart.layout(width).unwrap();
        for (i, a) in layout.texts.iter().enumerate() {
            let bounds = a.bounds();
            prop_assert!(bounds.left >= -0.5 && bounds.right <= layout.size.0 + 0.5, "{}", a.text);
            prop_assert!(bounds.top >= -0.5 && bounds.bottom <= layout.size.1 + 0.5, "{}", a.text);
            for b in &layout.texts[i + 1..] {
                prop_assert!(!overlap(bounds, b.bounds()), "{:?} and {:?}", a.text, b.text);
            }
        }
        // No text lies on the data either.
        for panel in &layout.panels {
            for text in &layout.texts {
                prop_assert!(!overlap(panel.plane.frame, text.bounds()), "{:?}", text.text);
            }
        }
    }

    #[test]
    fn names_are_there_once(curves in prop::collection::vec(curve(), 1..40)) {
        let n_names = curves.iter().filter(|curve| !curve.0.is_empty()).count();
        let chart = chart(curves, Scale::Log, Scale::Log);
        let layout = chart.layout(Chart::WIDTH).unwrap();
        // There are leaders or samples, never both.
        prop_assert!(layout.leaders.is_empty() || layout.samples.is_empty());
        prop_assert!(layout.leaders.len() + layout.samples.len() <= n_names);
        if layout.leaders.is_empty() && !layout.samples.is_empty() {
            prop_assert_eq!(layout.samples.len(), n_names);
        }
    }
}

#[test]
fn seven_colours_at_most() {
    let line = |k: u32| (1..9).map(|n| (f64::from(n), f64::from(n * (k + 1)))).collect();
    for n_curves in [1, 2, 7, 8, 17, 60] {
        let curves = (0..n_curves).map(|k| (format!("curve {k}"), line(k))).collect();
        let chart = chart(curves, Scale::Log, Scale::Log);
        let document = svg(&chart.layout(Chart::WIDTH).unwrap()).unwrap();
        let quoted = document.split('"').filter(|text| text.len() == 7 && text.starts_with('#'));
        let is_grey = |c: &str| c[1..3] == c[3..5] && c[3..5] == c[5..7];
        let colours: BTreeSet<&str> = quoted.filter(|colour| !is_grey(colour)).collect();
        assert_eq!(colours.len(), COLOURS.len().min(n_curves as usize), "{colours:?}");
    }
}

#[test]
fn coinciding_lines_are_dashed() {
    let line: Vec<_> = (1..9).map(|n| (f64::from(n), f64::from(n))).collect();
    let other = line.iter().map(|&(x, y)| (x, 1e-3 * y)).collect();
    let mut chart = chart(
        vec![("a".to_owned(), line.clone()), ("b".to_owned(), line), ("c".to_owned(), other)],
        Scale::Log,
        Scale::Log,
    );
    chart.panels[0].series.iter_mut().for_each(|series| series.style = Style::Line);
    let layout = chart.layout(Chart::WIDTH).unwrap();
    let dashed: Vec<bool> =
        layout.panels[0].looks.iter().map(|look| !look.pattern.is_empty()).collect();
    assert_eq!(dashed, [false, true, false]);
}

#[test]
fn markers_are_side_by_side_within_the_frame() {
    let points = vec![(48.0, 1.0), (108.0, 1.1), (3072.0, 0.9)];
    for n_curves in [1, 2, 7, 40] {
        let curves = vec![("curve".to_owned(), points.clone()); n_curves];
        let mut chart = chart(curves, Scale::Log, Scale::Log);
        chart.panels[1].series.iter_mut().for_each(|series| series.style = Style::Markers);
        let layout = chart.layout(Chart::WIDTH).unwrap();
        let panel = &layout.panels[1];
        let mut last = f64::NEG_INFINITY;
        for look in &panel.looks {
            assert!(look.shift > last, "{n_curves} curves");
            last = look.shift;
            for &point in &look.series.points {
                let x = panel.plane.place(point).unwrap().0 + look.shift;
                assert!((panel.plane.frame.left..=panel.plane.frame.right).contains(&x));
            }
        }
    }
}

#[test]
fn bands_and_bars_stay_in_the_frame() {
    let points = vec![(1.0, 1.0), (2.0, 2.0)];
    for spread in [Spread::Errors(vec![1e9, 5.0]), Spread::Ranges(vec![(0.0, 3.0), (1e-40, 1e9)])] {
        for scale in [Scale::Linear, Scale::Log] {
            let mut chart = chart(vec![("a".to_owned(), points.clone())], Scale::Log, scale);
            chart.panels[0].series[0].spread = spread.clone();
            let layout = chart.layout(Chart::WIDTH).unwrap();
            let plane = &layout.panels[0].plane;
            for placed in plane.unbroken_runs(&chart.panels[0].series[0]).iter().flatten() {
                let (low, high) = placed.ends.unwrap();
                let (top, y, bottom) = (plane.frame.top, placed.at.1, plane.frame.bottom);
                let order = [top - 1e-9, high, y, low, bottom + 1e-9];
                assert!(order.is_sorted(), "{order:?}");
            }
        }
    }
}
