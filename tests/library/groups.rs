//! Groups of layers, such as view layers: one is read, and nothing of the others.

use crate::common::exr::{Part, write};
use crate::prelude::*;
use relievo::io::{load, survey};
use std::path::{Path, PathBuf};

/// A layer: its name, its components, and the value of each.
type Layer = (&'static str, &'static str, [f32; 4]);

/// Light of (.2, .4, .6) on a surface of .5 is the picture.
const FG: [Layer; 5] = [
    ("Combined", "RGBA", [0.1, 0.2, 0.3, 1.0]),
    ("Normal", "XYZ", [0.6, 0.0, 0.8, 0.0]),
    ("Depth", "Z", [10.0; 4]),
    ("DiffDir", "RGB", [0.2, 0.4, 0.6, 0.0]),
    ("DiffCol", "RGB", [0.5; 4]),
];
const BG: [Layer; 4] = [
    ("Combined", "RGBA", [0.9, 0.8, 0.7, 1.0]),
    ("Normal", "XYZ", [0.0, 0.6, 0.8, 0.0]),
    ("Depth", "Z", [20.0; 4]),
    ("GlossDir", "RGB", [0.3; 4]),
];
/// Plain layers: occlusion is of both groups, and depth of neither.
const PLAIN: [Layer; 2] = [("AO", "RGB", [0.75; 4]), ("Depth", "Z", [30.0; 4])];

/// The channels of `layers`, called `prefix` and their layer; those of `bare` layers by their components alone.
fn channels(prefix: &str, layers: &[Layer], bare: &[&str]) -> Vec<(String, Plane)> {
    let of_layer = |&(name, components, values): &Layer| {
        let named = |(component, value): (char, f32)| {
            let name = match bare.contains(&name) {
                true => component.to_string(),
                false => format!("{prefix}{name}.{component}"),
            };
            (name, Plane::filled(8, 6, value))
        };
        let channels = components.chars().zip(values).map(named);
        channels.collect::<Vec<_>>()
    };
    layers.iter().flat_map(of_layer).collect()
}

fn part(name: &str, channels: &[(String, Plane)]) -> Part {
    let part = Part::of(channels.iter().map(|(name, plane)| (name, plane)));
    match name {
        "" => part,
        name => part.named(name),
    }
}

fn file(path: PathBuf, parts: &[Part]) -> PathBuf {
    write(&path, Window::from_size(8, 6), parts);
    path
}

fn inputs(path: &Path, layer: Option<&str>) -> Inputs {
    Inputs {
        picture: path.into(),
        layer: layer.map(String::from),
        normal_space: Some(NormalSpace::View),
        normal_encoding: Some(NormalEncoding::Signed),
        depth_kind: Some(StoredDepth::Planar),
        light: Some(LightInputs {
            occlusion: true,
            ..LightInputs::default()
        }),
        ..Inputs::default()
    }
}

fn read(inputs: &Inputs) -> Loaded {
    load(inputs, default_but(|needs: &mut Needs| needs.color = true)).unwrap()
}

/// The first sample of everything that was read, and where it is read from.
fn samples(loaded: &Loaded) -> Vec<(&'static str, f32)> {
    let frame = &loaded.frame;
    let color = frame.color.as_ref().unwrap();
    let mut all = vec![
        ("normal x", Some(&frame.normal.x)),
        ("normal y", Some(&frame.normal.y)),
        ("depth", frame.depth.as_ref()),
        ("red", Some(&color.r)),
        ("green", Some(&color.g)),
        ("alpha", frame.alpha.as_ref()),
        ("occlusion", frame.light.occlusion.as_ref()),
    ];
    for lobe in &frame.light.lobes {
        let layers = [("direct", &lobe.direct), ("surface", &lobe.color)];
        all.extend(layers.map(|(name, planes)| (name, planes.as_ref().map(|p| &p.g))));
    }
    let first = |(name, plane): (_, Option<&Plane>)| Some((name, plane?.at(0, 0)));
    all.into_iter().filter_map(first).collect()
}

#[test]
fn all_layers_come_from_one_group_and_plain_ones_only_where_it_has_none() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let groups = [("BG.", &BG[..]), ("FG.", &FG), ("", &PLAIN)];
    let single = groups.map(|(prefix, layers)| channels(prefix, layers, &[]));
    let single = file(at("single.exr"), &[part("", &single.concat())]);
    // Blender 5: a part for each layer, whose channels have its name too; others leave that out.
    let parts = |is_named: bool| {
        let groups = [("FG.", &FG[..]), ("BG.", &BG), ("", &PLAIN)];
        let layers = groups.into_iter().flat_map(|(prefix, layers)| {
            layers.iter().map(move |layer| {
                let bare = [layer.0];
                let bare = if is_named { &[][..] } else { &bare };
                let name = format!("{prefix}{}", layer.0);
                part(&name, &channels(prefix, std::slice::from_ref(layer), bare))
            })
        });
        layers.collect::<Vec<_>>()
    };
    let named = file(at("named.exr"), &parts(true));
    let bare = file(at("bare.exr"), &parts(false));
    // A part for each group, whose picture and depth have no names.
    let whole = |name, layers: &[Layer]| part(name, &channels("", layers, &["Combined", "Depth"]));
    let plain = part("more", &channels("", &PLAIN[..1], &[]));
    let whole = [whole("FG", &FG), whole("BG", &BG), plain];
    let whole = file(at("whole.exr"), &whole);
    let names = "normal x,normal y,depth,red,green,alpha,occlusion,direct,surface".split(',');
    let fg = [0.6, 0.0, 10.0, 0.1, 0.2, 1.0, 0.75, 0.4, 0.5];
    let fg: Vec<_> = names.clone().zip(fg).collect();
    // Its only light has no colour of a surface, and is not scaled.
    let bg: Vec<_> = names.zip([0.0, 0.6, 20.0, 0.9, 0.8, 1.0, 0.75]).collect();
    // Channels of a part are in the order of the alphabet.
    for (path, first) in [(single, "BG"), (named, "FG"), (bare, "FG"), (whole, "FG")] {
        let [of_fg, of_bg, open] =
            [Some("fg"), Some("BG"), None].map(|layer| read(&inputs(&path, layer)));
        assert_eq!(samples(&of_fg), fg, "{path:?}");
        assert_eq!(samples(&of_bg), bg, "{path:?}");
        let expected = if first == "FG" { &fg[..] } else { &bg };
        assert_eq!(samples(&open), expected, "{path:?}");
        assert_eq!(of_fg.warnings, [""; 0]);
        let said = format!("the layers of {first} are taken; of several groups");
        assert!(open.warnings[0].starts_with(&said), "{:?}", open.warnings);
        assert!(open.warnings[0].contains("--layer NAME"));
        let survey = survey(&inputs(&path, None)).unwrap();
        assert_eq!(survey.group.as_deref(), Some(first));
        assert_eq!(survey.groups.len(), 2);
        let unknown = load(&inputs(&path, Some("MG")), Needs::default());
        let unknown = unknown.map(drop).unwrap_err();
        let found = format!("found {})", survey.groups.join(", "));
        assert!(unknown.to_string().contains(&found), "{unknown}");
    }
}

#[test]
fn flags_name_layers_of_any_group_and_names_of_one_frame_are_no_groups() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let both = [channels("BG.", &BG, &[]), channels("FG.", &FG, &[])].concat();
    let both = inputs(&file(at("both.exr"), &[part("", &both)]), Some("FG"));
    let named = Inputs {
        normal: Some("BG.Normal".into()),
        ..both
    };
    let expected = [("normal x", 0.0), ("normal y", 0.6), ("depth", 10.0)];
    assert_eq!(samples(&read(&named))[..3], expected);
    // No name occurs twice: the layers are those of one frame, and that is said.
    let both = |name: &str, groups: [(&str, &[Layer]); 2]| {
        let channels = groups.map(|(prefix, layers)| channels(prefix, layers, &[]));
        let path = file(at(name), &[part("", &channels.concat())]);
        read(&inputs(&path, None))
    };
    let whole = both("one.exr", [("Beauty.", &FG[..1]), ("Data.", &BG[1..3])]);
    let expected = [("normal y", 0.6), ("depth", 20.0), ("red", 0.1)];
    assert_eq!(samples(&whole)[1..4], expected);
    let said = &whole.warnings[0];
    assert!(said.contains("(Beauty, Data) make up the frame"), "{said}");
    // Our own layers beside those of a single group are no group.
    let own = both("own.exr", [("FG.", &FG), ("relievo.", &BG[1..2])]);
    assert_eq!(samples(&own)[0], ("normal x", 0.6));
    assert_eq!(own.warnings, [""; 0]);
}

/// Light that is half of the picture differs from it by .5: it is that of another.
#[test]
fn light_of_another_picture_is_left_out_unless_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let dark = FG.map(|(name, components, values)| match name {
        "DiffDir" => (name, components, values.map(|v| 0.5 * v)),
        _ => (name, components, values),
    });
    let dark = [part("", &channels("", &dark, &[]))];
    let dark = file(folder.path().join("dark.exr"), &dark);
    let mut inputs = inputs(&dark, None);
    let left = read(&inputs);
    assert!(left.frame.light.lobes.is_empty());
    let said =
        "the light passes differ from the picture by 50.00 % in the median: they are left out";
    assert!(left.warnings[0].starts_with(said), "{:?}", left.warnings);
    inputs.light.as_mut().unwrap().lobes = LobeChoice::On;
    assert_eq!(read(&inputs).frame.light.lobes.len(), 1);
}
