//! Cameras, recovered or read, and the space of the normals that they turn.

mod depth;
mod measure;
mod planes;
mod positions;
mod renders;
mod shots;
mod space;
