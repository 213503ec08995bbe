//! One object of a picture, a mask, and a share of the change.

use crate::common::exr::{Part, channel};
use crate::common::program::{fixture, relievo};
use relievo::frame::{Plane, Window};
use std::path::Path;

/// Red, in half floats, of `relievo enhance` on the hazy render, or on `input`.
fn red(desk: &Path, input: &str, flags: &str) -> Plane {
    let words = format!("enhance {input} --layers results -q -o out.exr {flags}");
    relievo(desk, &words).done();
    channel(&desk.join("out.exr"), "R")
}

/// The share of each pixel that the head covers, from the samples themselves.
fn head(haze: &str) -> Plane {
    share_of(0x0577_7012, haze)
}

/// The same for the object with this hash, as Blender wrote it into the manifest: {"Head":"05777012","Block":"3af60354"}.
fn share_of(hash: u32, haze: &str) -> Plane {
    let number = f32::from_bits(hash);
    let stored = |level: usize, c: char| {
        channel(
            Path::new(haze),
            &format!("ViewLayer.CryptoObject0{level}.{c}"),
        )
    };
    let ranks = [(0, 'r', 'g'), (0, 'b', 'a'), (1, 'r', 'g'), (1, 'b', 'a')];
    let ranks = ranks.map(|(level, id, share)| (stored(level, id), stored(level, share)));
    Plane::from_fn(ranks[0].0.width(), ranks[0].0.height(), |x, y| {
        let shares = ranks.iter().map(|(id, share)| match id.at(x, y) == number {
            true => share.at(x, y),
            false => 0.0,
        });
        shares.sum()
    })
}

#[test]
fn an_object_is_changed_by_its_share_of_each_pixel_as_in_the_whole() {
    let desk = tempfile::tempdir().unwrap();
    let haze = fixture("haze.exr").display().to_string();
    let before = channel(Path::new(&haze), "ViewLayer.Combined.R");
    let red = |flags| red(desk.path(), &haze, &format!("--gain 8 {flags}"));
    let whole = red("");
    let of_head = red("--object Head");
    let of_rest = red("--object !Head");
    let half = red("--object H*d --mix 0.5");
    let share = head(&haze);
    let mut changed = 0;
    for y in 0..share.height() {
        for x in 0..share.width() {
            let at = |plane: &Plane| plane.at(x, y);
            let change = at(&whole) - at(&before);
            // Three values are rounded to half floats, each by 2^-11 of itself at the most.
            let bound = 1.5 * (at(&whole) + 2.0 * at(&before)).abs() / 2048.0 + 1e-6;
            let wanted = |made: &Plane, share: f32| {
                let error = at(made) - at(&before) - share * change;
                assert!(error.abs() <= bound, "at {x}, {y}: {error} of {bound}");
            };
            wanted(&of_head, at(&share));
            wanted(&of_rest, 1.0 - at(&share));
            wanted(&half, 0.5 * at(&share));
            changed += usize::from(at(&share) > 0.5 && change.abs() > 0.05 * at(&before));
        }
    }
    // Of some 12,000 pixels of the head a good part changes by more than a twentieth.
    assert!(changed > 2000, "{changed}");
}

#[test]
fn the_gain_is_that_of_the_objects_chosen() {
    let desk = tempfile::tempdir().unwrap();
    let haze = fixture("haze.exr").display().to_string();
    let gain = |flags: &str| -> f64 {
        let words = format!("enhance {haze} -o out.exr --save-recipe look.toml {flags}");
        relievo(desk.path(), &words).done();
        let recipe = std::fs::read_to_string(desk.path().join("look.toml")).unwrap();
        let value = recipe
            .lines()
            .find_map(|line| line.strip_prefix("curvature-gain = "));
        value.unwrap().parse().unwrap()
    };
    // Shares add up to 1, and so do the sums of the head and of all else: the gain of the whole lies between theirs.
    let [head, rest, whole] = ["--object Head", "--object !Head", ""].map(gain);
    let [least, most] = [head.min(rest), head.max(rest)];
    assert!(least < 0.95 * most, "{head} {rest}");
    assert!(least < whole && whole < most, "{head} {whole} {rest}");
}

#[test]
fn a_mask_is_a_strength_and_coverage_is_not() {
    let desk = tempfile::tempdir().unwrap();
    let gears = fixture("gears.exr").display().to_string();
    let red = |flags| red(desk.path(), &gears, &format!("--gain 8 {flags}"));
    let shape = red("");
    let (width, height) = (shape.width(), shape.height());
    let before = red("--mix 0");
    let left = Plane::from_fn(width, height, |x, _| match x {
        0..100 => 1.0,
        100..200 => 0.25,
        _ => 0.0,
    });
    Part::of([("mask.Y", &left)]).write(&desk.path().join("mask.exr"));
    let made = red("--mask mask.exr");
    for y in 0..height {
        let rows = [&made, &shape, &before].map(|plane| plane.row(y));
        // Where the mask is full no bit differs.
        assert_eq!(rows[0][..100], rows[1][..100]);
        assert_eq!(rows[0][200..], rows[2][200..]);
        for x in 100..200 {
            let [made, all, none] = rows.map(|row| row[x]);
            let error = made - none - 0.25 * (all - none);
            assert!(error.abs() <= (made + all + none) / 2048.0, "{error}");
        }
    }
    // Uncovered pixels have no shape, so the picture beside them comes out differently.
    let covered = red("--coverage mask.exr");
    assert!((0..height).any(|y| covered.row(y)[..100] != shape.row(y)[..100]));
    assert!((0..height).all(|y| covered.row(y)[101..] == before.row(y)[101..]));
}

#[test]
fn objects_that_are_not_there_are_refused_with_those_that_are() {
    let desk = tempfile::tempdir().unwrap();
    let haze = fixture("haze.exr").display().to_string();
    let refused = |input: &str, flags: &str| {
        let line = relievo(desk.path(), &format!("enhance {input} -o out.png {flags}"));
        line.refused(1)
    };
    let line = refused(&haze, "--object head");
    assert!(
        line.contains("no object called head (found Block, Floor, Fog, Head, Ring, Wall)"),
        "{line}"
    );
    assert!(line.contains("did you mean Head?"), "{line}");
    let gears = fixture("gears.exr").display().to_string();
    assert!(refused(&gears, "--object Head").contains("no Cryptomatte"));
    let line = refused(&haze, "--mask ViewLayer.CryptoObject00");
    assert!(line.contains("--object NAME"), "{line}");
    let said = relievo(desk.path(), &format!("inspect {haze}"))
        .done()
        .stdout;
    assert!(
        said.contains("Block, Floor, Fog, Head, Ring, Wall"),
        "{said}"
    );
}

#[test]
fn strokes_have_an_angle_by_object() {
    let desk = tempfile::tempdir().unwrap();
    let haze = fixture("haze.exr").display().to_string();
    let drawn = |flags: &str, name: &str| {
        let flags = format!("--style pen --directions max --interior off --contours off {flags}");
        let words = format!("hatch {haze} {flags} --layers results -q -o {name}.exr");
        relievo(desk.path(), &words).done();
        channel(&desk.path().join(format!("{name}.exr")), "strokes.hatching")
    };
    let plain = drawn("", "plain");
    let turned = drawn(
        "--object-angle Block=90 --object-angle B*k=0 --save-recipe turned.toml",
        "turned",
    );
    let recipe = std::fs::read_to_string(desk.path().join("turned.toml")).unwrap();
    assert!(
        recipe.contains("object-angle = [\"Block=90\", \"B*k=0\"]"),
        "{recipe}"
    );
    // Strokes change on the block alone, whose sides are plane, and where the fog's specks beside it take directions from
    // up to 32 pixels away.
    // The last of the two angles counts.
    assert_eq!(turned, drawn("--object-angle Block=0", "again"));
    let share = share_of(0x3af6_0354, &haze);
    let mut changed = 0;
    for (x, y) in (0..share.height()).flat_map(|y| (0..share.width()).map(move |x| (x, y))) {
        if plain.at(x, y) == turned.at(x, y) {
            continue;
        }
        let rows = y.saturating_sub(32)..(y + 33).min(share.height());
        let columns = x.saturating_sub(32)..(x + 33).min(share.width());
        let mut around = share.rows_within(columns, rows).flatten();
        assert!(
            around.any(|&share| share > 0.5),
            "({x}, {y}) is not on the block"
        );
        changed += 1;
    }
    assert!(changed > 1000, "{changed}");
    let refused = |flags: &str| relievo(desk.path(), &format!("hatch {haze} -o out.png {flags}"));
    let line = refused("--object-angle head=30").refused(1);
    assert!(line.contains("no object called head"), "{line}");
    let line = refused("--object-angle Head").error(2);
    assert!(line.contains("expected NAME=DEG or NAME=surface"), "{line}");
}

#[test]
fn depth_that_fog_lacks_is_filled_and_said() {
    let desk = tempfile::tempdir().unwrap();
    let haze = fixture("haze.exr").display().to_string();
    let words = format!("shape {haze} --layers results -o shape.exr");
    let said = relievo(desk.path(), &words).done().stderr;
    assert!(said.contains("samples inside surfaces"), "{said}");
    let silhouette = channel(&desk.path().join("shape.exr"), "weights.silhouette");
    let share = head(&haze);
    let (mut inside, mut missing, mut edges) = (0, 0, 0);
    let depth = channel(Path::new(&haze), "ViewLayer.Depth.Z");
    for (i, &share) in share.samples().iter().enumerate() {
        // Fog covers up to a quarter of the head's own pixels.
        if share > 0.6 {
            inside += 1;
            missing += usize::from(depth.samples()[i] > 1e9);
            edges += usize::from(silhouette.samples()[i] > 0.5);
        }
    }
    // Every missing sample made silhouettes of itself and its neighbours: three fifths of the head.
    assert!(missing * 8 > inside, "{missing} of {inside}");
    assert!(edges * 10 < inside, "{edges} of {inside}");

    // A jar of glass (index 3), and leaves cut out by alpha (5 to 20), whose outlines are as long as they are small. With single
    // samples filled alone these were .136 and .424.
    let leaves = fixture("leaves.exr");
    let words = format!(
        "shape {} --layers results -q -o shape.exr",
        leaves.display()
    );
    relievo(desk.path(), &words).done();
    let silhouette = channel(&desk.path().join("shape.exr"), "weights.silhouette");
    let index = channel(&leaves, "ViewLayer.IndexOB.X");
    let mean = |objects: std::ops::RangeInclusive<f32>| {
        let pairs = silhouette.samples().iter().zip(index.samples());
        let own: Vec<f32> = pairs
            .filter(|(_, index)| objects.contains(*index))
            .map(|(silhouette, _)| *silhouette)
            .collect();
        own.iter().sum::<f32>() / own.len() as f32
    };
    let (jar, leaves) = (mean(3.0..=3.0), mean(5.0..=20.0));
    assert!(jar < 0.11 && leaves < 0.34, "{jar}, {leaves}");
}

#[test]
fn a_drawing_fades_with_the_share_of_an_object() {
    let desk = tempfile::tempdir().unwrap();
    let haze = fixture("haze.exr").display().to_string();
    let drawn = |flags: &str| {
        let words = format!("hatch {haze} --gain 8 --layers results -q -o out.exr {flags}");
        relievo(desk.path(), &words).done();
        ["strokes.hatching", "strokes.contours"]
            .map(|name| channel(&desk.path().join("out.exr"), name))
    };
    let whole = drawn("");
    let of_head = drawn("--object Head");
    let of_half = drawn("--object Head --mix 0.5");
    let share = head(&haze);
    let (mut inside, mut along) = (0.0, 0.0);
    for y in 0..share.height() {
        for x in 0..share.width() {
            let [all, own, half] = [&whole, &of_head, &of_half].map(|d| d[0].at(x, y));
            let wanted = share.at(x, y) * all;
            // Half floats: 2^-11 of each.
            assert!(
                (own - wanted).abs() <= 1e-3 * all + 1e-6,
                "{own} of {wanted}"
            );
            assert!((half - 0.5 * wanted).abs() <= 1e-3 * all + 1e-6, "{half}");
            inside += f64::from(own);
            // Lines along edges keep their outer half: two pixels beside the head are theirs.
            let [all, own] = [&whole, &of_head].map(|d| d[1].at(x, y));
            assert!(own <= all, "{own} of {all}");
            along += f64::from(if share.at(x, y) == 0.0 { own } else { 0.0 });
            let rows = y.max(1) - 1..(y + 2).min(share.height());
            let is_beside = rows.into_iter().any(|v| {
                let mut columns = x.max(1) - 1..(x + 2).min(share.width());
                columns.any(|u| share.at(u, v) > 0.6)
            });
            assert!(!is_beside || own >= 0.599 * all, "{own} of {all}");
        }
    }
    // Outlines in fog have no loops beside them: what is left is ink where the head has no share at all.
    assert!(inside > 100.0 && along > 5.0, "{inside}, {along}");
}

#[test]
fn what_no_manifest_names_is_found_by_the_hash_of_its_name() {
    let desk = tempfile::tempdir().unwrap();
    let haze = fixture("haze.exr");
    // The same file with an unreadable manifest: one letter of its key is changed, at the same length.
    let mut bytes = std::fs::read(&haze).unwrap();
    let at = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|w| w == what);
    while let Some(found) = at(&bytes, b"/manifest\0") {
        bytes[found + 1] = b'M';
    }
    let bare = desk.path().join("bare.exr");
    std::fs::write(&bare, &bytes).unwrap();
    // And without all that it says of Cryptomatte.
    while let Some(found) = at(&bytes, b"cryptomatte/") {
        bytes[found] = b'k';
    }
    std::fs::write(desk.path().join("lost.exr"), bytes).unwrap();
    let named = red(desk.path(), &haze.display().to_string(), "--object Head");
    for flags in [
        "--object Head",
        "--object #05777012",
        "--object 0x05777012",
        "--object 05777012",
        "--object #05777012 --object !Ring",
    ] {
        for input in ["bare.exr", "lost.exr"] {
            assert!(red(desk.path(), input, flags) == named, "{input} {flags}");
        }
    }
    // `inspect` lists the hashes of the largest ones. The share of the head is that of its samples.
    let share = head(&haze.display().to_string());
    let sum: f32 = share.samples().iter().sum();
    let percent = 100.0 * sum / share.samples().len() as f32;
    let listed = relievo(desk.path(), "inspect bare.exr").done().stdout;
    assert!(
        listed.contains(&format!("#05777012 ({percent:.1} %)")),
        "{percent}: {listed}"
    );
    let line = relievo(desk.path(), "enhance bare.exr -o out.png --object H*").refused(1);
    assert!(line.contains("--object '#"), "{line}");
    let ran = relievo(desk.path(), "enhance bare.exr -o out.png --object Nobody").done();
    assert!(
        ran.stderr.contains("nothing of what is chosen"),
        "{}",
        ran.stderr
    );
}

/// Bands of a picture, each of one object; the last one is of no name, so that its hash is none in the manifest.
const BANDS: [(&str, u32); 4] = [
    ("leaf_*_a", 0x3f11_1111),
    ("leaf_x_a", 0x3f22_2222),
    ("leaf_x_b", 0x3f33_3333),
    ("", 0x3f44_4444),
];

/// The Cryptomatte of bands that are 16 pixels wide.
fn bands() -> Part {
    let plane = |sample: &dyn Fn(usize) -> f32| Plane::from_fn(64, 48, |x, _| sample(x / 16));
    let number = plane(&|band| f32::from_bits(BANDS[band].1));
    let (whole, none) = (plane(&|_| 1.0), plane(&|_| 0.0));
    let named = BANDS.iter().filter(|(name, _)| !name.is_empty());
    let manifest: Vec<String> = named
        .map(|(name, hash)| format!("\"{name}\":\"{hash:08x}\""))
        .collect();
    let [number, share, more] = [("R", &number), ("G", &whole), ("B", &none)];
    let channels = [number, share, more, ("A", &none)];
    Part::of(channels.map(|(component, plane)| (format!("CryptoObject00.{component}"), plane)))
        .text("cryptomatte/28322e9/name", "CryptoObject")
        .text("cryptomatte/28322e9/hash", "MurmurHash3_32")
        .text("cryptomatte/28322e9/conversion", "uint32_to_float32")
        .text(
            "cryptomatte/28322e9/manifest",
            &format!("{{{}}}", manifest.join(",")),
        )
}

/// A grey picture of waves with normals, at this place.
fn waves(window: Window) -> Part {
    let plane = |sample: &dyn Fn(f32) -> f32| {
        Plane::from_fn(window.width(), window.height(), |x, _| {
            sample((x as f32).sin())
        })
    };
    let channels = [
        ("R", plane(&|_| 0.4)),
        ("G", plane(&|_| 0.4)),
        ("B", plane(&|_| 0.4)),
        ("N.X", plane(&|wave| 0.3 * wave)),
        ("N.Y", plane(&|_| 0.0)),
        ("N.Z", plane(&|wave| (1.0 - 0.09 * wave * wave).sqrt())),
    ];
    let part = Part::of(channels.iter().map(|(name, plane)| (*name, plane)));
    Part { window, ..part }
}

#[test]
fn objects_are_told_apart_by_a_file_of_their_own() {
    let desk = tempfile::tempdir().unwrap();
    let at = |name: &str| desk.path().join(name);
    bands().write(&at("crypto.exr"));
    waves(Window::from_size(64, 48)).write(&at("beauty.exr"));
    waves(Window::from_size(48, 48)).write(&at("small.exr"));
    let grey = image::RgbImage::from_pixel(64, 48, image::Rgb([128; 3]));
    grey.save(at("photo.png")).unwrap();
    let flags = "--normal-space view --gain 8 --curvature-gain 1";
    let plain = red(desk.path(), "beauty.exr", &format!("{flags} --mix 0"));
    // Which bands change.
    let changed = |input: &str, object: &str, plain: &Plane| {
        let objects = format!("--cryptomatte crypto.exr --object {object}");
        let made = red(desk.path(), input, &format!("{flags} {objects}"));
        let rows = 0..48;
        [0, 1, 2, 3].map(|band| {
            let columns = 16 * band..16 * (band + 1);
            rows.clone()
                .any(|y| made.row(y)[columns.clone()] != plain.row(y)[columns.clone()])
        })
    };
    let bands_of = |object: &str| changed("beauty.exr", object, &plain);
    // An exact name is no pattern; a pattern takes all that it fits, and what no name is known of has a hash.
    assert_eq!(bands_of("leaf_*_a"), [true, false, false, false]);
    assert_eq!(bands_of("leaf_?_a"), [true, true, false, false]);
    assert_eq!(bands_of("leaf_x_*"), [false, true, true, false]);
    assert_eq!(bands_of("!leaf_*_a"), [false, true, true, true]);
    assert_eq!(bands_of("0x3f444444"), [false, false, false, true]);
    assert_eq!(bands_of("3f333333"), [false, false, true, false]);
    // Of a photo too.
    let of_photo = format!("{flags} --normal beauty.exr");
    let photo = |more: &str| red(desk.path(), "photo.png", &format!("{of_photo} {more}"));
    let objects = "--cryptomatte crypto.exr --object leaf_x_b";
    let (none, one) = (photo("--mix 0"), photo(objects));
    assert!(none.row(9)[..32] == one.row(9)[..32] && none.row(9)[32..48] != one.row(9)[32..48]);

    for command in ["shape", "enhance", "relight", "hatch"] {
        let words = format!("{command} beauty.exr --normal-space view -o out.exr {objects}");
        relievo(desk.path(), &words).done();
    }
    // Of a sequence each frame has its own file.
    for frame in 1..=2 {
        let copy = |name: &str| {
            std::fs::copy(
                at(&format!("{name}.exr")),
                at(&format!("{name}.{frame}.exr")),
            )
        };
        copy("beauty").and_then(|_| copy("crypto")).unwrap();
    }
    let numbered = "--cryptomatte crypto.#.exr --object leaf_x_b --frames 1-2";
    relievo(
        desk.path(),
        &format!("enhance beauty.#.exr --normal-space view -o out.#.exr {numbered}"),
    )
    .done();
    let listed = relievo(desk.path(), "inspect beauty.exr --cryptomatte crypto.exr").done();
    assert!(listed.stdout.contains("leaf_x_b"), "{}", listed.stdout);
    let refused = |words: &str| relievo(desk.path(), words).refused(1);
    let line = refused(&format!("enhance small.exr -o out.exr {objects}"));
    assert!(
        line.contains("crypto.exr: is 64x48") && line.contains("small.exr has 48x48"),
        "{line}"
    );
    let line = refused("enhance beauty.exr -o out.exr --cryptomatte photo.png");
    assert!(line.contains("photo.png: has no Cryptomatte"), "{line}");
    let line = refused("enhance beauty.exr -o out.exr --object leaf_x_b");
    assert!(line.contains("--cryptomatte FILE"), "{line}");
}

#[test]
fn lines_between_objects_are_those_of_a_pass_unless_it_is_a_mesh() {
    let desk = tempfile::tempdir().unwrap();
    let plane = |sample: &dyn Fn(usize, usize) -> f32| Plane::from_fn(128, 96, sample);
    let [zero, one] = [0.0, 1.0].map(|value| plane(&|_, _| value));
    let wall = |index: &str, numbers: &Plane| {
        let channels = [
            ("N.X", &zero),
            ("N.Y", &zero),
            ("N.Z", &one),
            (index, numbers),
        ];
        Part::of(
            [("R", &one), ("G", &one), ("B", &one), ("Z", &one)]
                .into_iter()
                .chain(channels),
        )
    };
    let halves = plane(&|x, _| if x < 64 { 1.0 } else { 2.0 });
    // A number for each square of 8 pixels: sides along 2/8 of the pixels.
    let squares = plane(&|x, y| (x / 8 + 100 * (y / 8)) as f32);
    let at = |name: &str| desk.path().join(name);
    wall("IndexOB.X", &halves).write(&at("halves.exr"));
    wall("IndexMA.X", &squares).write(&at("squares.exr"));
    wall("other.X", &halves).write(&at("bare.exr"));
    let drawn = |input: &str, flags: &str| {
        let words =
            format!("hatch {input} --normal-space view --layers results -o out.exr {flags}");
        let said = relievo(desk.path(), &words).done().stderr;
        (channel(&at("out.exr"), "strokes.contours"), said)
    };
    let columns = |ink: &Plane| -> Vec<usize> {
        let has_ink = |&x: &usize| (0..96).any(|y| ink.at(x, y) > 0.0);
        (0..128).filter(has_ink).collect()
    };
    // A pixel wide, between columns 63 and 64.
    let (line, said) = drawn("halves.exr", "-v");
    assert_eq!(columns(&line), [63, 64]);
    assert!(
        said.contains("objects") && said.contains("IndexOB"),
        "{said}"
    );
    assert_eq!(drawn("bare.exr", "--cryptomatte halves.exr").0, line);
    assert!(columns(&drawn("halves.exr", "--object-lines off").0).is_empty());
    let (none, said) = drawn("squares.exr", "");
    assert!(columns(&none).is_empty());
    assert!(said.contains("IndexMA: its objects are so small"), "{said}");
}
