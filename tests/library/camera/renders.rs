//! Cameras of real renders: recovered from their layers, and read from the JSON beside them.
//!
//! The renders are not part of this crate: if their folder is absent, these tests print a notice and pass.

use super::measure::{focal_error, turn_between, turn_deg};
use super::planes::mapped;
use crate::common::files::load;
use crate::common::program::fixture;
use crate::prelude::*;
use relievo::io::camera::{
    DepthCamera, RecoveredCamera, RecoveryFailure, read_camera, recover_camera,
    recover_camera_from_depth,
};
use relievo::io::exr::{ExrFile, Limits};
use std::path::{Path, PathBuf};

/// A render, with the camera it was made by beside it.
pub(crate) struct Render {
    pub(crate) path: PathBuf,
    file: ExrFile,
}

type Recovered<T> = Result<T, RecoveryFailure>;

/// The renders that are not panoramas.
pub(crate) fn pictures() -> impl Iterator<Item = Render> {
    renders(|path| !is_panorama(path))
}

fn renders(wanted: impl Fn(&Path) -> bool) -> impl Iterator<Item = Render> {
    let folders = [real("renders"), real("renders/seq")];
    let folders = folders
        .iter()
        .flatten()
        .filter_map(|f| std::fs::read_dir(f).ok());
    let files = folders
        .flatten()
        .filter_map(|entry| Some(entry.ok()?.path()));
    let mut files: Vec<PathBuf> = files.collect();
    files.retain(|path| path.extension().is_some_and(|e| e == "exr") && wanted(path));
    files.sort();
    files.into_iter().map(Render::open)
}

fn is_panorama(path: &Path) -> bool {
    path.to_string_lossy().contains("pano")
}

impl Render {
    fn open(path: PathBuf) -> Self {
        let file = ExrFile::open(&path, &Limits::default()).expect("a readable render");
        Self { path, file }
    }

    /// The first channels whose names end in these.
    fn channels<const N: usize>(&self, ends: [&str; N]) -> Option<[Plane; N]> {
        let mut ids = Vec::new();
        for end in ends {
            let named = |part: usize, channel: usize| &self.file.parts[part].channels[channel].name;
            let mut all = self.file.channel_ids();
            ids.push(all.find(|id| named(id.part, id.channel).ends_with(end))?);
        }
        let planes = self.file.read_channels(&ids).expect("readable channels");
        planes.try_into().ok()
    }

    pub(crate) fn depth(&self) -> Option<Plane> {
        self.channels(["Depth.Z"]).map(|[depth]| depth)
    }

    pub(crate) fn vector(&self, name: &str) -> Option<Vector3Planes> {
        let [x, y, z] = ["X", "Y", "Z"].map(|axis| format!("{name}.{axis}"));
        let [x, y, z] = self.channels([&x, &y, &z])?;
        Some(Vector3Planes { x, y, z })
    }

    /// Pixels nearer than the background, or with a position where there is no depth.
    pub(crate) fn mask(&self, position: &Vector3Planes) -> Mask {
        if let Some(depth) = self.depth() {
            return Mask::new(depth.map(|d| d < 1e9));
        }
        let seen = |x: usize, y: usize| position.at(x, y) != DVec3::ZERO;
        let (width, height) = (position.x.width(), position.x.height());
        Mask::new(Plane::from_fn(width, height, seen))
    }

    pub(crate) fn data_window(&self) -> Window {
        self.file.parts[0].window
    }

    /// The camera that the render was made by.
    pub(crate) fn camera(&self) -> relievo::Result<Camera> {
        let path = self.path.with_extension("json");
        read_camera(&path, self.file.display_window, self.file.pixel_aspect)
    }

    fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or_default();
        name.to_string_lossy().into_owned()
    }

    fn recovered(&self, position: &Vector3Planes, mask: &Mask) -> Recovered<RecoveredCamera> {
        let (display, aspect) = (self.file.display_window, self.file.pixel_aspect);
        recover_camera(position, mask, self.data_window(), display, aspect)
    }

    fn recovered_from_depth(
        &self,
        normal: &Vector3Planes,
        depth: &Plane,
        mask: &Mask,
    ) -> Recovered<DepthCamera> {
        let (display, aspect) = (self.file.display_window, self.file.pixel_aspect);
        recover_camera_from_depth(normal, depth, mask, self.data_window(), display, aspect)
    }
}

#[test]
fn recovered_cameras_match_the_renders() {
    for render in pictures() {
        let Some(position) = render.vector("Position") else {
            continue;
        };
        let (name, mask) = (render.name(), render.mask(&position));
        let found = render.recovered(&position, &mask);
        let found = found.unwrap_or_else(|failure| panic!("{name}: {failure}"));
        let truth = render.camera().expect("a camera beside the render");
        let turn = turn_between(&found.camera, &truth);
        assert!(turn < 0.05, "{name}: off by {turn} degrees");
    }
}

#[test]
fn panoramas_are_refused() {
    for render in renders(is_panorama) {
        let position = render.vector("Position").expect("positions");
        let found = render.recovered(&position, &render.mask(&position));
        let failure = found.expect_err("fitted a panorama");
        assert!(matches!(failure, RecoveryFailure::NotACamera { .. }));
        let error = render.camera().expect_err("read a panorama's camera");
        assert!(error.to_string().contains("panorama"), "{error}");
    }
}

#[test]
fn rotations_match_the_renders() {
    for render in pictures() {
        let name = render.name();
        let (Some(normal), Some(depth)) = (render.vector("Normal"), render.depth()) else {
            continue;
        };
        let found = render.recovered_from_depth(&normal, &depth, &render.mask(&normal));
        let found = found.unwrap_or_else(|failure| panic!("{name}: {failure}"));
        let truth = render.camera().expect("a camera beside the render");
        let turn = turn_between(&found.camera, &truth);
        let (most, said) = match render.data_window().width() < 100 {
            true => (1.0, f64::INFINITY),
            false => (0.2, 4.0 * found.rotation_uncertainty_deg + 0.01),
        };
        assert!(turn < most && turn < said, "{name}: off by {turn} degrees");
    }
}

#[test]
fn view_space_normals_come_out_unturned() {
    for render in pictures() {
        let (Some(world), Some(depth)) = (render.vector("Normal"), render.depth()) else {
            continue;
        };
        let truth = render.camera().expect("a camera beside the render");
        let view = mapped(&world, |n| truth.view_from_world.matrix3 * n);
        let mask = render.mask(&view);
        let found = render.recovered_from_depth(&view, &depth, &mask);
        let turn = found.expect("a camera").camera.view_from_world.matrix3;
        let turn = turn_deg(turn, DMat3::IDENTITY);
        assert!(turn < 1.0, "{}: {turn} degrees", render.path.display());
    }
}

#[test]
fn positions_that_scatter_out_of_focus_give_the_camera_between_them() {
    let render = Render::open(fixture("blur.exr"));
    let position = render.vector("Position").expect("positions");
    let (width, height) = (position.x.width(), position.x.height());
    let window = Window::from_size(width, height);
    let camera = render.path.with_extension("camera.json");
    let truth = read_camera(&camera, window, 1.0).expect("a camera");
    let found = recover_camera(&position, &Mask::full(width, height), window, window, 1.0).unwrap();
    // Each was seen through its own part of a lens that is 33 cm wide, some 2 px off; the mean of 20,000 of them is
    // less than a twentieth of a degree off.
    assert!(found.residual_px_median > 1.0, "{found:?}");
    let turn = turn_between(&found.camera, &truth);
    assert!(turn < 0.05, "{turn} degrees");
    let off = focal_error(&found.camera, &truth);
    assert!(off < 0.01, "{off}");
}

#[test]
fn depth_out_of_focus_is_known_by_its_positions() {
    // Normals averaged over the lens lie 8 degrees off the tangents of its points, which would leave depth relative.
    let loaded = load(fixture("blur.exr"), |_, _| ());
    assert_eq!(loaded.conventions.depth_kind, Some(StoredDepth::Planar));
}
