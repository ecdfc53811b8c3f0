//! Texts in Wavefront's format, right and wrong.

use glam::DVec3;
use sphvar_scene::{Error, Mesh, Scene};

fn read(text: &str) -> Result<Mesh, Error> {
    Mesh::from_obj(text.as_bytes())
}

/// A unit square and a pentagon above it, with everything that the format has beside.
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
fn what_is_wrong_is_told_with_its_line() {
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
    let no_text = [b"v 0 0 0\nv 1 0 0\n# ".as_slice(), &[0xff, 0xfe], b"\nf 1 2 3\n"].concat();
    assert!(matches!(Mesh::from_obj(&*no_text), Err(Error::ObjLine { line: 3, .. })));
}

#[test]
fn messages_say_what_would_be_right() {
    let error = read("v 0 0 0\nf 1 2 3\n").expect_err("no such vertices").to_string();
    assert_eq!(error, "line 2: `f 1 2 3`: expected indices up to the number of vertices");
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
