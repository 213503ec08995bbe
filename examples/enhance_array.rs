//! Arrays in memory to an enhanced array, with progress and cancellation: `cargo run --release -p examples --example enhance_array`; with
//! `--features gpu` on a device where there is one.
//!
//! A ball whose bumps the light hardly shows; a render or a scan comes in the same way. Another thread may end the run by its
//! token.

use ndarray::Array3;
use relievo::engine::{CancelToken, Engine, Progress, Request, Run};
use relievo::frame::{Frame, Normals};
use relievo::params::Params;
use relievo::product::Product;

const SIZE: usize = 512;

fn main() -> relievo::Result<()> {
    let normals = Array3::from_shape_fn((SIZE, SIZE, 3), |(y, x, axis)| normal(x, y)[axis]);
    let shading = |(y, x, _)| 0.2 + 0.6 * normal(x, y)[2];
    let mut picture = Array3::from_shape_fn((SIZE, SIZE, 3), shading);
    let frame = Frame::builder(SIZE, SIZE)
        .normals(Normals::view(&normals))
        .color(&picture)
        .build()?;
    let (token, before) = (CancelToken::new(), picture.clone());
    let tell = |at: Progress| println!("{:3.0} % {}", 100.0 * at.done, at.stage);
    let run = Run::new().progress(&tell).cancel(&token);
    let run = run.output(Product::Picture, picture.view_mut());
    let request = Request::enhance(Params::default());
    Engine::auto().run(&request, &frame, &run)?;
    drop(run);
    println!("changed by up to {:.2}", largest(&(picture - before)));
    Ok(())
}

/// The normal of the ball at a pixel; none beside it.
fn normal(x: usize, y: usize) -> [f32; 3] {
    let [x, y] = [x, SIZE - y].map(|at| 2.0 * at as f32 / SIZE as f32 - 1.0);
    let z = (1.0 - x * x - y * y).max(0.0).sqrt();
    let bump = |at: f32| 0.1 * (30.0 * at).sin();
    match z > 0.0 {
        true => [x + bump(x), y + bump(y), z],
        false => [0.0; 3],
    }
}

fn largest(differences: &Array3<f32>) -> f32 {
    differences.iter().fold(0.0, |most, d| most.max(d.abs()))
}
