//! A file as each renderer writes it, of one scene: the frame must come out as the scene is.
//!
//! Bounds on normals: 32-bit floats lose 1e-5 degrees. A half float below 1 is off by up to 2^-12, so a vector of
//! three by sqrt(3) 2^-12 radians, 0.024 degrees; encoded as 0..1 by twice that, 0.048. A camera adds its own error: as
//! matrices of 32-bit floats 1e-4 degrees, recovered from positions 0.01, from depth and normals what it says, here
//! at most 0.3.

use super::truth::{FOCAL, HEIGHT, Truth, WIDTH, display, truth};
use crate::common::exr::{Part, Stored, write};
use glam::{DAffine3, DMat3, DMat4, DVec3};
use relievo::frame::{DepthKind, NormalSpace, Plane};
use relievo::io::inputs::{Flip, Inputs, StoredDepth};
use relievo::io::{self, Loaded, Needs};
use std::path::Path;

const FLOAT_DEG: f64 = 1e-3;
const HALF_DEG: f64 = 0.025;
const ENCODED_HALF_DEG: f64 = 0.049;
const POSITIONS_DEG: f64 = 0.01;
const DEPTH_DEG: f64 = 0.3;

const XYZ: [&str; 3] = ["X", "Y", "Z"];
const RGB: [&str; 3] = ["R", "G", "B"];

/// What a file must be read as.
struct Expected {
    space: NormalSpace,
    flip: Flip,
    depth: StoredDepth,
    worst_deg: f64,
}

fn z_away() -> Flip {
    Flip {
        z: true,
        ..Flip::NONE
    }
}

/// A world's axes, from those of the truth: right-handed with y up.
fn y_up() -> DMat3 {
    DMat3::from_cols(DVec3::X, -DVec3::Z, DVec3::Y)
}

/// Left-handed with z up, as Unreal has it.
fn left_handed() -> DMat3 {
    DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0))
}

/// View from a world of other axes.
fn view_from(truth: &Truth, axes: DMat3) -> DAffine3 {
    truth.camera * DAffine3::from_mat3(axes.inverse())
}

fn layer(
    part: Part,
    name: &str,
    components: [&str; 3],
    stored: Stored,
    planes: [Plane; 3],
) -> Part {
    let mut part = part;
    for (component, plane) in components.into_iter().zip(&planes) {
        part = part.channel(&format!("{name}.{component}"), stored, plane);
    }
    part
}

/// The components of world-space normals in a world of these axes.
fn world_normals(truth: &Truth, axes: DMat3) -> [Plane; 3] {
    let world = view_from(truth, axes).inverse();
    [0, 1, 2].map(|axis| truth.normal(axis, 0.0, |n| world.transform_vector3(n)))
}

fn world_positions(truth: &Truth, axes: DMat3) -> [Plane; 3] {
    let world = view_from(truth, axes).inverse();
    [0, 1, 2].map(|axis| truth.point(axis, 0.0, |p| world.transform_point3(p)))
}

fn view_normals(truth: &Truth, change: impl Fn(DVec3) -> DVec3) -> [Plane; 3] {
    [0, 1, 2].map(|axis| truth.normal(axis, 0.0, &change))
}

fn part() -> Part {
    Part::new(display())
}

fn load(path: &Path) -> Loaded {
    let inputs = Inputs {
        picture: path.to_path_buf(),
        ..Inputs::default()
    };
    let needs = Needs {
        projection: true,
        ..Needs::default()
    };
    io::load(&inputs, needs).unwrap()
}

/// Reads the file and compares it; a row of the table goes to the output.
fn check(renderer: &str, parts: &[Part], expected: &Expected) -> Loaded {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("a.exr");
    write(&path, display(), parts);
    let loaded = load(&path);
    compare(renderer, &loaded, expected);
    loaded
}

fn compare(renderer: &str, loaded: &Loaded, expected: &Expected) {
    let (truth, found) = (truth(), loaded.conventions);
    let (normals, mask) = (
        truth.worst_angle_deg(&loaded.frame),
        truth.mask_errors(&loaded.frame),
    );
    println!(
        "| {renderer} | {:?}, {} reversed | {} | {normals:.5} |",
        found.normal_space,
        found.normal_flip,
        found.depth_kind.map_or("none", StoredDepth::name)
    );
    for finding in &loaded.findings {
        println!(
            "    {}: {} ({})",
            finding.subject, finding.conclusion, finding.evidence
        );
    }
    assert_eq!(found.normal_space, expected.space, "{renderer}");
    assert_eq!(found.normal_flip, expected.flip, "{renderer}");
    assert_eq!(found.depth_kind, Some(expected.depth), "{renderer}");
    assert_eq!(mask, 0, "{renderer}: pixels of the mask");
    assert!(
        normals <= expected.worst_deg,
        "{renderer}: {normals} degrees"
    );
    let along_ray = match loaded.frame.source.depth_kind {
        DepthKind::Planar => false,
        DepthKind::Ray => true,
        DepthKind::Relative => return,
    };
    // Depth may be in units of its own, and have been stored as one over it: 2^-23.
    let off = truth.worst_depth(&loaded.frame, along_ray);
    assert!(off < 1e-5, "{renderer}: depth is off by a share of {off}");
}

fn expected(space: NormalSpace, depth: StoredDepth, worst_deg: f64) -> Expected {
    Expected {
        space,
        flip: Flip::NONE,
        depth,
        worst_deg,
    }
}

use NormalSpace::{View, World};
use Stored::{Float, Half};

#[test]
fn blender() {
    // World space, z up, one part per pass.
    let truth = truth();
    let axes = DMat3::IDENTITY;
    let depth = truth.depth(1e10, |z, _| z);
    let parts = [
        layer(
            part(),
            "ViewLayer.Normal",
            XYZ,
            Float,
            world_normals(truth, axes),
        )
        .named("ViewLayer.Normal"),
        part()
            .channel("ViewLayer.Depth.Z", Float, &depth)
            .named("ViewLayer.Depth"),
        layer(
            part(),
            "ViewLayer.Position",
            XYZ,
            Float,
            world_positions(truth, axes),
        )
        .named("ViewLayer.Position"),
    ];
    check(
        "Blender",
        &parts,
        &expected(World, StoredDepth::Planar, POSITIONS_DEG),
    );
    // Without positions; the background of a half float.
    let depth = truth.depth(65504.0, |z, _| z);
    let parts = [
        parts[0].clone(),
        part()
            .channel("ViewLayer.Depth.Z", Half, &depth)
            .named("ViewLayer.Depth"),
    ];
    check(
        "Blender, half depth",
        &parts,
        &expected(World, StoredDepth::Relative, DEPTH_DEG),
    );
    // What Cycles keeps for its denoiser: camera space, z away from the viewer.
    let normals = view_normals(truth, |n| DVec3::new(n.x, n.y, -n.z));
    let depth = truth.depth(1e10, |z, _| z);
    let denoising = layer(part(), "ViewLayer.Denoising Normal", XYZ, Half, normals).channel(
        "ViewLayer.Denoising Depth.Z",
        Float,
        &depth,
    );
    let away = Expected {
        flip: z_away(),
        ..expected(View, StoredDepth::Planar, HALF_DEG)
    };
    check("Blender, denoising", &[denoising], &away);
}

/// `worldToNDC` of the standard for a camera looking along +z: 0..1 from the top left.
fn ndc_from_camera(signed: bool, z: f64) -> DMat4 {
    let (fx, fy) = (FOCAL / WIDTH as f64, FOCAL / HEIGHT as f64);
    let unsigned = DMat4::from_cols_array_2d(&[
        [fx, 0.0, 0.0, 0.0],
        [0.0, -fy, 0.0, 0.0],
        [0.5 * z, 0.5 * z, z, z],
        [0.0, 0.0, -0.1, 0.0],
    ]);
    match signed {
        false => unsigned,
        // u' = 2 u - 1, v' = 1 - 2 v.
        true => {
            DMat4::from_cols_array_2d(&[
                [2.0, 0.0, 0.0, 0.0],
                [0.0, -2.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [-1.0, 1.0, 0.0, 1.0],
            ]) * unsigned
        }
    }
}

/// Both matrices, for row vectors as the standard has them: the columns of those for column vectors.
fn with_matrices(part: Part, to_camera: DAffine3, to_ndc: DMat4, transposed: bool) -> Part {
    let read = |m: DMat4| if transposed { m.transpose() } else { m };
    let to_camera = DMat4::from(to_camera);
    part.floats("worldToCamera", "m44f", &read(to_camera).to_cols_array())
        .floats(
            "worldToNDC",
            "m44f",
            &read(to_ndc * to_camera).to_cols_array(),
        )
}

#[test]
fn arnold() {
    // World space, y up; matrices of a camera that looks along -z, and picture coordinates from -1 to 1.
    let truth = truth();
    let view = view_from(truth, y_up());
    let depth = truth.depth(1e30, |z, _| z);
    let file =
        layer(part(), "N", RGB, Float, world_normals(truth, y_up())).channel("Z", Float, &depth);
    let file = with_matrices(file, view, ndc_from_camera(true, -1.0), false);
    let arnold = expected(World, StoredDepth::Planar, FLOAT_DEG);
    check("Arnold", std::slice::from_ref(&file), &arnold);
    let placed = layer(file, "P", RGB, Float, world_positions(truth, y_up()));
    let loaded = check("Arnold, positions", &[placed], &arnold);
    assert!(loaded.camera_is_placed);
    // The same as Nuke hands it on, without matrices but with all that tells it.
    let bare =
        layer(part(), "N", RGB, Float, world_normals(truth, y_up())).channel("Z", Float, &depth);
    check(
        "Arnold, nothing told",
        &[bare],
        &expected(World, StoredDepth::Planar, DEPTH_DEG),
    );
}

#[test]
fn renderman() {
    // World space; matrices as in the standard: left-handed camera, +z forward.
    let truth = truth();
    let forward = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)) * view_from(truth, y_up());
    let depth = truth.depth(f64::INFINITY, |z, _| z);
    let file = layer(
        part(),
        "__Nworld",
        ["r", "g", "b"],
        Float,
        world_normals(truth, y_up()),
    )
    .channel("__depth.r", Float, &depth);
    let file = with_matrices(file, forward, ndc_from_camera(false, 1.0), false);
    let renderman = expected(World, StoredDepth::Planar, FLOAT_DEG);
    check("RenderMan", std::slice::from_ref(&file), &renderman);
    let file = layer(
        file,
        "__Pworld",
        ["r", "g", "b"],
        Float,
        world_positions(truth, y_up()),
    );
    check("RenderMan, positions", &[file], &renderman);
}

#[test]
fn pbrt() {
    // All in camera space, +z forward and so left-handed, half floats; matrices transposed. No depth: P.Z.
    let truth = truth();
    let away = |v: DVec3| DVec3::new(v.x, v.y, -v.z);
    let facets = view_normals(truth, |n| (away(n) + DVec3::new(0.3, 0.0, 0.0)).normalize());
    let file = layer(part(), "N", XYZ, Half, facets);
    let file = layer(file, "Ns", XYZ, Half, view_normals(truth, away));
    let points = [0, 1, 2].map(|axis| truth.point(axis, 0.0, away));
    let file = layer(file, "P", XYZ, Float, points);
    let forward = DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)) * view_from(truth, y_up());
    let file = with_matrices(file, forward, ndc_from_camera(false, 1.0), true);
    let camera_space = Expected {
        flip: z_away(),
        ..expected(View, StoredDepth::Planar, HALF_DEG)
    };
    check("pbrt", &[file], &camera_space);
    // In world space the matrices tell the camera.
    let file = layer(part(), "Ns", XYZ, Half, world_normals(truth, y_up()));
    let file = layer(file, "P", XYZ, Float, world_positions(truth, y_up()));
    let file = with_matrices(file, forward, ndc_from_camera(false, 1.0), true);
    let world = expected(World, StoredDepth::Planar, HALF_DEG);
    check("pbrt, world", &[file], &world);
}

#[test]
fn vray() {
    // Camera space with red to the left; depth black far and white near, clamped; the camera in attributes.
    let truth = truth();
    let left = |n: DVec3| DVec3::new(-n.x, n.y, n.z);
    let depth = truth.depth(0.0, |z, _| ((7.0 - z) / 3.0).clamp(0.0, 1.0));
    let expected = Expected {
        flip: Flip {
            x: true,
            ..Flip::NONE
        },
        ..expected(View, StoredDepth::WhiteNear, FLOAT_DEG)
    };
    let file = layer(part(), "normals", XYZ, Float, view_normals(truth, left))
        .channel("zDepth.Z", Float, &depth)
        .floats(
            "cameraFov",
            "float",
            &[(2.0 * (0.5 * WIDTH as f64 / FOCAL).atan()).to_degrees()],
        )
        .floats(
            "cameraTransform",
            "m44f",
            &DMat4::from(truth.camera.inverse()).to_cols_array(),
        );
    check("V-Ray", &[file], &expected);
}

#[test]
fn redshift() {
    // World space; the camera's own placing, looking along +z with x to the left, and its field of view.
    let truth = truth();
    let turned = DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0)) * view_from(truth, y_up());
    let depth = truth.depth(0.0, |z, _| z);
    let file = layer(part(), "N", RGB, Float, world_normals(truth, y_up()))
        .channel("Z", Float, &depth)
        .floats(
            "rs/camera/fov",
            "float",
            &[(2.0 * (0.5 * WIDTH as f64 / FOCAL).atan()).to_degrees()],
        )
        .floats(
            "rs/camera/transform",
            "m44f",
            &DMat4::from(turned.inverse()).to_cols_array(),
        );
    check(
        "Redshift",
        &[file],
        &expected(World, StoredDepth::Planar, FLOAT_DEG),
    );
}

#[test]
fn houdini() {
    let truth = truth();
    let depth = truth.depth(0.0, |z, _| z);
    let karma = layer(
        part(),
        "ray:hitN",
        ["r", "g", "b"],
        Float,
        world_normals(truth, y_up()),
    )
    .channel("ray:hitPz", Float, &depth);
    let karma = layer(
        karma,
        "ray:hitP",
        ["r", "g", "b"],
        Float,
        world_positions(truth, y_up()),
    );
    check(
        "Karma",
        &[karma],
        &expected(World, StoredDepth::Planar, POSITIONS_DEG),
    );
    // The length of the ray.
    let length = truth.depth(0.0, |_, distance| distance);
    let karma = layer(
        part(),
        "ray:hitN",
        ["r", "g", "b"],
        Float,
        world_normals(truth, y_up()),
    )
    .channel("ray:hitdist", Float, &length);
    check(
        "Karma, ray length",
        &[karma],
        &expected(World, StoredDepth::Ray, DEPTH_DEG),
    );
    let mantra = layer(
        part(),
        "N",
        ["x", "y", "z"],
        Half,
        view_normals(truth, |n| n),
    )
    .channel("Pz", Float, &depth);
    check(
        "Mantra",
        &[mantra],
        &expected(View, StoredDepth::Planar, HALF_DEG),
    );
}

#[test]
fn octane_and_corona() {
    let truth = truth();
    // A distance in shares of the largest one.
    let depth = truth.depth(1.0, |_, distance| distance / 20.0);
    let file = layer(
        part(),
        "ShadingNormals",
        RGB,
        Float,
        view_normals(truth, |n| n),
    )
    .channel("Depth.R", Float, &depth);
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("octane.exr");
    write(&path, display(), &[file]);
    let loaded = load(&path);
    assert_eq!(loaded.conventions.depth_kind, Some(StoredDepth::Ray));
    assert_eq!(truth.mask_errors(&loaded.frame), 0);
    assert!(truth.worst_angle_deg(&loaded.frame) < FLOAT_DEG);

    let depth = truth.depth(1.0, |z, _| ((z - 4.0) / 3.0).clamp(0.0, 1.0));
    let file = layer(
        part(),
        "CGeometry_NormalsShading",
        RGB,
        Half,
        view_normals(truth, |n| n),
    )
    .channel("CGeometry_ZDepth.R", Half, &depth);
    check(
        "Corona",
        &[file],
        &expected(View, StoredDepth::WhiteFar, HALF_DEG),
    );
}

#[test]
fn mitsuba() {
    // World space, distance along the sight line, nothing is 0.
    let truth = truth();
    let depth = truth.depth(0.0, |_, distance| distance);
    let file = layer(
        part(),
        "sh_normal",
        XYZ,
        Float,
        world_normals(truth, y_up()),
    )
    .channel("depth.T", Float, &depth);
    let file = layer(file, "position", XYZ, Float, world_positions(truth, y_up()));
    check(
        "Mitsuba",
        &[file],
        &expected(World, StoredDepth::Ray, POSITIONS_DEG),
    );
}

#[test]
fn nuke() {
    // One over depth, 0 for nothing.
    let truth = truth();
    let depth = truth.depth(0.0, |z, _| 1.0 / z);
    let file = layer(
        part(),
        "N",
        ["red", "green", "blue"],
        Float,
        view_normals(truth, |n| n),
    )
    .channel("depth.Z", Float, &depth);
    check(
        "Nuke",
        &[file],
        &expected(View, StoredDepth::Inverse, FLOAT_DEG),
    );
    let file = layer(
        part(),
        "N",
        ["red", "green", "blue"],
        Float,
        world_normals(truth, y_up()),
    )
    .channel("depth.Z", Float, &depth);
    check(
        "Nuke, world",
        &[file],
        &expected(World, StoredDepth::Inverse, DEPTH_DEG),
    );
}

#[test]
fn unreal() {
    // A left-handed world in centimetres; the camera in texts.
    let truth = truth();
    let axes = left_handed();
    let view = view_from(truth, axes);
    let world = view.inverse();
    let (forward, eye) = (
        world.transform_vector3(DVec3::NEG_Z),
        world.translation * 100.0,
    );
    let pitch = forward.z.asin().to_degrees();
    let yaw = forward.y.atan2(forward.x).to_degrees();
    let depth = truth.depth(65504.0, |z, _| 100.0 * z);
    let name = "FinalImageMovieRenderQueue_World";
    let file = layer(
        part(),
        &format!("{name}Normal"),
        RGB,
        Half,
        world_normals(truth, axes),
    );
    let bare = layer(
        file,
        &format!("{name}Depth"),
        RGB,
        Half,
        [depth.clone(), depth.clone(), depth],
    );
    let file = bare
        .clone()
        .text("unreal/camera/FinalImage/curPos/x", &eye.x.to_string())
        .text("unreal/camera/FinalImage/curPos/y", &eye.y.to_string())
        .text("unreal/camera/FinalImage/curPos/z", &eye.z.to_string())
        .text("unreal/camera/FinalImage/curRot/pitch", &pitch.to_string())
        .text("unreal/camera/FinalImage/curRot/yaw", &yaw.to_string())
        .text("unreal/camera/FinalImage/curRot/roll", "0")
        .text(
            "unreal/camera/FinalImage/fov",
            &(2.0 * (0.5 * WIDTH as f64 / FOCAL).atan())
                .to_degrees()
                .to_string(),
        );
    let unreal = expected(World, StoredDepth::Relative, HALF_DEG);
    check("Unreal", &[file], &unreal);
    let blind = Expected {
        worst_deg: HALF_DEG + DEPTH_DEG,
        ..unreal
    };
    check("Unreal, nothing told", &[bare], &blind);
}

#[test]
fn directx() {
    // Tangent space of a picture: green down, encoded as 0..1.
    let truth = truth();
    let down = |n: DVec3| 0.5 * DVec3::new(n.x, -n.y, n.z) + 0.5;
    let depth = truth.depth(0.0, |z, _| z);
    let file =
        layer(part(), "normal", RGB, Half, view_normals(truth, down)).channel("Z", Float, &depth);
    let y_down = Expected {
        flip: Flip {
            y: true,
            ..Flip::NONE
        },
        ..expected(View, StoredDepth::Planar, ENCODED_HALF_DEG)
    };
    check("DirectX", &[file], &y_down);
}
