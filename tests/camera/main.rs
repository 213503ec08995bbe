//! Cameras, recovered or read, and the space of the normals that they turn.

mod depth;
mod measure;
mod planes;
mod positions;
#[path = "../real_files/mod.rs"]
mod real_files;
mod renders;
mod shots;
mod space;
