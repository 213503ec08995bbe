//! Frames from samples in memory: equal to those from files bit for bit, in any layout, and refused with a reason.

use crate::common::exr::channel;
use crate::common::files::load;
use crate::common::program::fixture;
use crate::prelude::*;
use half::f16;
use ndarray::{Array3, ArrayView3, Axis, ShapeBuilder};
use relievo::io::exr::{OutputChannel, OutputPart, OutputType, write_results};
use std::collections::BTreeMap;
use std::path::Path;

/// All planes of a frame, by name.
fn planes(frame: &Frame) -> Vec<(String, Plane)> {
    let of_color = |name: &str, color: &Option<ColorPlanes>| {
        let planes = color.iter().flat_map(channels).enumerate();
        let named = planes.map(|(i, plane)| (format!("{name}.{i}"), plane.clone()));
        named.collect::<Vec<_>>()
    };
    let singles = [
        ("normal.x", Some(&frame.normal.x)),
        ("normal.y", Some(&frame.normal.y)),
        ("normal.z", Some(&frame.normal.z)),
        ("normal_length", frame.normal_length.as_ref()),
        ("depth", frame.depth.as_ref()),
        ("occlusion", frame.occlusion.as_ref()),
        ("importance", frame.importance.as_ref()),
        ("alpha", frame.alpha.as_ref()),
        ("light.occlusion", frame.light.occlusion.as_ref()),
    ];
    let there = |(name, plane): (&str, Option<&Plane>)| Some((name.into(), plane?.clone()));
    let mut all: Vec<(String, Plane)> = singles.into_iter().filter_map(there).collect();
    let mask = frame.mask.plane().map(|c| f32::from(u8::from(c)));
    all.push(("mask".into(), mask));
    all.extend(of_color("color", &frame.color));
    all.extend(of_color("albedo", &frame.albedo));
    for lobe in &frame.light.lobes {
        let layers = [&lobe.direct, &lobe.indirect, &lobe.color, &lobe.albedo];
        for (i, color) in layers.into_iter().enumerate() {
            all.extend(of_color(&format!("{}.{i}", lobe.lobe.name()), color));
        }
    }
    for group in &frame.light.groups {
        all.extend(of_color(&group.name, &Some(group.light.clone())));
    }
    all
}

fn assert_same(built: &Frame, read: &Frame) {
    let (built_planes, read_planes) = (planes(built), planes(read));
    assert_eq!(built_planes.len(), read_planes.len());
    for ((name, a), (same_name, b)) in built_planes.iter().zip(&read_planes) {
        assert_eq!((name, a.width()), (same_name, b.width()));
        assert!(bits(a) == bits(b), "{name} differs");
    }
    assert_eq!(built.data_window, read.data_window);
    assert_eq!(built.display_window, read.display_window);
    assert_eq!(built.pixel_aspect, read.pixel_aspect);
    assert_eq!(built.camera, read.camera);
    assert_eq!(built.source.depth_kind, read.source.depth_kind);
    assert_eq!(built.source.normal_rounding, read.source.normal_rounding);
    assert_eq!(built.luminance_weights(), read.luminance_weights());
}

#[test]
fn a_frame_of_memory_is_that_of_the_file() {
    for name in ["bust", "gears", "mirror"] {
        let picture = fixture(&format!("{name}.exr"));
        let read = load(&picture, |inputs, needs| {
            inputs.camera = Some(picture.with_extension("camera.json"));
            (needs.color, needs.projection) = (true, true);
        });
        let (conventions, frame) = (read.conventions, &read.frame);
        assert_eq!(conventions.normal_space, NormalSpace::World);
        assert_eq!(conventions.normal_encoding, NormalEncoding::Signed);

        let layer = |name: &str, components: [&str; 3]| {
            components.map(|c| channel(&picture, &format!("ViewLayer.{name}.{c}")))
        };
        let (width, height) = (frame.mask.width(), frame.mask.height());
        let camera = frame.camera.unwrap();
        let [normals, color] = [("Normal", ["X", "Y", "Z"]), ("Combined", ["R", "G", "B"])]
            .map(|(name, components)| layer(name, components));
        let [depth, alpha] =
            ["ViewLayer.Depth.Z", "ViewLayer.Combined.A"].map(|n| channel(&picture, n));
        let normals = Normals::world(normals.each_ref(), &camera);
        let built = Frame::builder(width, height)
            .normals(normals.flipped(conventions.normal_flip))
            .depth(&depth, conventions.depth_kind.unwrap())
            .color(color.each_ref())
            .alpha(&alpha)
            .build()
            .unwrap();
        assert_same(&built, frame);
    }
}

const WIDTH: usize = 37;
const HEIGHT: usize = 23;

/// A plane of values of no meaning, some of them not finite.
fn hostile(seed: u32) -> Plane {
    let mut state = seed;
    Plane::from_fn(WIDTH, HEIGHT, |_, _| {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        match (state >> 20) % 40 {
            0 => f32::NAN,
            1 => f32::INFINITY,
            2 => f32::NEG_INFINITY,
            3 => -0.0,
            4 => 1e10,
            5 => 65504.0,
            _ => (state >> 8) as f32 / (1 << 24) as f32 * 2.0 - 1.0,
        }
    })
}

fn camera() -> Camera {
    let turn = DMat3::from_rotation_y(0.4) * DMat3::from_rotation_x(-0.7);
    let [fx, fy, cx, cy] = [40.0, 40.0, 18.0, 11.0];
    Camera {
        view_from_world: DAffine3::from_mat3_translation(turn, DVec3::new(0.5, -0.25, -4.0)),
        projection: Projection::Perspective { fx, fy, cx, cy },
    }
}

/// Content of a hostile file, and the builder's equivalent.
struct Case {
    layers: BTreeMap<&'static str, Plane>,
    /// The same, where they are stored so.
    halves: Option<BTreeMap<&'static str, Vec<f16>>>,
    space: NormalSpace,
    encoding: NormalEncoding,
    flip: Flip,
    depth: Option<StoredDepth>,
}

const ORIGIN: [i32; 2] = [-3, 5];

fn display() -> Window {
    Window::from_size(31, 31)
}

impl Case {
    fn one(&self, name: &str) -> Samples<'_> {
        match &self.halves {
            Some(halves) => (&halves[name]).into(),
            None => (&self.layers[name]).into(),
        }
    }

    fn three(&self, layer: &str, components: [&str; 3]) -> Samples<'_> {
        let names = components.map(|c| format!("{layer}.{c}"));
        let names = names.each_ref().map(|name| name.as_str());
        match &self.halves {
            Some(halves) => names.map(|name| &halves[name][..]).into(),
            None => names.map(|name| &self.layers[name]).into(),
        }
    }

    /// Writes the layers, and loads them.
    fn read(&self, path: &Path) -> Frame {
        let channels = self.layers.iter().map(|(name, plane)| OutputChannel {
            name: (*name).into(),
            plane,
            sample_type: match self.halves {
                Some(_) => OutputType::Half,
                None => OutputType::Float,
            },
        });
        let part = OutputPart {
            name: "main".into(),
            data_window: Window::at(ORIGIN[0], ORIGIN[1], WIDTH, HEIGHT),
            display_window: display(),
            pixel_aspect: 1.25,
            channels: channels.collect(),
            attributes: Vec::new(),
            chromaticities: None,
            compression: Default::default(),
        };
        let mut file = std::fs::File::create(path).unwrap();
        write_results(&mut file, path, &part).unwrap();
        let loaded = load(path, |inputs, needs| {
            inputs.normal_space = Some(self.space);
            inputs.normal_encoding = Some(self.encoding);
            inputs.normal_flip = Some(self.flip);
            inputs.depth_kind = self.depth;
            inputs.importance = Some("importance".into());
            // Its sum is not the picture.
            inputs.light = Some(LightInputs {
                lobes: LobeChoice::On,
                occlusion: true,
                ..LightInputs::default()
            });
            inputs.known_camera = Some(KnownCamera {
                camera: camera(),
                is_placed: true,
            });
            (needs.color, needs.albedo, needs.projection) = (true, true, true);
        });
        loaded.frame
    }

    /// Builds the same frame from what is written.
    fn build(&self) -> Frame {
        let rgb = |name: &str| self.three(name, ["R", "G", "B"]);
        let normals = self.three("N", ["X", "Y", "Z"]);
        let mut normals = match self.space {
            NormalSpace::View => Normals::view(normals),
            NormalSpace::World => Normals::world(normals, &camera()),
            NormalSpace::Sight => Normals::sight(normals, &camera()),
        };
        if self.encoding == NormalEncoding::Unsigned {
            normals = normals.unsigned();
        }
        let mut builder = Frame::builder(WIDTH, HEIGHT)
            .origin(ORIGIN[0], ORIGIN[1])
            .display_window(display())
            .pixel_aspect(1.25)
            .camera(&camera())
            .normals(normals.flipped(self.flip))
            .color(rgb("C"))
            .alpha(self.one("C.A"))
            .albedo(rgb("albedo"))
            .importance(self.one("importance"))
            .lobe(Lobe::Diffuse, LobeLayer::Direct, rgb("diffuse_direct"))
            .lobe(Lobe::Diffuse, LobeLayer::Indirect, rgb("diffuse_indirect"))
            .lobe(Lobe::Diffuse, LobeLayer::Albedo, rgb("albedo"))
            .lobe(Lobe::Specular, LobeLayer::Direct, rgb("specular"))
            .light_occlusion(self.one("AO.R"));
        builder = match self.depth {
            Some(stored) => builder.depth(self.one("Z"), stored),
            None => builder
                .position(self.three("P", ["X", "Y", "Z"]))
                .occlusion(self.one("AO.R")),
        };
        builder.build().unwrap()
    }
}

fn cases() -> Vec<Case> {
    let layers = |place: &[&'static str]| -> BTreeMap<&'static str, Plane> {
        #[rustfmt::skip]
        let names = [
            "AO.R", "C.A", "C.B", "C.G", "C.R", "N.X", "N.Y", "N.Z", "albedo.B", "albedo.G", "albedo.R",
            "diffuse_direct.B", "diffuse_direct.G", "diffuse_direct.R",
            "diffuse_indirect.B", "diffuse_indirect.G", "diffuse_indirect.R",
            "importance", "specular.B", "specular.G", "specular.R",
        ];
        let names = names.iter().chain(place);
        let hostile = |(i, name): (usize, &&'static str)| (*name, hostile(i as u32 + 1));
        names.enumerate().map(hostile).collect()
    };
    // Heights take the place of normals in files.
    let kinds = StoredDepth::ALL.into_iter().map(|(kind, _)| kind);
    let kinds = kinds.filter(|kind| *kind != StoredDepth::Height).map(Some);
    let kinds = kinds.chain([None]).enumerate();
    let of_kind = |(i, depth): (usize, Option<StoredDepth>)| Case {
        layers: layers(match depth {
            Some(_) => &["Z"],
            None => &["P.X", "P.Y", "P.Z"],
        }),
        halves: None,
        space: [NormalSpace::View, NormalSpace::World][i % 2],
        encoding: [NormalEncoding::Signed, NormalEncoding::Unsigned][i / 2 % 2],
        flip: Flip {
            x: i == 2,
            y: i % 3 == 1,
            z: i == 5,
        },
        depth,
    };
    let mut cases: Vec<Case> = kinds.map(of_kind).collect();
    // Files hold no more than 65504, which is finite.
    let in_half = |&v: &f32| f16::from_f32(if v == 1e10 { 65504.0 } else { v });
    let halves = |plane: &Plane| plane.samples().iter().map(in_half).collect();
    let half = layers(&["Z"]);
    let stored = half.iter().map(|(name, plane)| (*name, halves(plane)));
    cases.push(Case {
        halves: Some(stored.collect()),
        layers: half,
        space: NormalSpace::World,
        encoding: NormalEncoding::Signed,
        flip: Flip::NONE,
        depth: Some(StoredDepth::Inverse),
    });
    cases
}

#[test]
fn hostile_samples_are_sanitised_as_those_of_files() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("hostile.exr");
    for case in cases() {
        let read = case.read(&path);
        assert!(read.mask.count() > WIDTH, "{}", read.mask.count());
        let mut built = case.build();
        if case.depth.is_none() {
            // For a file the normals decide whether positions are places; these are not.
            assert_eq!(built.source.depth_kind, DepthKind::Planar);
            built.source.depth_kind = read.source.depth_kind;
        }
        let all = planes(&built);
        for (name, plane) in &all {
            let is_given = ["occlusion", "importance"].contains(&name.as_str());
            let all_finite = plane.samples().iter().all(|v| v.is_finite());
            assert!(all_finite || is_given, "{name} is not finite");
        }
        assert_same(&built, &read);
    }
}

/// A few normals and depths, for every layout.
fn ramp() -> [Plane; 3] {
    [0.25, 0.5, 1.0].map(|step| {
        let at = |x, y| ((1 + x + 5 * y) as f32 * step).rem_euclid(1.0) + 0.1;
        Plane::from_fn(5, 4, at)
    })
}

fn built<'a>(normals: impl Into<Samples<'a>>) -> Frame {
    let builder = Frame::builder(5, 4).normals(Normals::view(normals));
    builder.build().unwrap()
}

#[test]
fn every_layout_makes_the_same_frame() {
    let [x, y, z] = &ramp();
    let expected = built([x, y, z]);
    // Planar slices.
    assert_same(&built([x.samples(), y.samples(), z.samples()]), &expected);
    // Interleaved, of three channels and of four.
    let interleaved = |channels: usize| -> Vec<f32> {
        let pixels = 0..20;
        let pixel = |i: usize| [x, y, z, x].map(|plane| plane.samples()[i]);
        let samples = pixels.flat_map(|i| pixel(i).into_iter().take(channels));
        samples.collect()
    };
    assert_same(&built(&interleaved(3)), &expected);
    assert_same(&built(&interleaved(4)), &expected);
    // Rows of four channels that run up, with seven samples of padding.
    let stride = 4 * 5 + 7;
    let mut padded = vec![f32::NAN; 3 + stride * 4];
    for (row, samples) in interleaved(4).chunks(20).rev().enumerate() {
        padded[3 + row * stride..][..20].copy_from_slice(samples);
    }
    let layout = (4, 5, 3).strides((stride, 4, 1));
    let mut upward = ArrayView3::from_shape(layout, &padded[3..]).unwrap();
    upward.invert_axis(Axis(0));
    assert_same(&built(upward), &expected);
    // Arrays: interleaved, stacked planes, columns before rows.
    let array = Array3::from_shape_vec((4, 5, 3), interleaved(3)).unwrap();
    assert_same(&built(&array), &expected);
    let stacked = [x, y, z].map(|plane| plane.samples()).concat();
    let stacked = ArrayView3::from_shape((3, 4, 5), &stacked).unwrap();
    assert_same(&built(stacked.permuted_axes([1, 2, 0])), &expected);
    let mut turned = array.clone();
    turned.invert_axis(Axis(0));
    let mut reversed = turned.as_standard_layout().to_owned();
    reversed.invert_axis(Axis(0));
    assert_same(&built(&reversed), &expected);
}

#[test]
fn integers_are_read_as_those_of_photos() {
    let photo = fixture("tablet.normal.png");
    let read = load(fixture("tablet.color.jpg"), |inputs, _| {
        inputs.normal = Some(photo.to_str().unwrap().into());
    });
    let stored = image::open(&photo).unwrap().into_rgb8();
    let (width, height) = (stored.width() as usize, stored.height() as usize);
    let normals = Normals::view(stored.as_raw()).unsigned();
    let mut built = Frame::builder(width, height)
        .normals(normals.flipped(read.conventions.normal_flip))
        .build()
        .unwrap();
    // The file's picture is read for its coverage; memory has none.
    built.color.clone_from(&read.frame.color);
    assert_same(&built, &read.frame);
    // 16 bits and half floats give the same, to their precision, except that the steps of 8 bits remain: the smoothest
    // normals with these codes are up to half a step of 2/255 away.
    let wide: Vec<u16> = stored.iter().map(|&v| u16::from(v) * 257).collect();
    let in_half = |&v: &u8| f16::from_f32(f32::from(v) / 255.0);
    let half: Vec<f16> = stored.iter().map(in_half).collect();
    for normals in [Normals::view(&wide), Normals::view(&half)] {
        let other = Frame::builder(width, height)
            .normals(normals.unsigned().flipped(read.conventions.normal_flip))
            .build()
            .unwrap();
        let (a, b) = (other.normal.x.samples(), built.normal.x.samples());
        let bound = 1.0 / 255.0 + 2e-3;
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < bound));
    }
}

#[test]
fn what_does_not_fit_is_refused_by_name() {
    let normals = [0.0_f32, 0.0, 1.0].repeat(20);
    let (depth, bytes) = (vec![1.0_f32; 20], vec![1_u8; 60]);
    let good = || Frame::builder(5, 4).normals(Normals::view(&normals));
    assert!(good().build().is_ok());
    let (mut tilted, mut flat) = (camera(), camera());
    tilted.view_from_world = DAffine3::from_scale(DVec3::splat(2.0));
    let [fx, fy, cx, cy] = [0.0, 1.0, 0.0, 0.0];
    flat.projection = Projection::Perspective { fx, fy, cx, cy };
    let planar = StoredDepth::Planar;
    let turned = Plane::filled(4, 5, 1.0_f32);
    #[rustfmt::skip]
    let refused = [
        (Frame::builder(5, 4), "normals are missing; give them with normals()"),
        (Frame::builder(0, 4), "a frame of 0x4 pixels from (0, 0) cannot be; give at least one pixel, and coordinates below 2^31"),
        (good().normals(Normals::view(&normals[1..])),
            "normals holds 59 samples for 5x4 pixels; give 3 or 4 for each pixel, or a view where there are gaps"),
        (good().normals(Normals::view([&depth[..], &depth])), "normals has 2 channels; give 3 or 4"),
        (good().depth(&depth[..19], planar),
            "depth holds 19 samples for 5x4 pixels; give 1 for each pixel, or a view where there are gaps"),
        (good().depth(&turned, planar),
            "depth is 5 rows of 4, for 5x4 pixels; give an array indexed [row, column] of the frame's size"),
        (good().color(&bytes),
            "color holds integers, which are rarely linear light; decode it, as with io::srgb::decoded, and give f32"),
        (good().position(&normals),
            "position is in world space, and there is no camera; give one with camera(), or depth instead"),
        (good().camera(&camera()).normals(Normals::world(&normals, &flat)), "camera is another than that of the normals; give one of them"),
        (good().camera(&flat), "camera cannot be used: its focal length is 0 px; give 0.01 to 1e9"),
        (good().camera(&tilted),
            "camera cannot be used: its axes are not of unit length and square to each other; give a rotation and a translation without scale or shear"),
        (good().pixel_aspect(f32::NAN), "pixel_aspect is NaN; give 0.001 to 1000"),
        (good().display_window(Window::from_size(0, 4)),
            "display_window is 0x4 at (0, 0); give one that is at least a pixel wide and high"),
        (good().luminance_weights([1.0, 1.0, 1.0]),
            "luminance_weights are [1.0, 1.0, 1.0]; give three that are not negative and add up to 1"),
        (good().light_group("key", &normals, [Vec3::splat(1.0)]),
            "light_group key has no directions of unit length to its lights; give at least one, in view space"),
    ];
    for (builder, expected) in refused {
        let refusal = builder.build().expect_err("refused").to_string();
        assert_eq!(refusal, expected);
    }
    let empty = LightLayers::default();
    assert_eq!(good().build().unwrap().light, empty);
}
