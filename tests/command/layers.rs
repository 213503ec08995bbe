//! The layers that `shape` and `enhance` write, and what they leave as it was.

use crate::common::bits;
use crate::common::exr::full;
use crate::common::program::Desk;
use relievo::frame::{Plane, Window};
use relievo::io::exr::{ChannelId, ExrFile};
use relievo::io::{Needs, inputs::Inputs, load};

/// The layers that `shape` writes, by their short names.
#[rustfmt::skip]
const CONTRACT: [&str; 20] = [
    "normal.x", "normal.y", "normal.z",
    "weights.confidence", "weights.silhouette", "weights.crease", "weights.conductance",
    "gradient.x", "gradient.y",
    "hessian.xx", "hessian.xy", "hessian.yy",
    "curvature.u", "curvature.v", "curvature.mean", "curvature.kappa",
    "direction.x", "direction.y", "direction_view.x", "direction_view.y",
];

/// The file that a command on one of the examples writes.
#[track_caller]
fn made(desk: &Desk, words: &str) -> ExrFile {
    desk.make(format!("{words} -o out.exr"));
    desk.exr("out.exr")
}

fn plane(file: &ExrFile, part: usize, name: &str) -> Plane {
    let mut channels = file.parts[part].channels.iter();
    let channel = channels.position(|c| c.name == name || c.name == full(name));
    let channel = channel.unwrap_or_else(|| panic!("no {name} in part {part}"));
    let ids = [ChannelId { part, channel }];
    file.read_channels(&ids).unwrap().remove(0)
}

fn names(file: &ExrFile, part: usize) -> Vec<&str> {
    let channels = file.parts[part].channels.iter();
    channels.map(|c| c.name.as_str()).collect()
}

/// Whether a layer has the same bits in both files.
fn is_same(a: &ExrFile, b: &ExrFile, [part_a, part_b]: [usize; 2], name: &str) -> bool {
    bits(&plane(a, part_a, name)) == bits(&plane(b, part_b, name))
}

#[test]
fn shape_appends_the_contracts_layers_and_keeps_the_rest() {
    let desk = Desk::new();
    let mut contract = CONTRACT;
    contract.sort_unstable();
    for name in ["fixtures/bust.exr", "fixtures/gears.exr"] {
        let short = format!("shape {name} --layer-names short --layers results");
        assert_eq!(names(&made(&desk, &short), 0), contract);

        let (input, output) = (desk.exr(name), made(&desk, &format!("shape {name}")));
        assert_eq!(output.parts.len(), 2);
        assert_eq!(output.parts[1].name.as_deref(), Some("relievo"));
        let mut in_full = contract.map(full);
        in_full.sort_unstable();
        assert_eq!(names(&output, 1), in_full);
        assert_eq!(output.parts[1].window, input.parts[0].window);
        assert_eq!(output.display_window, input.display_window);

        assert_eq!(output.parts[0].compression, input.parts[0].compression);
        assert_eq!(output.parts[0].channels, input.parts[0].channels);
        for layer in names(&input, 0) {
            let is_kept = is_same(&output, &input, [0, 0], layer);
            assert!(is_kept, "{name}: {layer} changed");
        }
        for (attribute, text) in &input.attributes {
            if !["name", "type", "chunkCount"].contains(&attribute.as_str()) {
                assert_eq!(output.attributes.get(attribute), Some(text), "{attribute}");
            }
        }
        // The input's compressed blocks are copied unchanged: its last bytes are in the output.
        let (old, new) = (desk.bytes(name), desk.bytes("out.exr"));
        let block = &old[old.len() - 2000..];
        assert!(new.windows(block.len()).any(|bytes| bytes == block));
    }
}

#[test]
fn results_alone_hold_the_same_layers() {
    let desk = Desk::new();
    desk.make("shape fixtures/gears.exr --depth-of-output float -o beside.exr");
    let beside = desk.exr("beside.exr");
    desk.make("shape fixtures/gears.exr --depth-of-output float --layers results -o alone.exr");
    let alone = desk.exr("alone.exr");
    assert_eq!(alone.parts.len(), 1);
    assert_eq!(alone.parts[0].channels.len(), CONTRACT.len());
    for name in CONTRACT {
        assert!(is_same(&alone, &beside, [0, 1], name), "{name}");
    }
    let half = made(&desk, "shape fixtures/gears.exr --layers results");
    let rounded = plane(&beside, 1, "curvature.kappa").map(|v| half::f16::from_f32(v).to_f32());
    assert_eq!(bits(&plane(&half, 0, "curvature.kappa")), bits(&rounded));

    let picture = "enhance fixtures/gears.exr --layers results --compression auto";
    let picture = made(&desk, picture);
    assert_eq!(names(&picture, 0), ["A", "B", "G", "R"]);
    assert_eq!(picture.parts[0].compression, "zip");
}

#[test]
fn of_the_results_those_are_written_that_are_picked() {
    let desk = Desk::new();
    let shape = "shape fixtures/gears.exr --layers results";
    desk.make(format!("{shape} -o all.exr"));
    let all = desk.exr("all.exr");
    let named = made(
        &desk,
        &format!("{shape} --write CurvatureK*,relievo.Normal.x"),
    );
    assert_eq!(names(&named, 0), ["curvature.kappa", "normal.x"].map(full));
    let picked = made(&desk, &format!("{shape} --write kappa,normal,weights.c*"));
    let weights = [
        "weights.conductance",
        "weights.confidence",
        "weights.crease",
    ];
    let others = ["curvature.kappa", "normal.x", "normal.y", "normal.z"];
    let expected = [&others[..], &weights].concat();
    let in_full: Vec<_> = expected.iter().map(|name| full(name)).collect();
    assert_eq!(names(&picked, 0), in_full);
    for name in expected {
        assert!(is_same(&picked, &all, [0, 0], name), "{name}");
    }
    let rows = "
        -o none.exr --write curvature.kapa => 2: did you mean curvature.kappa?
        -o none.png --write kappa => 2: --write is of EXR, NPY and TIFF alone
    ";
    desk.check("shape fixtures/gears.exr {}", rows);
}

#[test]
fn several_scales_are_layers_named_after_them() {
    let desk = Desk::new();
    let shape = "shape fixtures/gears.exr --layers results --curvature-gain 20 --scale";
    desk.make(format!("{shape} 2,5.5 -o both.exr"));
    let (both, one) = (desk.exr("both.exr"), made(&desk, &format!("{shape} 5.5")));
    for component in ["u", "v", "mean", "kappa"] {
        let further = plane(&both, 0, &format!("curvature_5_5px.{component}"));
        let alone = plane(&one, 0, &format!("curvature.{component}"));
        assert_eq!(further.samples(), alone.samples(), "{component}");
    }
    assert_eq!(both.parts[0].channels.len(), CONTRACT.len() + 4);
    let rows = "
        hatch --scale 2,5 => 2: several scales
        shape --scale 2,5 => 2: several scales
        enhance --scale 2,5,9,15,25 => 2: several scales
    ";
    desk.check("{} fixtures/gears.exr -o a.png", rows);
}

#[test]
fn importance_keeps_detail_where_it_is_low() {
    let desk = Desk::new();
    let gradient = |flags: &str| {
        let file = made(&desk, &format!("shape fixtures/gears.exr {flags}"));
        plane(&file, 1, "gradient.x")
    };
    let fine = gradient("--iterations 0");
    let (width, half) = (fine.width(), fine.width() / 2);
    let share = |x, _| if x < half { 0.0 } else { 1.0 };
    let map = Plane::from_fn(width, fine.height(), share);
    desk.write_exr("map.exr", &[("importance.Y", &map)]);
    let coarse = gradient("--iterations 80");
    let found = gradient("--iterations 80 --importance map.exr");
    for y in 0..fine.height() {
        assert_eq!(found.row(y)[..half], fine.row(y)[..half]);
        let rest = found.row(y)[half..].iter().zip(&coarse.row(y)[half..]);
        // Both are expansions within the tolerance.
        assert!(rest.fold(0.0_f32, |m, (a, b)| m.max((a - b).abs())) < 2e-4);
    }
    desk.write_exr("unlike.exr", &[("importance.Y", &Plane::filled(8, 8, 1.0))]);
    let row = "--importance unlike.exr => 1: unlike.exr ... 8x8";
    desk.check("shape fixtures/gears.exr -o a.png {}", row);
}

#[test]
fn the_layers_keep_to_their_ranges() {
    let desk = Desk::new();
    let words = "shape fixtures/bust.exr --layers results --depth-of-output float";
    let file = made(&desk, words);
    let covered = mask_of(&desk, "fixtures/bust.exr");
    let count = covered.iter().filter(|&&c| c).count();
    assert!(count > 10_000 && count < covered.len() / 2);
    let layer = |name: &str| plane(&file, 0, name);
    for name in CONTRACT {
        let plane = layer(name);
        assert!(plane.samples().iter().all(|v| v.is_finite()), "{name}");
        let used = plane.samples().iter().any(|&v| v != plane.at(0, 0));
        // The frame is sharp.
        let same = name == "weights.confidence" && plane.at(0, 0) == 1.0;
        assert!(used != same, "{name} is the same everywhere");
        let is_weight = name.starts_with("weights.");
        let is_share = plane.samples().iter().all(|v| (0.0..=1.0).contains(v));
        assert!(is_share || !is_weight, "{name}");
    }
    let kappa = layer("curvature.kappa");
    assert!(kappa.samples().iter().all(|v| (-1.0..=1.0).contains(v)));
    for (name, dimension) in [("normal", 3), ("direction", 2), ("direction_view", 2)] {
        let components = ["x", "y", "z"][..dimension].iter();
        let components = components.map(|c| layer(&format!("{name}.{c}")));
        let components: Vec<Plane> = components.collect();
        let mut units = 0;
        for (i, &covered) in covered.iter().enumerate() {
            let square: f32 = components.iter().map(|c| c.samples()[i].powi(2)).sum();
            let is_unit = (square - 1.0).abs() < 1e-4;
            units += usize::from(is_unit);
            assert!(is_unit || square == 0.0, "{name} at {i}: {square}");
            assert!(covered || square == 0.0, "{name} outside the mask at {i}");
            let is_as_covered = name == "direction_view" || is_unit == covered;
            assert!(is_as_covered, "{name} at {i}");
        }
        assert!(2 * units > count, "{name}: {units} of {count}");
    }
    let (u, v) = (layer("curvature.u"), layer("curvature.v"));
    assert!(u.samples().iter().zip(v.samples()).all(|(u, v)| u >= v));
}

fn mask_of(desk: &Desk, name: &str) -> Vec<bool> {
    let inputs = Inputs {
        picture: desk.at(name),
        ..Inputs::default()
    };
    let needs = Needs {
        color: false,
        projection: true,
        ..Needs::default()
    };
    let mask = load(&inputs, needs).unwrap().frame.mask;
    mask.plane().samples().to_vec()
}

#[test]
fn the_background_keeps_its_bits() {
    let desk = Desk::new();
    for name in ["fixtures/bust.exr", "fixtures/gears.exr"] {
        let (input, covered) = (desk.exr(name), mask_of(&desk, name));
        assert!(covered.contains(&false), "{name} has no background");
        for (scaling, all) in [("3", false), ("0", true)] {
            let output = made(&desk, &format!("enhance {name} --scaling {scaling}"));
            for component in ["R", "G", "B", "A"] {
                let ours = bits(&plane(&output, 1, &format!("relievo.{component}")));
                let theirs = format!("ViewLayer.Combined.{component}");
                let theirs = bits(&plane(&input, 0, &theirs));
                let mut pixels = ours.iter().zip(&theirs).zip(&covered);
                if all || component == "A" {
                    assert!(ours == theirs, "{name}, {component}, --scaling {scaling}");
                } else {
                    let changed = pixels.clone().filter(|((a, b), _)| a != b).count();
                    assert!(changed > 1000, "{name}: only {changed} samples changed");
                    let kept = pixels.all(|((ours, theirs), &covered)| covered || ours == theirs);
                    assert!(kept, "{name}: {component} changed outside the mask");
                }
            }
        }
    }
}

#[test]
fn layers_go_beside_the_input_into_it_or_alone() {
    let desk = Desk::of_frames(1..=1);
    let in_full = ["B", "G", "R"].map(|name| format!("relievo.Picture.{name}"));
    let bare = ["B", "G", "R"].map(String::from);
    for (how, parts, expected) in [
        ("keep", 2, &in_full),
        ("channels", 1, &in_full),
        ("results", 1, &bare),
    ] {
        let words = format!("enhance in.0001.exr --layers {how} --compression zips");
        let file = made(&desk, &words);
        assert_eq!(file.parts.len(), parts, "{how}");
        let names = names(&file, parts - 1);
        let has_all = expected.iter().all(|name| names.contains(&&**name));
        assert!(has_all, "{how}: {names:?}");
        // Adding channels keeps the compression of the input.
        let compression = if how == "channels" { "none" } else { "zips" };
        assert_eq!(file.parts[parts - 1].compression, compression, "{how}");
        assert_eq!(names.contains(&"N.X"), how == "channels", "{how}");
    }
    // A picture has the size of its file.
    let picture = made(&desk, "enhance fixtures/gears.exr");
    assert_eq!(picture.parts[1].window, Window::from_size(320, 240));
}
