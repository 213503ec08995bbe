//! Everything that calls the library.

#[path = "../common/mod.rs"]
mod common;

mod builder;
mod camera;
mod contours;
mod conventions;
mod engine;
mod environments;
mod exr;
mod from_depth;
mod groups;
mod hatch;
mod invariance;
mod layer_names;
mod light_layers;
mod live;
mod mutations;
mod normal_maps;
mod normal_rays;
mod outlines;
mod points;
mod prelude;
mod relight;
mod resolution;
mod rooms;
mod sanitize;
mod scales;
mod scenes;
mod sequences;
mod shape;
mod silhouettes;
mod specular;
mod stroke_field;
mod tiles;
