//! Tests of every map, and of each on its hard cases.

mod density_maps;
mod every_warp;
mod lobes;
mod rectangles;
mod subjects;
mod triangles;
mod uniformity;
