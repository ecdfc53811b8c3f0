//! Valid and invalid texts in the Wavefront OBJ format.

use glam::DVec3;
use sphvar_scene::{Error, Mesh, Scene};

fn read(text: &str) -> Result<Mesh, Error> {
    Mesh::from_obj(text.as_bytes())
}

/// A unit square and a pentagon above it, with all other elements of the format.
const GOOD: &str = "\
# a comment
mtllib none.mtl
o first
v 0 0 0
v 1 0 0 # with a comment
v 1 1 0
  v 0 1 0
vt 0 0
vn 0 0 1
usemtl none
s off
f 1/1/1 2//1 3/1 4
g second
v 0 0 2 2
v 1 0 1 0.5 0.5 0.5
v 1.5 1 1
v .5 1.5e0 1
v -0.5 1 1
f -5/7/9 -4 -3 -2 -1
l 1 2
p 3
";

#[test]
fn polygons_negative_indices_and_no_normals() {
    let mesh = read(GOOD).expect("a mesh");
    assert_eq!(mesh.n_triangles(), 2 + 3);
    assert_eq!(mesh.triangle(0), [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0)]);
    // The fourth number of a vertex divides the others.
    assert_eq!(mesh.triangle(2)[0], DVec3::Z);
    let scene = Scene::from_mesh(mesh);
    let hit = scene.closest_hit(DVec3::new(0.6, 0.7, 3.0), DVec3::NEG_Z).expect("the pentagon");
    assert!((hit.distance - 2.0).abs() < 1e-15, "{hit:?}");
    assert!(hit.normal.distance(DVec3::Z) < 4.0 * f64::EPSILON, "{hit:?}");
    let windows = GOOD.replace('\n', "\r\n");
    assert_eq!(read(&windows).expect("a mesh").n_triangles(), 5);
}

#[test]
fn errors_name_the_line() {
    let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
    for (rest, wrong) in [
        ("f 1 2 5\n", 5),
        ("f 1 2 3\nf 1 2 0\n", 6),
        ("f 1 2 -5\n", 5),
        ("\n\nf -1 -2 -3\nf a b c\n", 8),
        ("f 1 2 3.5\n", 5),
        ("f\n", 5),
        ("f 1 2 3\nf 99999999999999999999 1 2\n", 6),
        ("f 1 2 -9223372036854775808\n", 5),
        ("v nan 0 0\nf 1 2 5\n", 5),
        ("v 0 inf 0\nf 1 2 5\n", 5),
        ("v 0 0 1e300\nf 1 2 5\n", 5),
        ("v nan 0 0\nf 1 2 3\n", 5),
        ("f 1 2 3\nv 0 -inf 0\n", 6),
        ("f 1 2 3\nv 0 0 1e101\n", 6),
        ("v 0 0\nf 1 2 3\n", 5),
        ("v 0 0 zero\nf 1 2 3\n", 5),
        ("v 0 0 0 0\nf 1 2 3\n", 5),
        ("v 1 2 3 4 5\nf 1 2 3\n", 5),
        ("# no face\n\n", 6),
        ("f 1 2\nl 1 2 3\n", 6),
    ] {
        match read(&format!("{square}{rest}")) {
            Err(Error::ObjLine { line, .. }) => assert_eq!(line, wrong, "{rest:?}"),
            other => panic!("{rest:?}: {other:?}"),
        }
    }
    assert!(matches!(read(""), Err(Error::ObjLine { line: 1, .. })));
    assert!(matches!(read(&format!("{square}f 1 2 2\n")), Err(Error::NoTriangles { n_faces: 1 })));
    let no_text = [b"v 0 0 0\nv 1 0 0\n".as_slice(), &[0xff, 0xfe], b"v\nf 1 2 3\n"].concat();
    assert!(matches!(Mesh::from_obj(&*no_text), Err(Error::ObjLine { line: 3, .. })));
}

#[test]
fn messages_describe_valid_input() {
    let error = read("v 0 0 0\nf 1 2 3\n").expect_err("no such vertices").to_string();
    assert_eq!(error, "line 2: `f 1 2 3`: expected indices up to 1, the number of vertices");
    // Positive indices may refer to later vertices, so those of the whole text count; negative ones
    // may not.
    let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    let error =
        read(&format!("{vertices}f 3/9/9 2 5 1\nv 1 1 0\n")).expect_err("no fifth").to_string();
    assert!(error.ends_with("expected indices up to 4, the number of vertices"), "{error}");
    let error =
        read(&format!("{vertices}f -1 -3 -4\nv 1 1 0\n")).expect_err("no fourth").to_string();
    let expected = "line 4: `f -1 -3 -4`: expected indices that go back no further than the first of the 3 \
                    vertices so far";
    assert_eq!(error, expected);
}

/// UTF-16 and UTF-32, which editors call Unicode, in either byte order, with and without a byte
/// order mark.
#[test]
fn wide_encodings_are_named() {
    let units: Vec<u16> = "# a\nv 0 0 0\nf 1 1 1\n".encode_utf16().collect();
    let bytes = |big: bool, wide: bool, mark: bool| -> Vec<u8> {
        let units = [0xfeff].into_iter().filter(|_| mark).chain(units.iter().copied());
        let bytes = units.flat_map(|unit| {
            let zeros = if wide { vec![0, 0] } else { vec![] };
            let [high, low] = unit.to_be_bytes();
            if big { [zeros, vec![high, low]].concat() } else { [vec![low, high], zeros].concat() }
        });
        bytes.collect()
    };
    for (big, mark) in [(false, false), (false, true), (true, false), (true, true)] {
        for (wide, name) in [(false, "UTF-16"), (true, "UTF-32")] {
            let error = Mesh::from_obj(&*bytes(big, wide, mark)).expect_err("another encoding");
            assert_eq!(error, Error::ObjEncoding { encoding: name }, "{big} {mark}");
            let message = error.to_string();
            assert!(message.contains(&format!("iconv -f {name} -t UTF-8")), "{message}");
        }
    }
}

#[test]
fn a_mesh_needs_its_vertices() {
    let vertices = vec![DVec3::ZERO, DVec3::X, DVec3::NAN];
    let wrong = Mesh::new(vertices.clone(), vec![[0, 1, 2]]);
    assert!(matches!(wrong, Err(Error::Vertex { vertex: 2, .. })), "{wrong:?}");
    let wrong = Mesh::new(vertices, vec![[0, 1, 3]]);
    assert!(
        matches!(wrong, Err(Error::FaceIndex { face: 0, vertex: 3, n_vertices: 3 })),
        "{wrong:?}"
    );
    assert!(matches!(Mesh::new(vec![], vec![]), Err(Error::NoTriangles { n_faces: 0 })));
}

/// Variants that the format allows and programs write: every text is the unit square.
#[test]
fn spellings_of_a_square() {
    let square = read("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n").expect("a mesh");
    for text in [
        b"\xef\xbb\xbfv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 5\nf 1 2 3 4\n".as_slice(),
        b"v 0 0 0\rv 1 0 0\rv 1 1 0\rv 0 1 0\rf 1 2 3 4",
        b"v 0 0 0\r\nv\t1 0 0\r\nv 1 1 0 \r\nv 0 1 0\r\nfo 1 2 3 4\r\n",
        b"v 0 0 0\nv 1 0 \\\n0\nv 1 1 0\nv 0 1 0\nf 1 2 \\\r\n 3 4\n",
        b"# caf\xe9\no caf\xe9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4 # \xff\n",
        b"# C:\\\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n",
        b"v 0 0 0 .5 .5 .5\nv 1 0 0 .5 .5 .5 1\nv 2 2 0 2\nv 0 1 0\nf 1 2 3 4\n",
        b"f 1 2 3 4\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n",
        b"v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4/1/1 2//7 3/4 -1/-1/-1\n",
    ] {
        let mesh = Mesh::from_obj(text).expect("a mesh");
        assert_eq!(mesh.n_triangles(), 2, "{:?}", String::from_utf8_lossy(text));
        for i in 0..2 {
            assert_eq!(mesh.triangle(i), square.triangle(i), "{:?}", String::from_utf8_lossy(text));
        }
    }
}

#[test]
fn unused_statements_are_reported() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 1\nvt 0 0\nV 0 0 0\nfoo\nfoo\nl 1 2\n\
                f 1 2 3\nf 3 1 2\nf 1 2\nf 1 2 2\n";
    let (mesh, remarks) = Mesh::from_obj_with_remarks(text.as_bytes()).expect("a mesh");
    assert_eq!((mesh.n_triangles(), remarks.unknown()), (1, 3));
    let expected = "ignored: vertex normals (2), texture coordinates (1), points and lines (1)\n\
                    unknown keywords, skipped: `V` (1), `foo` (2)\n\
                    faces of fewer than three corners, left out: 1\n\
                    triangles without area or given before, left out: 2";
    assert_eq!(remarks.to_string(), expected);
    let (_, remarks) = Mesh::from_obj_with_remarks(GOOD.as_bytes()).expect("a mesh");
    assert_eq!(remarks.unknown(), 0);
    // A second byte order mark.
    let wrong = b"\xef\xbb\xbf\xef\xbb\xbfv 0 0 0\n".as_slice();
    assert!(matches!(Mesh::from_obj(wrong), Err(Error::ObjLine { line: 1, .. })));
}

/// Areas add up to that of the polygon, and all triangles have its orientation.
fn check_triangles(polygon: &[DVec3], order: &[usize]) {
    let mut text = String::new();
    for p in polygon {
        text += &format!("v {:e} {:e} {:e}\n", p.x, p.y, p.z);
    }
    let corners: Vec<String> = order.iter().map(|i| (i + 1).to_string()).collect();
    let text = format!("{text}f {}\n", corners.join(" "));
    let (mesh, remarks) = Mesh::from_obj_with_remarks(text.as_bytes()).expect("a mesh");
    assert_eq!(remarks.crossed_faces, 0, "{text}");
    let places = order.iter().map(|&i| polygon[i]).collect::<Vec<_>>();
    let sides = places.iter().zip(places.iter().cycle().skip(1));
    let area: DVec3 = sides.map(|(a, b)| 0.5 * a.cross(*b)).sum();
    let areas = (0..mesh.n_triangles()).map(|i| {
        let [a, b, c] = mesh.triangle(i);
        0.5 * (b - a).cross(c - a)
    });
    let areas = areas.collect::<Vec<_>>();
    let sum: f64 = areas.iter().map(|a| a.dot(area.normalize())).sum();
    assert!((sum / area.length() - 1.0).abs() < 1e-12, "{sum}, not {}: {text}", area.length());
    assert!(areas.iter().all(|a| a.dot(area) > 0.0), "{text}");
}

#[test]
fn concave_polygons_keep_their_area() {
    // An arrowhead, from each corner and in both orientations; a comb; a spiral; a star that is not
    // quite plane.
    let arrowhead = [(0.0, 0.0), (1.0, -1.0), (0.0, 1.0), (-1.0, -1.0)];
    let comb = (0..40u8).map(|i| (f64::from(i), [0.0, 9.0][usize::from(i % 2)]));
    let comb = comb.chain([(39.0, 10.0), (0.0, 10.0)]).collect::<Vec<_>>();
    let turn = |i: i32, r: f64| {
        let t = 0.3 * f64::from(i);
        ((r + t) * t.cos(), (r + t) * t.sin())
    };
    let spiral = (0..60).map(|i| turn(i, 2.0)).chain((0..60).rev().map(|i| turn(i, 1.0)));
    let spiral = spiral.collect::<Vec<_>>();
    let star = (0..20u8).map(|i| {
        let (r, t) = ([1.0, 0.3][usize::from(i % 2)], std::f64::consts::TAU * f64::from(i) / 20.0);
        (r * t.cos(), r * t.sin())
    });
    let star = star.collect::<Vec<_>>();
    for flat in [&arrowhead[..], &comb, &spiral, &star] {
        for axis in 0..3 {
            let place = |(i, &(x, y)): (usize, &(f64, f64))| {
                let bend = if flat.len() == 20 { 1e-3 * (i % 3) as f64 } else { 0.0 };
                let [x, y, z] = [x, y, 0.25 * x + 0.5 * y + bend];
                DVec3::from_array([[x, y, z], [y, z, x], [z, x, y]][axis])
            };
            let polygon = flat.iter().enumerate().map(place).collect::<Vec<_>>();
            for start in 0..polygon.len().min(7) {
                let mut order = (0..polygon.len()).collect::<Vec<_>>();
                order.rotate_left(start);
                check_triangles(&polygon, &order);
                order.reverse();
                check_triangles(&polygon, &order);
            }
        }
    }
    let (mesh, remarks) =
        Mesh::from_obj_with_remarks(b"v 0 0 0\nv 1 1 0\nv 1 0 0\nv 0 1 0\nf 1 2 3 4\n".as_slice())
            .expect("crossing sides make overlapping triangles");
    assert_eq!((mesh.n_triangles(), remarks.crossed_faces), (2, 1));
}

/// Corners on a straight side are retained, so that a neighbour that has them too leaves no gap.
#[test]
fn corners_on_a_side_are_retained() {
    let text = "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 3 0 0\nv 3 3 0\nv 0 3 0\nf 1 2 3 4 5 6\n";
    let mesh = read(text).expect("a mesh");
    assert_eq!(mesh.n_triangles(), 4);
    assert!((0..4).any(|i| mesh.triangle(i).contains(&DVec3::X)));
}
