use glam::DVec3;
use sphvar_healpix::{Nested, PixelOrder, Ring};

use super::definition::Definition;
use crate::{Errors, Subject};

/// A pixel numbering that the definition implements too.
pub(super) trait Numbering: PixelOrder + Copy + 'static {
    /// The name of the order.
    const NAME: &'static str;

    /// Returns the number of a pixel by definition.
    fn defined(definition: Definition) -> i128;
}

impl Numbering for Ring {
    const NAME: &'static str = "ring";

    fn defined(definition: Definition) -> i128 {
        definition.ring_number()
    }
}

impl Numbering for Nested {
    const NAME: &'static str = "nested";

    fn defined(definition: Definition) -> i128 {
        definition.nested_number()
    }
}

/// Returns the pixel with this number, or `None` if the definition gives it another number.
///
/// The definition assigns different numbers to different cells, so one number identifies the cell.
pub(super) fn definition_of<O: Numbering>(order: O, pixel: u64) -> Option<Definition> {
    let definition = Definition::of(order.cell(pixel));
    (O::defined(definition) == i128::from(pixel)).then_some(definition)
}

/// Returns 0 for a correct result and infinity for a wrong one.
pub(super) fn exact(right: bool) -> f64 {
    if right { 0.0 } else { f64::INFINITY }
}

/// Computes the pixels of directions.
pub(super) fn pixel<O: Numbering>(order: O, directions: Vec<DVec3>) -> Box<dyn Subject> {
    Box::new(Calls {
        inputs: directions,
        name: |dir| format!("direction {:?}", dir.to_array()),
        out: Vec::new(),
        run: each(move |dir: DVec3| order.pixel(dir)),
        error: move |dir, pixel| {
            definition_of(order, pixel).map_or(f64::INFINITY, |own| own.excess(dir))
        },
    })
}

/// Computes the pixels of directions in one call.
pub(super) fn pixels<O: Numbering>(order: O, directions: Vec<DVec3>) -> Box<dyn Subject> {
    Box::new(Calls {
        inputs: directions,
        name: |dir| format!("direction {:?}", dir.to_array()),
        out: Vec::new(),
        run: move |dirs: &[DVec3], out: &mut Vec<u64>| {
            out.resize(dirs.len(), 0);
            order.pixels_into(dirs, out);
        },
        error: move |dir, pixel| {
            definition_of(order, pixel).map_or(f64::INFINITY, |own| own.excess(dir))
        },
    })
}

/// Computes the centres of pixels.
pub(super) fn centre<O: Numbering>(order: O, pixels: Vec<u64>) -> Box<dyn Subject> {
    Box::new(Calls {
        inputs: pixels,
        name: |pixel| format!("pixel {pixel}"),
        out: Vec::new(),
        run: each(move |pixel| order.centre(pixel)),
        error: move |pixel, dir| {
            definition_of(order, pixel).map_or(f64::INFINITY, |own| own.distance_from_centre(dir))
        },
    })
}

/// Computes the pixels of centres, which must be the pixels of which they are the centres.
pub(super) fn return_trip<O: Numbering>(order: O, pixels: Vec<u64>) -> Box<dyn Subject> {
    Box::new(Calls {
        inputs: pixels.into_iter().map(|pixel| (pixel, order.centre(pixel))).collect(),
        name: |(pixel, _)| format!("pixel {pixel}"),
        out: Vec::new(),
        run: each(move |(_, centre): (u64, DVec3)| order.pixel(centre)),
        error: |(pixel, _), found| exact(pixel == found),
    })
}

/// Computes the ring numbers of nested ones.
pub(super) fn renumbering(nested: Nested, pixels: Vec<u64>) -> Box<dyn Subject> {
    Box::new(Calls {
        inputs: pixels,
        name: |pixel| format!("pixel {pixel}"),
        out: Vec::new(),
        run: each(move |pixel| nested.to_ring(pixel)),
        error: move |pixel, ring| {
            let defined = definition_of(nested, pixel).map(Definition::ring_number);
            exact(defined == Some(i128::from(ring)) && nested.from_ring(ring) == pixel)
        },
    })
}

/// Returns a function that calls another one for each input.
fn each<I: Copy, T>(call: impl Fn(I) -> T + Send) -> impl Fn(&[I], &mut Vec<T>) + Send {
    move |inputs, out| {
        out.clear();
        out.extend(inputs.iter().map(|&input| call(input)));
    }
}

/// A map of many inputs with the error of each output.
struct Calls<I, T, F, E> {
    inputs: Vec<I>,
    name: fn(I) -> String,
    out: Vec<T>,
    run: F,
    error: E,
}

impl<I, T, F, E> Subject for Calls<I, T, F, E>
where
    I: Copy + Send,
    T: Copy + Send,
    F: Fn(&[I], &mut Vec<T>) + Send,
    E: Fn(I, T) -> f64 + Send,
{
    fn run(&mut self) {
        (self.run)(&self.inputs, &mut self.out);
    }

    fn errors(&mut self) -> Errors {
        let mut errors = Errors::default();
        errors.push_length(self.out.len(), self.inputs.len());
        for (&input, &got) in self.inputs.iter().zip(&self.out) {
            errors.push((self.error)(input, got), || (self.name)(input));
        }
        errors
    }
}
