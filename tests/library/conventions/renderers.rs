//! One scene in a file of each renderer: the frame must match the scene.
//!
//! Bounds on normals: 32-bit floats lose 1e-5 degrees. A half float below 1 is off by up to 2^-12, so a vector of three
//! by sqrt(3) 2^-12 radians, 0.024 degrees; encoded as 0..1 by twice that, 0.048. A camera adds its own error: as
//! matrices of 32-bit floats 1e-4 degrees, recovered from positions 0.01, from depth and normals its reported one, here
//! at most 0.3.

use super::truth::{FOCAL, HEIGHT, Truth, WIDTH};
use super::*;
use glam::DMat4;

const FLOAT_DEG: f64 = 1e-3;
const HALF_DEG: f64 = 0.025;
const ENCODED_HALF_DEG: f64 = 0.049;
const POSITIONS_DEG: f64 = 0.01;
const DEPTH_DEG: f64 = 0.3;

const RGB: [&str; 3] = ["R", "G", "B"];
const RGB_LOWER: [&str; 3] = ["r", "g", "b"];

/// A file as written by a renderer, with its expected reading.
struct File {
    renderer: &'static str,
    normal: Layer,
    space: Space,
    depth: Option<Depth>,
    position: Option<Layer>,
    /// Whether each layer is a separate part.
    in_parts: bool,
    /// Additional content: the camera in attributes.
    more: fn(Part) -> Part,
    read_as: ReadAs,
}

/// Name, components and storage.
type Layer = (&'static str, [&'static str; 3], Stored);

/// Channels, storage, the value where there is no surface, and the measure stored elsewhere.
type Depth = (&'static [&'static str], Stored, f64, Measure);

/// Something of planar depth and distance along the sight line.
type Measure = fn(f64, f64) -> f64;

/// The space of normals and positions.
#[derive(Clone, Copy)]
enum Space {
    /// A world with these axes.
    In(fn() -> DMat3),
    /// View space, changed so.
    Seen(fn(DVec3) -> DVec3),
}

struct ReadAs {
    space: NormalSpace,
    flip: Flip,
    depth: StoredDepth,
    worst_deg: f64,
    /// Units of the stored depth in one of the scene's.
    unit: f64,
    is_placed: bool,
}

impl Space {
    fn normals(self) -> [Plane; 3] {
        normals(DVec3::ZERO, |n| match self {
            Self::In(axes) => view_from(truth(), axes()).inverse().transform_vector3(n),
            Self::Seen(change) => change(n),
        })
    }

    fn positions(self) -> [Plane; 3] {
        let change = |p| match self {
            Self::In(axes) => view_from(truth(), axes()).inverse().transform_point3(p),
            Self::Seen(change) => change(p),
        };
        [0, 1, 2].map(|axis| truth().point(axis, 0.0, change))
    }
}

impl File {
    fn parts(&self) -> Vec<Part> {
        let mut parts = vec![with_layer(part(), self.normal, &self.space.normals())];
        if let Some((channels, stored, background, measure)) = self.depth {
            let plane = truth().depth(background, measure);
            let add = |part: Part, name: &&str| part.channel(name, stored, &plane);
            parts.push(channels.iter().fold(part(), add));
        }
        if let Some(position) = self.position {
            parts.push(with_layer(part(), position, &self.space.positions()));
        }
        if self.in_parts {
            return parts.into_iter().map(named_after_its_layer).collect();
        }
        let channels = parts.into_iter().flat_map(|part| part.channels).collect();
        vec![(self.more)(Part { channels, ..part() })]
    }

    /// Reads the file and compares it.
    fn check(&self) {
        let loaded = read(&self.parts(), |_, needs| needs.projection = true);
        let (truth, found) = (truth(), loaded.conventions);
        let (renderer, expected) = (self.renderer, &self.read_as);
        assert_eq!(found.normal_space, expected.space, "{renderer}");
        assert_eq!(found.normal_flip, expected.flip, "{renderer}");
        assert_eq!(found.depth_kind, Some(expected.depth), "{renderer}");
        let mask = truth.mask_errors(&loaded.frame);
        assert_eq!(mask, 0, "{renderer}: pixels of the mask");
        // For the table in docs/guide/files.md.
        let off = truth.worst_angle_deg(&loaded.frame);
        println!("{renderer}: {off:.5}");
        assert!(off <= expected.worst_deg, "{renderer}: {off} degrees");
        assert!(loaded.camera_is_placed || !expected.is_placed, "{renderer}");
        let along_ray = match loaded.frame.source.depth_kind {
            DepthKind::Planar => false,
            DepthKind::Ray => true,
            DepthKind::Relative => return,
        };
        // Depth may be in units of its own, and have been stored as one over it: 2^-23.
        let off = truth.worst_depth(&loaded.frame, along_ray, expected.unit);
        assert!(off < 1e-5, "{renderer}: depth is off by a share of {off}");
    }

    fn with_position(self, name: &'static str, components: [&'static str; 3]) -> Self {
        let position = Some((name, components, Float));
        Self { position, ..self }
    }

    fn with(self, more: fn(Part) -> Part) -> Self {
        Self { more, ..self }
    }

    fn in_parts(self) -> Self {
        let in_parts = true;
        Self { in_parts, ..self }
    }
}

fn part() -> Part {
    Part::new(display())
}

fn named_after_its_layer(part: Part) -> Part {
    let (layer, _) = part.channels[0].0.rsplit_once('.').unwrap();
    let layer = layer.to_string();
    part.named(&layer)
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

/// `worldToNDC` of the standard for a camera looking along +z: 0..1 from the top left.
fn ndc_from_camera(signed: bool, z: f64) -> DMat4 {
    let (fx, fy) = (FOCAL / WIDTH as f64, FOCAL / HEIGHT as f64);
    let unsigned = DMat4::from_cols_array_2d(&[
        [fx, 0.0, 0.0, 0.0],
        [0.0, -fy, 0.0, 0.0],
        [0.5 * z, 0.5 * z, z, z],
        [0.0, 0.0, -0.1, 0.0],
    ]);
    // u' = 2 u - 1, v' = 1 - 2 v.
    let doubled = DMat4::from_scale(glam::dvec3(2.0, -2.0, 1.0));
    let from_corner = DMat4::from_translation(glam::dvec3(-1.0, 1.0, 0.0)) * doubled;
    if signed {
        from_corner * unsigned
    } else {
        unsigned
    }
}

/// Both matrices, for row vectors as in the standard: the columns of those for column vectors.
fn with_matrices(part: Part, to_camera: DAffine3, to_ndc: DMat4, transposed: bool) -> Part {
    let read = |m: DMat4| if transposed { m.transpose() } else { m };
    let to_camera = DMat4::from(to_camera);
    let to_ndc = read(to_ndc * to_camera).to_cols_array();
    part.floats("worldToCamera", "m44f", &read(to_camera).to_cols_array())
        .floats("worldToNDC", "m44f", &to_ndc)
}

const SAME: Space = Space::Seen(|n| n);
const AWAY: Space = Space::Seen(|n| DVec3::new(n.x, n.y, -n.z));
const LEFT: Space = Space::Seen(|n| DVec3::new(-n.x, n.y, n.z));
/// Tangent space of a picture: green down, encoded as 0..1.
const GREEN_DOWN: Space = Space::Seen(|n| 0.5 * DVec3::new(n.x, -n.y, n.z) + 0.5);
/// Right-handed, z up: the truth's own.
const Z_UP: Space = Space::In(|| DMat3::IDENTITY);
const Y_UP: Space = Space::In(y_up);
const LEFT_HANDED: Space = Space::In(left_handed);

// Measures of depth.

const PLANAR: Measure = |z, _| z;
const DISTANCE: Measure = |_, distance| distance;

// Cameras in attributes.

fn field_of_view() -> f64 {
    (2.0 * (0.5 * WIDTH as f64 / FOCAL).atan()).to_degrees()
}

/// Matrices of a camera that looks along -z, and picture coordinates from -1 to 1.
fn arnold_camera(part: Part) -> Part {
    let view = view_from(truth(), y_up());
    with_matrices(part, view, ndc_from_camera(true, -1.0), false)
}

/// Left-handed, +z forward.
fn forward() -> DAffine3 {
    DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)) * view_from(truth(), y_up())
}

/// Matrices as in the standard.
fn standard_camera(part: Part) -> Part {
    with_matrices(part, forward(), ndc_from_camera(false, 1.0), false)
}

fn pbrt_camera(part: Part) -> Part {
    with_matrices(part, forward(), ndc_from_camera(false, 1.0), true)
}

/// Normals of facets beside the shading normals.
fn pbrt_facets(part: Part) -> Part {
    let facet = |n: DVec3| DVec3::new(n.x + 0.3, n.y, -n.z).normalize();
    pbrt_camera(with_layer(
        part,
        ("N", XYZ, Half),
        &normals(DVec3::ZERO, facet),
    ))
}

fn vray_camera(part: Part) -> Part {
    let placed = DMat4::from(truth().camera.inverse());
    part.floats("cameraFov", "float", &[field_of_view()])
        .floats("cameraTransform", "m44f", &placed.to_cols_array())
}

/// The camera's own placing, looking along +z with x to the left.
fn redshift_camera(part: Part) -> Part {
    let turned = DAffine3::from_scale(DVec3::new(-1.0, 1.0, -1.0)) * view_from(truth(), y_up());
    let placed = DMat4::from(turned.inverse());
    part.floats("rs/camera/fov", "float", &[field_of_view()])
        .floats("rs/camera/transform", "m44f", &placed.to_cols_array())
}

/// As text, lengths in centimetres.
fn unreal_camera(part: Part) -> Part {
    let world = view_from(truth(), left_handed()).inverse();
    let (eye, ahead) = (world.translation * 100.0, -world.matrix3.z_axis);
    let (pitch, yaw) = (ahead.z.asin(), ahead.y.atan2(ahead.x));
    let camera = [
        ("curPos/x", eye.x),
        ("curPos/y", eye.y),
        ("curPos/z", eye.z),
        ("curRot/pitch", pitch.to_degrees()),
        ("curRot/yaw", yaw.to_degrees()),
        ("curRot/roll", 0.0),
        ("fov", field_of_view()),
    ];
    camera.into_iter().fold(part, |part, (name, value)| {
        let name = format!("unreal/camera/FinalImage/{name}");
        part.text(&name, &value.to_string())
    })
}

// The table.

fn file(
    renderer: &'static str,
    normal: Layer,
    space: Space,
    depth: Option<Depth>,
    read_as: ReadAs,
) -> File {
    File {
        renderer,
        normal,
        space,
        depth,
        position: None,
        in_parts: false,
        more: |part| part,
        read_as,
    }
}

fn read_as(space: NormalSpace, depth: StoredDepth, worst_deg: f64) -> ReadAs {
    ReadAs {
        space,
        flip: Flip::NONE,
        depth,
        worst_deg,
        unit: 1.0,
        is_placed: false,
    }
}

fn flipped(axis: char, read_as: ReadAs) -> ReadAs {
    let [x, y, z] = ['x', 'y', 'z'].map(|name| name == axis);
    ReadAs {
        flip: Flip { x, y, z },
        ..read_as
    }
}

use NormalSpace::{View, World};
use Stored::{Float, Half};
use StoredDepth::{Inverse, NormalizedNearIsOne, Planar, Ray, Relative, WhiteFar};

#[rustfmt::skip]
fn files() -> Vec<File> {
    const UNREAL: Layer = ("FinalImageMovieRenderQueue_WorldNormal", RGB, Half);
    const UNREAL_DEPTH: &[&str] = &[
        "FinalImageMovieRenderQueue_WorldDepth.R",
        "FinalImageMovieRenderQueue_WorldDepth.G",
        "FinalImageMovieRenderQueue_WorldDepth.B",
    ];
    let vray: Measure = |z, _| ((7.0 - z) / 3.0).clamp(0.0, 1.0);
    let corona: Measure = |z, _| ((z - 4.0) / 3.0).clamp(0.0, 1.0);
    let centimetres: Measure = |z, _| 100.0 * z;
    vec![
        file("Blender", ("ViewLayer.Normal", XYZ, Float), Z_UP, Some((&["ViewLayer.Depth.Z"], Float, 1e10, PLANAR)),
            read_as(World, Planar, POSITIONS_DEG)).with_position("ViewLayer.Position", XYZ).in_parts(),
        // The background of a half float.
        file("Blender, half depth", ("ViewLayer.Normal", XYZ, Float), Z_UP, Some((&["ViewLayer.Depth.Z"], Half, 65504.0, PLANAR)),
            read_as(World, Relative, DEPTH_DEG)).in_parts(),
        // The denoising passes of Cycles.
        file("Blender, denoising", ("ViewLayer.Denoising Normal", XYZ, Half), AWAY,
            Some((&["ViewLayer.Denoising Depth.Z"], Float, 1e10, PLANAR)), flipped('z', read_as(View, Planar, HALF_DEG))),
        file("Arnold", ("N", RGB, Float), Y_UP, Some((&["Z"], Float, 1e30, PLANAR)),
            read_as(World, Planar, FLOAT_DEG)).with(arnold_camera),
        file("Arnold, positions", ("N", RGB, Float), Y_UP, Some((&["Z"], Float, 1e30, PLANAR)),
            ReadAs { is_placed: true, ..read_as(World, Planar, FLOAT_DEG) }).with(arnold_camera).with_position("P", RGB),
        // The same as passed on by Nuke, without matrices.
        file("Arnold, nothing stated", ("N", RGB, Float), Y_UP, Some((&["Z"], Float, 1e30, PLANAR)),
            read_as(World, Planar, DEPTH_DEG)),
        file("RenderMan", ("__Nworld", RGB_LOWER, Float), Y_UP, Some((&["__depth.r"], Float, f64::INFINITY, PLANAR)),
            read_as(World, Planar, FLOAT_DEG)).with(standard_camera),
        file("RenderMan, positions", ("__Nworld", RGB_LOWER, Float), Y_UP, Some((&["__depth.r"], Float, f64::INFINITY, PLANAR)),
            read_as(World, Planar, FLOAT_DEG)).with(standard_camera).with_position("__Pworld", RGB_LOWER),
        // No depth, so from P.Z.
        file("pbrt", ("Ns", XYZ, Half), AWAY, None,
            flipped('z', read_as(View, Planar, HALF_DEG))).with(pbrt_facets).with_position("P", XYZ),
        file("pbrt, world", ("Ns", XYZ, Half), Y_UP, None,
            read_as(World, Planar, HALF_DEG)).with(pbrt_camera).with_position("P", XYZ),
        file("V-Ray", ("normals", XYZ, Float), LEFT, Some((&["zDepth.Z"], Float, 0.0, vray)),
            flipped('x', read_as(View, NormalizedNearIsOne, FLOAT_DEG))).with(vray_camera),
        file("Redshift", ("N", RGB, Float), Y_UP, Some((&["Z"], Float, 0.0, PLANAR)),
            read_as(World, Planar, FLOAT_DEG)).with(redshift_camera),
        file("Karma", ("ray:hitN", RGB_LOWER, Float), Y_UP, Some((&["ray:hitPz"], Float, 0.0, PLANAR)),
            read_as(World, Planar, POSITIONS_DEG)).with_position("ray:hitP", RGB_LOWER),
        file("Karma, ray length", ("ray:hitN", RGB_LOWER, Float), Y_UP, Some((&["ray:hitdist"], Float, 0.0, DISTANCE)),
            read_as(World, Ray, DEPTH_DEG)),
        file("Mantra", ("N", ["x", "y", "z"], Half), SAME, Some((&["Pz"], Float, 0.0, PLANAR)),
            read_as(View, Planar, HALF_DEG)),
        // A distance in shares of the largest one.
        file("Octane", ("ShadingNormals", RGB, Float), SAME, Some((&["Depth.R"], Float, 1.0, |_, distance| distance / 20.0)),
            ReadAs { unit: 1.0 / 20.0, ..read_as(View, Ray, FLOAT_DEG) }),
        file("Corona", ("CGeometry_NormalsShading", RGB, Half), SAME, Some((&["CGeometry_ZDepth.R"], Half, 1.0, corona)),
            read_as(View, WhiteFar, HALF_DEG)),
        file("Mitsuba", ("sh_normal", XYZ, Float), Y_UP, Some((&["depth.T"], Float, 0.0, DISTANCE)),
            read_as(World, Ray, POSITIONS_DEG)).with_position("position", XYZ),
        file("Nuke", ("N", ["red", "green", "blue"], Float), SAME, Some((&["depth.Z"], Float, 0.0, |z, _| 1.0 / z)),
            read_as(View, Inverse, FLOAT_DEG)),
        file("Nuke, world", ("N", ["red", "green", "blue"], Float), Y_UP, Some((&["depth.Z"], Float, 0.0, |z, _| 1.0 / z)),
            read_as(World, Inverse, DEPTH_DEG)),
        file("Unreal", UNREAL, LEFT_HANDED, Some((UNREAL_DEPTH, Half, 65504.0, centimetres)),
            read_as(World, Relative, HALF_DEG)).with(unreal_camera),
        file("Unreal, nothing stated", UNREAL, LEFT_HANDED, Some((UNREAL_DEPTH, Half, 65504.0, centimetres)),
            read_as(World, Relative, HALF_DEG + DEPTH_DEG)),
        file("DirectX", ("normal", RGB, Half), GREEN_DOWN, Some((&["Z"], Float, 0.0, PLANAR)),
            flipped('y', read_as(View, Planar, ENCODED_HALF_DEG))),
        // Maps of game tools: depth in shades of grey in either direction, which no name tells.
        file("DirectX, white near", ("normal", RGB, Half), GREEN_DOWN, Some((&["Z"], Float, 0.0, vray)),
            flipped('y', read_as(View, NormalizedNearIsOne, ENCODED_HALF_DEG))),
        file("DirectX, white far", ("normal", RGB, Half), GREEN_DOWN, Some((&["Z"], Float, 1.0, corona)),
            flipped('y', read_as(View, WhiteFar, ENCODED_HALF_DEG))),
        file("OpenGL, white near", ("normal", RGB, Half), SAME, Some((&["Z"], Float, 0.0, vray)),
            read_as(View, NormalizedNearIsOne, HALF_DEG)),
        file("OpenGL, white far", ("normal", RGB, Half), SAME, Some((&["Z"], Float, 1.0, corona)),
            read_as(View, WhiteFar, HALF_DEG)),
    ]
}

#[test]
fn files_of_every_renderer_give_the_same_frame() {
    files().iter().for_each(File::check);
}
