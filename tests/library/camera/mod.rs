//! Cameras, recovered or read, and the space of the normals they rotate.

mod depth;
mod measure;
mod planes;
mod positions;
mod renders;
mod shots;
mod space;
