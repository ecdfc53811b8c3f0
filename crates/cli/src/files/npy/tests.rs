use std::io::Cursor;

use npyz::WriterBuilder;

use super::{Array, ItemType, NpyReader, write_npy};
use crate::files::FileError;

fn read(bytes: &[u8]) -> Result<(ItemType, Array), FileError> {
    let reader = NpyReader::new(Cursor::new(bytes), "A")?;
    let item = reader.item_type().expect("an array of numbers");
    Ok((item, reader.read_items(item)?))
}

/// `npyz` writes the items `0, 1, ...` in the requested order and reports their positions.
#[test]
fn rows_are_those_of_another_library() {
    let shapes: [&[u64]; 7] = [&[5, 3], &[1, 3], &[0, 3], &[2, 4, 3], &[7, 1, 3], &[2, 0, 3], &[3]];
    for shape in shapes {
        for order in [npyz::Order::C, npyz::Order::Fortran] {
            let count = shape.iter().product::<u64>();
            let mut file = Vec::new();
            let mut writer = npyz::WriteOptions::<f64>::new()
                .default_dtype()
                .shape(shape)
                .order(order)
                .writer(&mut file)
                .begin_nd()
                .unwrap();
            writer.extend((0..count).map(|n| n as f64)).unwrap();
            writer.finish().unwrap();
            let oracle = npyz::NpyFile::new(file.as_slice()).unwrap();
            let strides = oracle.strides().to_vec();
            // Every index in C order; the value of the item is its position in the file.
            let mut expected = vec![0];
            for (&dimension, &stride) in shape.iter().zip(&strides) {
                expected = expected
                    .iter()
                    .flat_map(|place| (0..dimension).map(move |i| place + i * stride))
                    .collect();
            }
            let expected: Vec<f64> = expected.into_iter().map(|place| place as f64).collect();
            let (item, array) = read(&file).unwrap();
            let found: Vec<f64> =
                array.rows::<3>().flatten().map(|bits| item.float(bits)).collect();
            assert_eq!(found, expected, "{shape:?} {order:?}");
            let singles: Vec<f64> = array.rows::<1>().map(|[bits]| item.float(bits)).collect();
            assert_eq!(singles, expected, "{shape:?} {order:?} one by one");
            assert!(!array.bytes_follow, "{shape:?} {order:?}");
        }
    }
}

#[test]
fn written_arrays_come_back_and_end_where_they_should() {
    let numbers: Vec<i64> = (-6..6).collect();
    let mut file = Vec::new();
    write_npy(&mut file, "<i8", &[2, 6], numbers.iter().copied()).unwrap();
    let (item, array) = read(&file).unwrap();
    let found: Vec<i128> = array.rows::<6>().flatten().map(|bits| item.integer(bits)).collect();
    assert_eq!(found, (-6..6).collect::<Vec<i128>>());
    for length in 0..file.len() {
        let message = match read(&file[..length]) {
            Ok(_) => panic!("an array of {length} bytes of {}", file.len()),
            Err(error) => error.to_string(),
        };
        assert!(message.starts_with("A: truncated"), "{length} bytes: {message}");
        assert!(message.contains(&format!("got {length} (")), "{length} bytes: {message}");
    }
    file.push(0);
    assert!(read(&file).unwrap().1.bytes_follow);
}
