//! Layers with names in no table: found by the words of their names, else by their numbers.

use crate::common::exr::{Part, Stored, write};
use crate::common::files::{load, try_load};
use crate::prelude::*;
use relievo::io::roles::Role;
use relievo::io::survey;
use std::path::Path;

const SIZE: [usize; 2] = [96, 80];

/// The layers of a torus, leaning and in perspective, each with its components.
struct Scene {
    exact: ExactScene,
    normal: [Plane; 3],
    depth: Plane,
    position: [Plane; 3],
}

impl Scene {
    fn new() -> Self {
        let axis = glam::DVec3::new(0.3, 0.5, 0.8).normalize();
        let exact = ExactScene::orthographic(Surface::torus(25.0, 12.0, axis), 48.0, 40.0);
        let exact = exact.in_perspective();
        let plane = |value: &dyn Fn(&Exact) -> f64, nothing: f32| {
            let of = |seen: Exact| value(&seen) as f32;
            let at = |x, y| exact.exact(x, y).map_or(nothing, of);
            Plane::from_fn(SIZE[0], SIZE[1], at)
        };
        Self {
            normal: [0, 1, 2].map(|axis| plane(&|seen| seen.normal[axis], 0.0)),
            depth: plane(&|seen| seen.depth, 1e10),
            position: [0, 1, 2].map(|axis| plane(&|seen| seen.point[axis], 0.0)),
            exact,
        }
    }

    /// The parts of a file whose layers have these names: of normals, depth, positions.
    fn parts(&self, names: &[String; 3], in_parts: bool) -> Vec<Part> {
        let grey = Plane::filled(SIZE[0], SIZE[1], 0.5);
        let mut parts = vec![Part::of(["R", "G", "B"].map(|name| (name, &grey)))];
        let depth = std::slice::from_ref(&self.depth);
        for (name, planes) in names.iter().zip([&self.normal[..], depth, &self.position]) {
            if in_parts {
                let window = parts[0].window;
                parts.push(Part::new(window).named(name));
            }
            let components = if planes.len() == 1 {
                &["V"][..]
            } else {
                &["X", "Y", "Z"]
            };
            let part = parts.last_mut().unwrap();
            for (component, plane) in components.iter().zip(planes) {
                let layer = if in_parts {
                    String::new()
                } else {
                    format!("{name}.")
                };
                let channel = (format!("{layer}{component}"), Stored::Float, plane.clone());
                part.channels.push(channel);
            }
        }
        parts[0].name = in_parts.then(|| "main".into());
        parts
    }

    /// The largest angle, in degrees, that normals away from the rim are off.
    fn worst_angle(&self, loaded: &Loaded) -> f64 {
        let off = places(SIZE[0], SIZE[1]).filter_map(|(x, y)| {
            let seen = self.exact.exact(x, y)?;
            let found = loaded.frame.normal.at(x, y);
            Some(found.angle_between(seen.normal).to_degrees())
        });
        largest(off)
    }
}

fn write_parts(path: &Path, parts: &[Part]) {
    write(path, Window::from_size(SIZE[0], SIZE[1]), parts);
}

/// The layers that play these roles.
fn layers(path: &Path, roles: [Role; 3]) -> [Option<String>; 3] {
    let inputs = default_but(|inputs: &mut Inputs| inputs.picture = path.into());
    let survey = survey(&inputs).unwrap();
    roles.map(|role| {
        let found = survey.roles.iter().find(|found| found.role == role)?;
        Some(found.layer.clone())
    })
}

const ROLES: [Role; 3] = [Role::Normal, Role::Depth, Role::Position];

fn capital(word: &str) -> String {
    let (first, rest) = word.split_at(1);
    first.to_uppercase() + rest
}

/// Ten ways to put a word that goes with a role and the word for the role into one name.
const STYLES: [fn(&str, &str) -> String; 10] = [
    |with, role| format!("{with}{}", capital(role)),
    |with, role| format!("{role}_{with}"),
    |with, role| format!("rs_{with}_{role}"),
    |with, role| format!("AI_{}_{}", role.to_uppercase(), with.to_uppercase()),
    |with, role| format!("vray{}{}", capital(with), capital(role)),
    |with, role| format!("mtl {role} {with}"),
    |with, role| format!("{with}_{role}_v2"),
    |with, role| format!("{}{}.001", capital(with), capital(role)),
    |with, role| format!("karma:{role}-{with}"),
    |with, role| format!("Octane {} {}", capital(with), capital(role)),
];

#[test]
fn twenty_invented_names_are_read_without_a_flag() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("layers.exr");
    let scene = Scene::new();
    let mut seed = 1u32;
    let mut pick = |words: &[&'static str]| {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        words[(seed >> 16) as usize % words.len()]
    };
    for round in 0..20 {
        let style = STYLES[round % 10];
        let with = ["cam", "camera", "world", "shading", "smooth", "geo"];
        let names = [
            ["normal", "normals", "n", "nrm"],
            ["depth", "z", "zdepth", "zbuffer"],
            ["position", "pos", "p", "point"],
        ]
        .map(|roles| style(pick(&with), pick(&roles)));
        // The last style names parts, whose channels have no names of their own.
        write_parts(&path, &scene.parts(&names, round % 10 == 9));
        assert_eq!(layers(&path, ROLES), names.clone().map(Some), "{names:?}");
        let loaded = load(&path, |_, _| ());
        // Floats, turned by a camera that is recovered to a hundredth of a degree.
        assert!(scene.worst_angle(&loaded) < 0.1, "{names:?}");
    }
}

#[test]
fn numbers_tell_what_names_do_not() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("layers.exr");
    let scene = Scene::new();
    let [a, b, c] = ["a", "b", "c"].map(String::from);
    let mut part = scene.parts(&[b, c, a], false).remove(0);
    // Masks of three colours are of unit length too, and other colours are not.
    let mask = |i: usize| Plane::from_fn(SIZE[0], SIZE[1], |x, _| f32::from(x / 32 == i));
    let color = |i: u32| Plane::from_fn(SIZE[0], SIZE[1], |x, y| noise(x, y, i));
    for (i, component) in ["R", "G", "B"].into_iter().enumerate() {
        part = part
            .channel(&format!("d.{component}"), Stored::Float, &mask(i))
            .channel(&format!("e.{component}"), Stored::Half, &color(i as u32));
    }
    // So are the masks of one channel, which are no depth.
    part = part.channel("f.V", Stored::Float, &mask(1));
    part.write(&path);
    let found = layers(&path, ROLES);
    assert_eq!(found, ["b", "c", "a"].map(|name| Some(name.to_string())));
    let loaded = load(&path, |_, _| ());
    assert!(scene.worst_angle(&loaded) < 0.1);
    let why = |subject: &str| {
        let mut findings = loaded.findings.iter();
        &findings.find(|f| f.subject == subject).unwrap().evidence
    };
    assert_eq!(why("normal"), "by numbers: 100 % are of unit length");
    assert!(why("depth").starts_with("by numbers: "));

    // The same normals as 0..1, alone.
    let encoded = scene
        .normal
        .each_ref()
        .map(|plane| plane.map(|v| 0.5 * v + 0.5));
    Part::of(["b.R", "b.G", "b.B"].into_iter().zip(&encoded)).write(&path);
    assert!(scene.worst_angle(&load(&path, |_, _| ())) < 0.1);
}

#[test]
fn a_file_without_normals_names_the_nearest_layer() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("layers.exr");
    let refused =
        |name: &str, [width, height]: [usize; 2], value: &dyn Fn(usize, usize, u32) -> f32| {
            let planes = [0, 1, 2].map(|i| Plane::from_fn(width, height, |x, y| value(x, y, i)));
            let names = ["R", "G", "B"].map(|component| format!("{name}.{component}"));
            Part::of(names.iter().zip(&planes)).write(&path);
            try_load(&path, |_, _| ()).err().expect(name).to_string()
        };
    let remedy = "name one with --normal LAYER or --normal FILE, or depth with --depth LAYER|FILE";
    let line = refused("object_nromal", SIZE, &noise);
    let nearest = "has no normal layer (found object_nromal); did you mean object_nromal?";
    assert!(line.ends_with(&format!("{nearest} {remedy}")), "{line}");
    // Names with another meaning are not guessed at, and layers without numbers, with one, or all alike give no
    // evidence.
    for (size, value) in [
        (SIZE, f32::NAN),
        (SIZE, f32::INFINITY),
        (SIZE, 0.0),
        (SIZE, 3f32.sqrt().recip()),
        ([1, 1], 3f32.sqrt().recip()),
    ] {
        let line = refused("q", size, &|_, _, _| value);
        assert!(line.ends_with(&format!("(found q); {remedy}")), "{line}");
    }
}

#[test]
fn none_leaves_a_layer_out() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("layers.exr");
    let names = ["N", "depth", "P"].map(String::from);
    write_parts(&path, &Scene::new().parts(&names, false));
    let none = || Some(Inputs::NONE.to_string());
    let with = |change: &dyn Fn(&mut Inputs)| try_load(&path, |inputs, _| change(inputs));
    let has_depth = |change: &dyn Fn(&mut Inputs)| with(change).unwrap().frame.depth.is_some();
    // Positions replace depth unless they are left out too.
    assert!(has_depth(&|inputs| inputs.depth = none()));
    assert!(!has_depth(
        &|inputs| (inputs.depth, inputs.position) = (none(), none())
    ));
    assert!(has_depth(&|inputs| inputs.occlusion = none()));
    let refused = with(&|inputs| inputs.normal = none()).err().unwrap();
    let refused = refused.to_string();
    assert!(refused.contains("no normal called none"), "{refused}");
}
