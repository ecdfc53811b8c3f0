//! HEALPix pixels of arrays of directions, and back.

use std::array::from_fn;
use std::fmt::Display;

use numpy::{Element, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, PyUntypedArrayMethods};
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use rayon::prelude::*;
use sphvar::glam::DVec3;
use sphvar::healpix::{Nested, Nside, PixelOrder, Ring, unit_direction};
use sphvar_cli::embedding::{angles_of_degrees, degrees_of_angles, rounded_colatitude};

use crate::arrays::{
    check_copy, float_array, integer_array, of_shape, or_scalar, shape_error, shape_text, zeros,
};
use crate::errors::value_error;
use crate::work;

/// The number of elements that are converted together: few enough that buffers of this size cost a call
/// for one element little.
const BLOCK: usize = 512;

/// The number of blocks that a thread converts before others may take over, some 20 us.
const BLOCKS_OF_A_PART: usize = 8;

/// The number of elements up to which a conversion takes less than a millisecond.
const SMALL: usize = 16_384;

/// The number of blocks between two looks at signals, which take some 50 ms.
const BLOCKS_BETWEEN_LOOKS: usize = 16_384;

/// An element that cannot be converted, by its position in a block, and why.
struct Fault {
    at: usize,
    reason: String,
}

impl Fault {
    fn new(at: usize, reason: impl Display) -> Self {
        Self { at, reason: reason.to_string() }
    }
}

/// Arrays of one shape.
struct Columns<'py, T: Element, const I: usize> {
    shape: Vec<usize>,
    columns: [Column<'py, T>; I],
}

/// The elements of an array in C order.
enum Column<'py, T: Element> {
    Small(Vec<T>),
    /// A copy that nothing else refers to, so that no other thread writes to it.
    Large(PyReadonlyArrayDyn<'py, T>),
}

impl<T: Element> Column<'_, T> {
    fn elements(&self) -> PyResult<&[T]> {
        match self {
            Self::Small(elements) => Ok(elements),
            Self::Large(array) => Ok(array.as_slice()?),
        }
    }
}

impl<'py, T: Element + Copy, const I: usize> Columns<'py, T, I> {
    /// Broadcasts arrays to one shape.
    fn new(names: &str, arrays: [PyReadonlyArrayDyn<'py, T>; I]) -> PyResult<Self> {
        let shape = broadcast_shape(names, arrays.each_ref().map(|array| array.shape()))?;
        let len: usize = shape.iter().product();
        let mut columns = Vec::with_capacity(I);
        for array in arrays {
            columns.push(if len <= SMALL {
                let view = array.as_array();
                let all = view
                    .broadcast(&*shape)
                    .ok_or_else(|| shape_error(names, &shape_text(&shape), array.shape()))?;
                Column::Small(all.iter().copied().collect())
            } else {
                check_copy::<T>(names, len)?;
                let numpy = array.py().import("numpy")?;
                let shape = PyTuple::new(array.py(), &shape)?;
                let all = numpy.call_method1("broadcast_to", (&*array, shape))?;
                // In C order, and never the array of the caller.
                let copy = all.call_method1("copy", ("C",))?;
                Column::Large(copy.cast::<PyArrayDyn<T>>()?.try_readonly()?)
            });
        }
        let columns = columns.try_into().map_err(|_| value_error("arrays"))?;
        Ok(Self { shape, columns })
    }
}

/// Returns the shape to which shapes are broadcast by the rules of numpy.
fn broadcast_shape<const I: usize>(names: &str, shapes: [&[usize]; I]) -> PyResult<Vec<usize>> {
    let ndim = shapes.iter().map(|shape| shape.len()).max().unwrap_or(0);
    let mut all = vec![1; ndim];
    for shape in shapes {
        for (size, own) in all[ndim - shape.len()..].iter_mut().zip(shape) {
            match (*size, *own) {
                (a, b) if a == b => {}
                (1, b) => *size = b,
                (_, 1) => {}
                _ => {
                    let texts = shapes.map(shape_text).join(", ");
                    return Err(value_error(format!(
                        "{names}: the shapes {texts} cannot be broadcast to one shape"
                    )));
                }
            }
        }
    }
    Ok(all)
}

/// Returns the arrays of the elements that `kernel` writes, one block after the other.
fn convert<'py, A, B, const I: usize, const O: usize>(
    py: Python<'py>,
    function: &str,
    inputs: &Columns<'py, A, I>,
    kernel: impl Fn([&[A]; I], [&mut [B]; O]) -> Result<(), Fault> + Sync,
) -> PyResult<[Bound<'py, PyAny>; O]>
where
    A: Element + Copy + Sync,
    B: Element + Copy + Default + Send,
{
    let mut slices: [&[A]; I] = [&[]; I];
    for (slice, column) in slices.iter_mut().zip(&inputs.columns) {
        *slice = column.elements()?;
    }
    let len = slices[0].len();
    let mut outputs: [Vec<B>; O] = from_fn(|_| Vec::new());
    for output in &mut outputs {
        *output = zeros(len)?;
    }
    let mut blocks: Vec<[&mut [B]; O]> = Vec::with_capacity(len.div_ceil(BLOCK));
    let mut rests = outputs.each_mut().map(Vec::as_mut_slice);
    for _ in 0..len.div_ceil(BLOCK) {
        blocks.push(rests.each_mut().map(|rest| {
            let all = std::mem::take(rest);
            let (block, after) = all.split_at_mut(BLOCK.min(all.len()));
            *rest = after;
            block
        }));
    }
    let fault_of = |index: usize, block: &mut [&mut [B]; O]| {
        let start = index * BLOCK;
        let inputs = slices.map(|slice| &slice[start..(start + BLOCK).min(len)]);
        let outputs = block.each_mut().map(|output| &mut **output);
        kernel(inputs, outputs).err().map(|fault| Fault { at: start + fault.at, ..fault })
    };
    let mut fault = None;
    if len <= SMALL {
        for (index, block) in blocks.iter_mut().enumerate() {
            fault = fault.or_else(|| fault_of(index, block));
        }
    } else {
        for (i, part) in blocks.chunks_mut(BLOCKS_BETWEEN_LOOKS).enumerate() {
            let first = i * BLOCKS_BETWEEN_LOOKS;
            fault = work::scoped(py, || {
                part.par_iter_mut()
                    .enumerate()
                    .with_min_len(BLOCKS_OF_A_PART)
                    .find_map_first(|(index, block)| fault_of(first + index, block))
            })?;
            if fault.is_some() {
                break;
            }
        }
    }
    if let Some(Fault { at, reason }) = fault {
        let place = place(at, &inputs.shape);
        return Err(value_error(format!("{function}: {reason}{place}")));
    }
    let mut arrays = Vec::with_capacity(O);
    for output in outputs {
        arrays.push(or_scalar(of_shape(py, output, &inputs.shape)?)?);
    }
    arrays.try_into().map_err(|_| value_error("arrays"))
}

/// Returns where an element lies in an array, in words that follow a message.
fn place(mut at: usize, shape: &[usize]) -> String {
    match shape {
        [] => String::new(),
        [_] => format!(" (index {at})"),
        _ => {
            let mut index = vec![0; shape.len()];
            for (part, size) in index.iter_mut().zip(shape).rev() {
                (*part, at) = (at % size, at / size);
            }
            format!(" (index {})", shape_text(&index))
        }
    }
}

/// Returns the resolution, an integer from 1 to 2^29.
fn nside_of(nside: &Bound<'_, PyAny>) -> PyResult<Nside> {
    let index = nside.py().import("operator")?.call_method1("index", (nside,))?;
    let valid = index.extract::<u32>().ok().and_then(|nside| Nside::new(nside).ok());
    valid.ok_or_else(|| {
        let max = Nside::MAX;
        value_error(format!("nside {index} is out of range: it must be from 1 to {max}"))
    })
}

/// Calls `$call` with the numbering of pixels in ring or nested order, as `$order`.
macro_rules! with_order {
    ($nside:expr, $nest:expr, |$order:ident| $call:expr) => {{
        if $nest {
            let $order = Nested::new($nside).map_err(value_error)?;
            $call
        } else {
            let $order = Ring::new($nside);
            $call
        }
    }};
}

/// Returns a pixel as numpy has it: the largest, 12 * 2^58 - 1, is below 2^63.
fn written(pixels: &[u64], output: &mut [i64]) {
    for (to, from) in output.iter_mut().zip(pixels) {
        *to = from.cast_signed();
    }
}

fn checked(nside: Nside, pixels: &[i64], at: usize) -> Result<u64, Fault> {
    let pixel = pixels[at];
    let valid = u64::try_from(pixel).ok().and_then(|pixel| nside.check_pixel(pixel).ok());
    valid.ok_or_else(|| {
        let n_pixels = nside.n_pixels();
        Fault::new(
            at,
            format!(
                "pixel {pixel} is out of range: the grid has {n_pixels} pixels, numbered from 0"
            ),
        )
    })
}

#[pyfunction]
fn vec2pix<'py>(
    py: Python<'py>,
    nside: &Bound<'py, PyAny>,
    x: &Bound<'py, PyAny>,
    y: &Bound<'py, PyAny>,
    z: &Bound<'py, PyAny>,
    nest: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let nside = nside_of(nside)?;
    let arrays = [float_array("x", x)?, float_array("y", y)?, float_array("z", z)?];
    let columns = Columns::new("x, y, z", arrays)?;
    let [pixels] = with_order!(nside, nest, |order| {
        convert(py, "vec2pix", &columns, |[x, y, z], [output]| {
            let mut directions = [DVec3::ZERO; BLOCK];
            let mut pixels = [0; BLOCK];
            let n = x.len();
            for (at, ((x, y), z)) in x.iter().zip(y).zip(z).enumerate() {
                let vector = DVec3::new(*x, *y, *z);
                directions[at] = unit_direction(vector).map_err(|e| Fault::new(at, e))?;
            }
            order.pixels_into(&directions[..n], &mut pixels[..n]);
            written(&pixels[..n], output);
            Ok(())
        })
    })?;
    Ok(pixels)
}

#[pyfunction]
fn pix2vec<'py>(
    py: Python<'py>,
    nside: &Bound<'py, PyAny>,
    ipix: &Bound<'py, PyAny>,
    nest: bool,
) -> PyResult<[Bound<'py, PyAny>; 3]> {
    let nside = nside_of(nside)?;
    let columns = Columns::new("ipix", [integer_array("ipix", ipix)?])?;
    with_order!(nside, nest, |order| {
        convert(py, "pix2vec", &columns, |[pixels], [x, y, z]| {
            for at in 0..pixels.len() {
                let centre = order.centre(checked(nside, pixels, at)?);
                [x[at], y[at], z[at]] = centre.to_array();
            }
            Ok(())
        })
    })
}

#[pyfunction]
fn ang2pix<'py>(
    py: Python<'py>,
    nside: &Bound<'py, PyAny>,
    theta: &Bound<'py, PyAny>,
    phi: &Bound<'py, PyAny>,
    nest: bool,
    lonlat: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let nside = nside_of(nside)?;
    let names = if lonlat { ["lon", "lat"] } else { ["theta", "phi"] };
    let arrays = [float_array(names[0], theta)?, float_array(names[1], phi)?];
    let columns = Columns::new(&names.join(", "), arrays)?;
    let [pixels] = with_order!(nside, nest, |order| {
        convert(py, "ang2pix", &columns, |[first, second], [output]| {
            let mut angles = [[0.0; 2]; BLOCK];
            let mut pixels = [0; BLOCK];
            let n = first.len();
            for (at, (&first, &second)) in first.iter().zip(second).enumerate() {
                angles[at] = if lonlat {
                    angles_of_degrees(first, second).ok_or_else(|| of_degrees(at, first, second))?
                } else {
                    [rounded_colatitude(first), second]
                };
            }
            if order.pixels_of_angles_into(&angles[..n], &mut pixels[..n]).is_err() {
                for (at, [theta, phi]) in angles[..n].iter().enumerate() {
                    order.pixel_of_angles(*theta, *phi).map_err(|e| Fault::new(at, e))?;
                }
            }
            written(&pixels[..n], output);
            Ok(())
        })
    })?;
    Ok(pixels)
}

/// Returns the fault of a longitude and a latitude in degrees.
fn of_degrees(at: usize, lon: f64, lat: f64) -> Fault {
    if (-90.0..=90.0).contains(&lat) {
        Fault::new(
            at,
            format!("longitude lon = {lon} is not finite: any finite angle in degrees is accepted"),
        )
    } else {
        Fault::new(
            at,
            format!("latitude lat = {lat} is out of range: it must be from -90 to 90 degrees"),
        )
    }
}

#[pyfunction]
fn pix2ang<'py>(
    py: Python<'py>,
    nside: &Bound<'py, PyAny>,
    ipix: &Bound<'py, PyAny>,
    nest: bool,
    lonlat: bool,
) -> PyResult<[Bound<'py, PyAny>; 2]> {
    let nside = nside_of(nside)?;
    let columns = Columns::new("ipix", [integer_array("ipix", ipix)?])?;
    with_order!(nside, nest, |order| {
        convert(py, "pix2ang", &columns, |[pixels], [first, second]| {
            for at in 0..pixels.len() {
                let (theta, phi) = order.centre_angles(checked(nside, pixels, at)?);
                [first[at], second[at]] =
                    if lonlat { degrees_of_angles(theta, phi) } else { [theta, phi] };
            }
            Ok(())
        })
    })
}

#[pyfunction]
fn reorder<'py>(
    py: Python<'py>,
    nside: &Bound<'py, PyAny>,
    ipix: &Bound<'py, PyAny>,
    to_nested: bool,
) -> PyResult<Bound<'py, PyAny>> {
    let nside = nside_of(nside)?;
    let nested = Nested::new(nside).map_err(value_error)?;
    let columns = Columns::new("ipix", [integer_array("ipix", ipix)?])?;
    let function = if to_nested { "ring2nest" } else { "nest2ring" };
    let [pixels] = convert(py, function, &columns, |[pixels], [output]: [&mut [i64]; 1]| {
        for (at, output) in output.iter_mut().enumerate() {
            let pixel = checked(nside, pixels, at)?;
            let other = if to_nested { nested.from_ring(pixel) } else { nested.to_ring(pixel) };
            *output = other.cast_signed();
        }
        Ok(())
    })?;
    Ok(pixels)
}

/// Returns 12 nside^2.
#[pyfunction]
fn nside2npix(nside: &Bound<'_, PyAny>) -> PyResult<u64> {
    Ok(nside_of(nside)?.n_pixels())
}

/// Returns the resolution with this number of pixels.
#[pyfunction]
fn npix2nside(npix: &Bound<'_, PyAny>) -> PyResult<u32> {
    let index = npix.py().import("operator")?.call_method1("index", (npix,))?;
    match index.extract::<u64>() {
        Ok(n_pixels) => Ok(Nside::from_n_pixels(n_pixels).map_err(value_error)?.value()),
        Err(_) => Err(value_error(format!("{index} is not a HEALPix pixel count 12 nside^2"))),
    }
}

pub(crate) fn register(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add_function(wrap_pyfunction!(vec2pix, module)?)?;
    module.add_function(wrap_pyfunction!(pix2vec, module)?)?;
    module.add_function(wrap_pyfunction!(ang2pix, module)?)?;
    module.add_function(wrap_pyfunction!(pix2ang, module)?)?;
    module.add_function(wrap_pyfunction!(reorder, module)?)?;
    module.add_function(wrap_pyfunction!(nside2npix, module)?)?;
    module.add_function(wrap_pyfunction!(npix2nside, module)?)
}
