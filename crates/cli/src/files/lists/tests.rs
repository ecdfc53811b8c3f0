use std::fs;
use std::io::Cursor;

use super::{Columns, Fault, ListWriter, Number, read_list, read_stream};

const PIXEL: Columns<1> = Columns { names: ["pixel"], remark: "integers" };
const ANGLES: Columns<2> = Columns { names: ["theta", "phi"], remark: "radians" };
const VECTOR: Columns<3> = Columns { names: ["x", "y", "z"], remark: "vectors" };

fn read<T: Number, const N: usize>(
    bytes: impl AsRef<[u8]>,
    columns: &Columns<N>,
) -> Result<Vec<[T; N]>, String> {
    read_stream(Cursor::new(bytes.as_ref()), "LIST", false, columns, Ok).map_err(|e| e.to_string())
}

#[test]
fn text_has_many_forms() {
    let expected = vec![[1.0, 2.0], [3.0, -4e-5]];
    for text in [
        "1,2\n3,-4e-5\n",
        "1 2\n3 -4e-5",
        "  1\t2  \r\n\r\n3\t\t-4e-5\r\n",
        "# theta phi\n1, 2\n# between\n3 , -4e-5\n#",
        "theta,phi\n1,2\n3,-4e-5\n",
        "\u{feff}Theta, PHI\n1,2\n3,-4e-5\n",
        "\"theta\",\"phi\"\n1,2\n3,-4e-5\n",
        "phi theta\n2 1\n-4e-5 3\n",
        "id,phi,name,theta\n0,2,a,1\n1,-4e-5,,3\n",
    ] {
        assert_eq!(read::<f64, 2>(text, &ANGLES).as_ref(), Ok(&expected), "{text:?}");
    }
    for text in ["7\n+8\n-0\n", "pixel\n7\n8\n0\n", "pixel,value\n7,0.5\n8,x\n0,\n"] {
        assert_eq!(read::<i128, 1>(text, &PIXEL), Ok(vec![[7], [8], [0]]), "{text:?}");
    }
    assert_eq!(read::<i128, 1>("pixel", &PIXEL), Ok(vec![]));
}

#[test]
fn wrong_text_is_named() {
    for (text, message) in [
        ("1 2\n3\n", "LIST:2: expected 2 fields, got 1"),
        ("1,2\n3,4,\n", "LIST:2: expected 2 fields, got 3"),
        ("1 2\n3,4\n", "LIST:2: expected 2 fields, got 1"),
        ("1 2\n3 x\n", "LIST:2: phi: expected a finite number, got \"x\""),
        ("1,2\n,4\n", "LIST:2: theta: expected a finite number, got \"\""),
        ("1e999 2\n", "LIST:1: theta: expected a finite number, got \"1e999\""),
        (
            "1 2 3\n",
            "LIST:1: expected the columns theta,phi (radians), or a header that names them, \
             got 3 fields without a header",
        ),
        (
            "7\n",
            "LIST:1: expected the columns theta,phi (radians), or a header that names them, \
             got 1 field without a header",
        ),
        ("a,phi\n", "LIST:1: expected the columns theta,phi (radians), got the header a,phi"),
        ("phi,theta,phi\n", "LIST:1: expected the column phi once, got the header phi,theta,phi"),
        (
            "",
            "LIST: expected rows of the columns theta,phi (radians), or at least a header, \
             got neither",
        ),
        (
            "# nothing\n\n",
            "LIST: expected rows of the columns theta,phi (radians), or at least a header, \
             got neither",
        ),
    ] {
        assert_eq!(read::<f64, 2>(text, &ANGLES), Err(message.to_owned()), "{text:?}");
    }
    let long = read::<i128, 1>(format!("1\n{}x\n", "y".repeat(1000)), &PIXEL).unwrap_err();
    assert!(long.ends_with("yyy...\"") && long.len() < 100, "{long}");
    let binary = read::<f64, 2>(b"1 2\n\xff\xfe\n", &ANGLES).unwrap_err();
    assert_eq!(
        binary,
        "LIST:2: expected text in UTF-8, or an NPY array, got other bytes; iconv -f LATIN1 -t UTF-8 converts Latin-1"
    );
}

#[test]
fn faults_name_the_column_or_the_row() {
    let rejection = |fault: fn() -> Fault, bytes: &[u8]| {
        read_stream(Cursor::new(bytes), "LIST", false, &ANGLES, |[x, _]: [f64; 2]| {
            if x > 2.0 { Err(fault()) } else { Ok(()) }
        })
        .unwrap_err()
        .to_string()
    };
    let column = || Fault::Column(1, "less".to_owned());
    let row = || Fault::Row("better".to_owned());
    let text = b"phi,theta\n0.10,2\n0.20,3.0\n";
    let array = npy("<f8", false, "(2, 2)", &doubles(&[2.0, 0.1, 3.0, 0.2]));
    assert_eq!(rejection(column, text), "LIST:3: phi: expected less, got \"0.20\"");
    assert_eq!(rejection(row, text), "LIST:3: theta,phi: expected better, got (3.0, 0.20)");
    assert_eq!(rejection(column, &array), "LIST[1]: phi: expected less, got 0.2");
    assert_eq!(rejection(row, &array), "LIST[1]: theta,phi: expected better, got (3, 0.2)");
}

/// Returns an NPY file as `NumPy` writes it, assembled by hand.
fn npy(descr: &str, fortran_order: bool, shape: &str, data: &[u8]) -> Vec<u8> {
    let order = if fortran_order { "True" } else { "False" };
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': {shape}, }}");
    while (10 + header.len() + 1) % 64 != 0 {
        header.push(' ');
    }
    header.push('\n');
    let length = u16::try_from(header.len()).unwrap().to_le_bytes();
    [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
}

fn doubles(numbers: &[f64]) -> Vec<u8> {
    numbers.iter().flat_map(|x| x.to_le_bytes()).collect()
}

#[test]
fn arrays_of_every_integer_type() {
    macro_rules! check {
        ($($type:ty, $letter:literal);*) => {$(
            let numbers: [$type; 4] = [<$type>::MIN, <$type>::MAX, 0, 77];
            let expected: Vec<[i128; 1]> = numbers.iter().map(|&n| [i128::from(n)]).collect();
            let little: Vec<u8> = numbers.iter().flat_map(|n| n.to_le_bytes()).collect();
            let big: Vec<u8> = numbers.iter().flat_map(|n| n.to_be_bytes()).collect();
            for shape in ["(4,)", "(4, 1)"] {
                for fortran in [false, true] {
                    let mut orders = vec![('<', &little), ('>', &big)];
                    if size_of::<$type>() == 1 {
                        orders.push(('|', &little));
                    }
                    for (order, data) in orders {
                        let descr = format!("{order}{}{}", $letter, size_of::<$type>());
                        let file = npy(&descr, fortran, shape, data);
                        let found = read::<i128, 1>(file, &PIXEL);
                        assert_eq!(found.as_ref(), Ok(&expected), "{descr} {shape} {fortran}");
                    }
                }
            }
        )*};
    }
    check!(i8, 'i'; i16, 'i'; i32, 'i'; i64, 'i'; u8, 'u'; u16, 'u'; u32, 'u'; u64, 'u');
}

#[test]
fn arrays_of_floats_in_both_orders() {
    let rows = [[1.5_f32, -2.0, 3.0], [4.0, 5e-30, 6.25]];
    let expected: Vec<[f64; 3]> = rows.iter().map(|row| row.map(f64::from)).collect();
    let by_row: Vec<f32> = rows.concat();
    let by_column: Vec<f32> = (0..3).flat_map(|c| rows.map(|row| row[c])).collect();
    for (fortran, numbers) in [(false, by_row), (true, by_column)] {
        let wide: Vec<f64> = numbers.iter().map(|&x| f64::from(x)).collect();
        for (descr, data) in [
            ("<f4", numbers.iter().flat_map(|x| x.to_le_bytes()).collect()),
            (">f4", numbers.iter().flat_map(|x| x.to_be_bytes()).collect()),
            ("<f8", doubles(&wide)),
            (">f8", wide.iter().flat_map(|x| x.to_be_bytes()).collect::<Vec<u8>>()),
        ] {
            let found = read::<f64, 3>(npy(descr, fortran, "(2, 3)", &data), &VECTOR);
            assert_eq!(found.as_ref(), Ok(&expected), "{descr} {fortran}");
        }
    }
    let empty = npy("<f8", false, "(0, 3)", &[]);
    assert_eq!(read::<f64, 3>(empty, &VECTOR), Ok(vec![]));
    for (bad, shown) in [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")] {
        let message = read::<f64, 2>(npy("<f8", false, "(1, 2)", &doubles(&[0.0, bad])), &ANGLES)
            .unwrap_err();
        assert_eq!(message, format!("LIST[0]: phi: expected a finite number, got {shown}"));
    }
}

#[test]
fn chunks_join_without_a_gap() {
    // More than two pieces, the last one not full.
    let n = 20_001_u64;
    let data: Vec<u8> = (0..n).flat_map(|i| (i << 40 | i).to_le_bytes()).collect();
    let found = read::<i128, 1>(npy("<u8", false, &format!("({n},)"), &data), &PIXEL).unwrap();
    assert_eq!(found.len(), 20_001);
    for (i, [number]) in (0..).zip(found) {
        assert_eq!(number, i << 40 | i, "{i}");
    }
}

#[test]
fn wrong_arrays_are_named() {
    let eight = [0_u8; 8];
    for (file, part) in [
        (npy("<f8", false, "(1,)", &eight), "expected integers, such as int64"),
        (npy("|b1", false, "(1,)", &[1]), "got the type |b1"),
        (npy("<i16", false, "(1,)", &eight), "got the type <i16"),
        (npy("|O", false, "(1,)", &eight), "got the type |O"),
        (npy("<i8", false, "()", &eight), "shape (N,) or (N, 1) with pixel, got the shape ()"),
        (npy("<i8", false, "(1, 2)", &eight), "got the shape (1, 2)"),
        (npy("<i8", false, "(1, 1, 1)", &eight), "got the shape (1, 1, 1)"),
        (npy("<i8", false, "(2,)", &eight), "truncated: expected 144 bytes, got 136"),
        (npy("<i8", false, "(0,)", &eight), "expected a single array, got more bytes after it"),
        (npy("<i8", false, "(18446744073709551615,)", &eight), "fits in memory"),
        (npy("<i8", false, "(1152921504606846976,)", &eight), "fits in memory"),
        (npy("<i8", false, "(1000000000000000,)", &eight), "truncated"),
        (npy("<i8", false, "(18446744073709551616,)", &eight), "an array of plain numbers"),
        (npy("<i8", false, "(-1,)", &eight), "an array of plain numbers"),
        (npy("<i8", false, "(1", &eight), "an array of plain numbers"),
        (npy("<i8', 'x': '", false, "1", &eight), "an array of plain numbers"),
        (b"\x93NUMPY\x04\x00\x10\x00".to_vec(), "got version 4"),
        (b"\x93NUMPY\x02\x00\xff\xff\xff\xff".to_vec(), "a header of at most 65536 bytes"),
        (b"\x93NUMB3R\x00".to_vec(), "the magic bytes of an NPY file"),
    ] {
        let message = read::<i128, 1>(&file, &PIXEL).unwrap_err();
        let shown = String::from_utf8_lossy(&file);
        assert!(message.starts_with("LIST:") && message.contains(part), "{shown}: {message}");
    }
    let ints = npy("<i8", false, "(1, 3)", &[0; 24]);
    let message = read::<f64, 3>(ints, &VECTOR).unwrap_err();
    assert_eq!(message, "LIST: expected numbers of type float64 or float32, got the type <i8");
    // Every truncated file is rejected and never misread.
    let whole = npy("<i8", false, "(2,)", &[0; 16]);
    for length in 1..whole.len() {
        let message = read::<i128, 1>(&whole[..length], &PIXEL).unwrap_err();
        assert!(message.contains("truncated"), "{length} bytes: {message}");
    }
}

#[test]
fn written_points_are_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let reals: Vec<[f64; 2]> =
        vec![[0.1, -0.0], [5e-324, f64::MAX], [1.0 / 3.0, 1e-7], [1e16, 123_456.789]];
    let pixels: Vec<[i64; 1]> = vec![[0], [(1 << 53) + 1], [3_458_764_513_820_540_927]];
    for extension in ["csv", "npy"] {
        let path = folder.path().join(format!("a.{extension}"));
        ListWriter::create(&path).unwrap().write(&ANGLES.names, &reals).unwrap();
        let found: Vec<[f64; 2]> = read_list(&path, &ANGLES, Ok).unwrap();
        let bits = |rows: &[[f64; 2]]| rows.iter().map(|r| r.map(f64::to_bits)).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(&reals), "{extension}");
        ListWriter::create(&path).unwrap().write(&PIXEL.names, &pixels).unwrap();
        let found: Vec<[i128; 1]> = read_list(&path, &PIXEL, Ok).unwrap();
        let expected: Vec<[i128; 1]> = pixels.iter().map(|p| p.map(i128::from)).collect();
        assert_eq!(found, expected, "{extension}");
    }
    let text = fs::read_to_string(folder.path().join("a.csv")).unwrap();
    assert_eq!(text, "pixel\n0\n9007199254740993\n3458764513820540927\n");
    // The bytes that readers of the format rely on, assembled by hand as above.
    let data: Vec<u8> = pixels.iter().flat_map(|p| p[0].to_le_bytes()).collect();
    let file = fs::read(folder.path().join("a.npy")).unwrap();
    assert!(file.ends_with(&data), "{file:?}");
    assert!(String::from_utf8_lossy(&file).contains("'shape': (3,"), "{file:?}");
}

#[test]
fn a_writer_rejects_before_the_work() {
    let folder = tempfile::tempdir().unwrap();
    for (name, part) in
        [("a.ply", ".csv, .npy"), ("a", ".csv, .npy"), ("no/a.csv", "does not exist")]
    {
        let message = ListWriter::create(&folder.path().join(name)).unwrap_err().to_string();
        assert!(message.contains(part), "{name}: {message}");
    }
    drop(ListWriter::create(&folder.path().join("a.csv")).unwrap());
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0, "a file without a list");
}
