//! Walls, meshes and ray intersections.

pub(crate) mod bounds;
pub(crate) mod bundle;
pub(crate) mod cone;
pub(crate) mod duplicates;
pub(crate) mod height;
pub(crate) mod hierarchy;
pub(crate) mod hit;
pub(crate) mod mesh;
pub(crate) mod order;
pub(crate) mod pages;
pub(crate) mod partition;
pub(crate) mod quad;
pub(crate) mod quads;
pub(crate) mod ray;
pub(crate) mod scene;
pub(crate) mod stream;
pub(crate) mod triangles;
