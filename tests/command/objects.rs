//! One object of a picture, a mask, and a share of the change.

use crate::common::exr::Part;
use crate::common::mean;
use crate::common::program::Desk;
use relievo::frame::{Plane, Window};

const HAZE: &str = "fixtures/haze.exr";

/// Red, in half floats, of a picture that is enhanced.
#[track_caller]
fn red(desk: &Desk, words: &str) -> Plane {
    desk.make(format!("enhance {words} --layers results -q -o out.exr"));
    desk.channel("out.exr", "R")
}

/// The layers of strokes and lines of a drawing.
#[track_caller]
fn drawn(desk: &Desk, words: &str) -> [Plane; 2] {
    desk.make(format!("hatch {words} --layers results -q -o out.exr"));
    ["strokes.hatching", "strokes.contours"].map(|name| desk.channel("out.exr", name))
}

/// The share of each pixel that the head covers, from the samples themselves.
fn head() -> Plane {
    share_of(0x0577_7012)
}

/// The same for the object with this hash, as Blender wrote it into the manifest: {"Head":"05777012","Block":"3af60354"}.
fn share_of(hash: u32) -> Plane {
    let (desk, number) = (Desk::new(), f32::from_bits(hash));
    let stored = |name: &str| desk.channel(HAZE, &format!("ViewLayer.CryptoObject{name}"));
    let ranks = [
        ["00.r", "00.g"],
        ["00.b", "00.a"],
        ["01.r", "01.g"],
        ["01.b", "01.a"],
    ];
    let ranks = ranks.map(|names| names.map(stored));
    Plane::from_fn(ranks[0][0].width(), ranks[0][0].height(), |x, y| {
        let is_own = |[id, _]: &&[Plane; 2]| id.at(x, y) == number;
        ranks
            .iter()
            .filter(is_own)
            .map(|[_, share]| share.at(x, y))
            .sum()
    })
}

fn places(plane: &Plane) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (width, height) = (plane.width(), plane.height());
    (0..height).flat_map(move |y| (0..width).map(move |x| (x, y)))
}

/// The samples within so many pixels of a place.
fn around(plane: &Plane, [x, y]: [usize; 2], reach: usize) -> impl Iterator<Item = f32> + '_ {
    let within = |at: usize, size: usize| at.saturating_sub(reach)..(at + reach + 1).min(size);
    let rows = plane.rows_within(within(x, plane.width()), within(y, plane.height()));
    rows.flatten().copied()
}

#[test]
fn an_object_is_changed_by_its_share_of_each_pixel_as_in_the_whole() {
    let desk = Desk::new();
    let before = desk.channel(HAZE, "ViewLayer.Combined.R");
    let red = |flags| red(&desk, &format!("{HAZE} --gain 8 {flags}"));
    let whole = red("");
    let of_head = red("--object Head");
    let of_rest = red("--object !Head");
    let half = red("--object H*d --mix 0.5");
    let share = head();
    let mut changed = 0;
    for (x, y) in places(&share) {
        let at = |plane: &Plane| plane.at(x, y);
        let change = at(&whole) - at(&before);
        // Three values are rounded to half floats, each by 2^-11 of itself at the most.
        let bound = 1.5 * (at(&whole) + 2.0 * at(&before)).abs() / 2048.0 + 1e-6;
        for (made, share) in [
            (&of_head, at(&share)),
            (&of_rest, 1.0 - at(&share)),
            (&half, 0.5 * at(&share)),
        ] {
            let error = at(made) - at(&before) - share * change;
            assert!(error.abs() <= bound, "at {x}, {y}: {error} of {bound}");
        }
        changed += usize::from(at(&share) > 0.5 && change.abs() > 0.05 * at(&before));
    }
    // Of some 12,000 pixels of the head a good part changes by more than a twentieth.
    assert!(changed > 2000, "{changed}");
}

#[test]
fn the_gain_is_that_of_the_objects_chosen() {
    let desk = Desk::new();
    let gain = |flags: &str| -> f64 {
        desk.make(format!(
            "enhance {HAZE} -o out.exr --save-recipe look.toml {flags}"
        ));
        let recipe = desk.text("look.toml");
        let mut lines = recipe.lines();
        let value = lines.find_map(|line| line.strip_prefix("curvature-gain = "));
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
    let desk = Desk::new();
    let red = |flags| red(&desk, &format!("fixtures/gears.exr --gain 8 {flags}"));
    let shape = red("");
    let (width, height) = (shape.width(), shape.height());
    let before = red("--mix 0");
    let left = Plane::from_fn(width, height, |x, _| match x {
        0..100 => 1.0,
        100..200 => 0.25,
        _ => 0.0,
    });
    desk.write_exr("mask.exr", &[("mask.Y", &left)]);
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
    let rows = "
        enhance fixtures/haze.exr --object head => 1: no object called head (found Block, Floor, Fog, Head, Ring, Wall) ... did you mean Head?
        enhance fixtures/haze.exr --mask ViewLayer.CryptoObject00 => 1: --object NAME
        enhance fixtures/gears.exr --object Head => 1: no Cryptomatte
        hatch fixtures/haze.exr --object-angle head=30 => 1: no object called head
        hatch fixtures/haze.exr --object-angle Head => 2: expected NAME=DEG or NAME=surface
    ";
    let desk = Desk::new();
    desk.check("{} -o out.png", rows);
    let row = "=> 0: Block, Floor, Fog, Head, Ring, Wall";
    desk.check("inspect fixtures/haze.exr", row);
}

#[test]
fn strokes_have_an_angle_by_object() {
    let desk = Desk::new();
    let drawn = |flags: &str| {
        let pen = "--style pen --directions max --interior off --contours off";
        desk.make(format!(
            "hatch {HAZE} {pen} {flags} --layers results -q -o out.exr"
        ));
        desk.channel("out.exr", "strokes.hatching")
    };
    let plain = drawn("");
    let turned = drawn("--object-angle Block=90 --object-angle B*k=0 --save-recipe turned.toml");
    let recipe = desk.text("turned.toml");
    assert!(
        recipe.contains("object-angle = [\"Block=90\", \"B*k=0\"]"),
        "{recipe}"
    );
    // The last of the two angles counts.
    assert_eq!(turned, drawn("--object-angle Block=0"));
    // Strokes change on the block alone, whose sides are plane, and where the fog's specks beside it take directions from
    // up to 32 pixels away.
    let share = share_of(0x3af6_0354);
    let changed = places(&share).filter(|&(x, y)| plain.at(x, y) != turned.at(x, y));
    let changed: Vec<_> = changed.collect();
    for &(x, y) in &changed {
        let is_on_block = around(&share, [x, y], 32).any(|share| share > 0.5);
        assert!(is_on_block, "({x}, {y}) is not on the block");
    }
    assert!(changed.len() > 1000, "{}", changed.len());
}

#[test]
fn depth_that_fog_lacks_is_filled_and_said() {
    let desk = Desk::new();
    let silhouette = |input: &str| {
        let said = desk
            .make(format!("shape {input} --layers results -o shape.exr"))
            .stderr;
        (desk.channel("shape.exr", "weights.silhouette"), said)
    };
    let (edge, said) = silhouette(HAZE);
    assert!(said.contains("samples inside surfaces"), "{said}");
    let share = head();
    let depth = desk.channel(HAZE, "ViewLayer.Depth.Z");
    let (mut inside, mut missing, mut edges) = (0, 0, 0);
    // Fog covers up to a quarter of the head's own pixels.
    for (x, y) in places(&share).filter(|&(x, y)| share.at(x, y) > 0.6) {
        inside += 1;
        missing += usize::from(depth.at(x, y) > 1e9);
        edges += usize::from(edge.at(x, y) > 0.5);
    }
    // Every missing sample made silhouettes of itself and its neighbours: three fifths of the head.
    assert!(missing * 8 > inside, "{missing} of {inside}");
    assert!(edges * 10 < inside, "{edges} of {inside}");

    // A jar of glass (index 3), and leaves cut out by alpha (5 to 20), whose outlines are as long as they are small. With single
    // samples filled alone these were .136 and .424.
    let (edge, _) = silhouette("fixtures/leaves.exr");
    let index = desk.channel("fixtures/leaves.exr", "ViewLayer.IndexOB.X");
    let mean = |objects: std::ops::RangeInclusive<f32>| {
        let own = places(&edge).filter(|&(x, y)| objects.contains(&index.at(x, y)));
        let own: Vec<f32> = own.map(|(x, y)| edge.at(x, y)).collect();
        own.iter().sum::<f32>() / own.len() as f32
    };
    let (jar, leaves) = (mean(3.0..=3.0), mean(5.0..=20.0));
    assert!(jar < 0.11 && leaves < 0.34, "{jar}, {leaves}");
}

#[test]
fn a_drawing_fades_with_the_share_of_an_object() {
    let desk = Desk::new();
    let drawn = |flags: &str| drawn(&desk, &format!("{HAZE} --gain 8 {flags}"));
    let whole = drawn("");
    let of_head = drawn("--object Head");
    let of_half = drawn("--object Head --mix 0.5");
    let share = head();
    let (mut inside, mut along) = (0.0, 0.0);
    for (x, y) in places(&share) {
        let [all, own, half] = [&whole, &of_head, &of_half].map(|d| d[0].at(x, y));
        let wanted = share.at(x, y) * all;
        // Half floats: 2^-11 of each.
        let bound = 1e-3 * all + 1e-6;
        assert!((own - wanted).abs() <= bound, "{own} of {wanted}");
        assert!((half - 0.5 * wanted).abs() <= bound, "{half}");
        inside += f64::from(own);
        // Lines along edges keep their outer half: two pixels beside the head are theirs.
        let [all, own] = [&whole, &of_head].map(|d| d[1].at(x, y));
        assert!(own <= all, "{own} of {all}");
        along += f64::from(if share.at(x, y) == 0.0 { own } else { 0.0 });
        let is_beside = around(&share, [x, y], 1).any(|share| share > 0.6);
        assert!(!is_beside || own >= 0.599 * all, "{own} of {all}");
    }
    // Outlines in fog have no loops beside them: what is left is ink where the head has no share at all.
    assert!(inside > 100.0 && along > 5.0, "{inside}, {along}");
}

#[test]
fn what_no_manifest_names_is_found_by_the_hash_of_its_name() {
    let desk = Desk::new();
    // The same file with an unreadable manifest: one letter of its key is changed, at the same length.
    let mut bytes = desk.bytes(HAZE);
    let at = |bytes: &[u8], what: &[u8]| bytes.windows(what.len()).position(|w| w == what);
    while let Some(found) = at(&bytes, b"/manifest\0") {
        bytes[found + 1] = b'M';
    }
    desk.write("bare.exr", &bytes);
    // And without all that it says of Cryptomatte.
    while let Some(found) = at(&bytes, b"cryptomatte/") {
        bytes[found] = b'k';
    }
    desk.write("lost.exr", bytes);
    let named = red(&desk, &format!("{HAZE} --object Head"));
    for flags in [
        "--object Head",
        "--object #05777012",
        "--object 0x05777012",
        "--object 05777012",
        "--object #05777012 --object !Ring",
    ] {
        for input in ["bare.exr", "lost.exr"] {
            let words = format!("{input} {flags}");
            assert!(red(&desk, &words) == named, "{words}");
        }
    }
    // `inspect` lists the hashes of the largest ones. The share of the head is that of its samples.
    let percent = 100.0 * mean(&head());
    let row = format!("inspect bare.exr => 0: #05777012 ({percent:.1} %)");
    desk.check("{}", &row);
    let rows = "
        --object H* => 1: --object '#
        --object Nobody => 0: nothing of what is chosen
    ";
    desk.check("enhance bare.exr -o out.png {}", rows);
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
    let manifest = named.map(|(name, hash)| format!("\"{name}\":\"{hash:08x}\""));
    let manifest = format!("{{{}}}", manifest.collect::<Vec<_>>().join(","));
    let channels = [("R", &number), ("G", &whole), ("B", &none), ("A", &none)];
    let part = Part::of(channels.map(|(c, plane)| (format!("CryptoObject00.{c}"), plane)));
    let texts = [
        ("name", "CryptoObject"),
        ("hash", "MurmurHash3_32"),
        ("conversion", "uint32_to_float32"),
        ("manifest", &manifest),
    ];
    texts.into_iter().fold(part, |part, (key, text)| {
        part.text(&format!("cryptomatte/28322e9/{key}"), text)
    })
}

/// A grey picture of waves with normals, at this place.
fn waves(window: Window) -> Part {
    let plane = |sample: &dyn Fn(f32) -> f32| {
        let sample = |x: usize, _| sample((x as f32).sin());
        Plane::from_fn(window.width(), window.height(), sample)
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
    let desk = Desk::new();
    bands().write(&desk.at("crypto.exr"));
    waves(Window::from_size(64, 48)).write(&desk.at("beauty.exr"));
    waves(Window::from_size(48, 48)).write(&desk.at("small.exr"));
    let grey = image::RgbImage::from_pixel(64, 48, image::Rgb([128; 3]));
    grey.save(desk.at("photo.png")).unwrap();
    let flags = "--normal-space view --gain 8 --curvature-gain 1";
    // Of a photo too.
    for input in ["beauty.exr", "photo.png --normal beauty.exr"] {
        let red = |more: &str| red(&desk, &format!("{input} {flags} {more}"));
        let plain = red("--mix 0");
        // Which bands change. An exact name is no pattern; a pattern takes all that it fits, and what no name is known of
        // has a hash.
        for (object, expected) in [
            ("leaf_*_a", [true, false, false, false]),
            ("leaf_?_a", [true, true, false, false]),
            ("leaf_x_b", [false, false, true, false]),
            ("leaf_x_*", [false, true, true, false]),
            ("!leaf_*_a", [false, true, true, true]),
            ("0x3f444444", [false, false, false, true]),
            ("3f333333", [false, false, true, false]),
        ] {
            let made = red(&format!("--cryptomatte crypto.exr --object {object}"));
            let changed = [0, 1, 2, 3].map(|band| {
                let columns = 16 * band..16 * (band + 1);
                let [made, plain] = [&made, &plain].map(|p| p.rows_within(columns.clone(), 0..48));
                made.ne(plain)
            });
            assert_eq!(changed, expected, "{input} {object}");
        }
    }
    // Of a sequence each frame has its own file.
    for name in ["beauty", "crypto"] {
        for frame in 1..=2 {
            desk.copy(&format!("{name}.exr"), &format!("{name}.{frame}.exr"));
        }
    }
    let rows = "
        shape beauty.exr -o out.exr --normal-space view --cryptomatte crypto.exr --object leaf_x_b => 0
        enhance beauty.exr -o out.exr --normal-space view --cryptomatte crypto.exr --object leaf_x_b => 0
        relight beauty.exr -o out.exr --normal-space view --cryptomatte crypto.exr --object leaf_x_b => 0
        hatch beauty.exr -o out.exr --normal-space view --cryptomatte crypto.exr --object leaf_x_b => 0
        enhance beauty.#.exr --normal-space view -o out.#.exr --cryptomatte crypto.#.exr --object leaf_x_b --frames 1-2 => 0
        inspect beauty.exr --cryptomatte crypto.exr => 0: leaf_x_b
        enhance small.exr -o no.exr --cryptomatte crypto.exr --object leaf_x_b => 1: crypto.exr: is 64x48 ... small.exr has 48x48
        enhance beauty.exr -o no.exr --cryptomatte photo.png => 1: photo.png: has no Cryptomatte
        enhance beauty.exr -o no.exr --object leaf_x_b => 1: --cryptomatte FILE
    ";
    desk.check("{}", rows);
}

#[test]
fn lines_between_objects_are_those_of_a_pass_unless_it_is_a_mesh() {
    let desk = Desk::new();
    let plane = |sample: &dyn Fn(usize, usize) -> f32| Plane::from_fn(128, 96, sample);
    let [zero, one] = [0.0, 1.0].map(|value| plane(&|_, _| value));
    let halves = plane(&|x, _| if x < 64 { 1.0 } else { 2.0 });
    // A number for each square of 8 pixels: sides along 2/8 of the pixels.
    let squares = plane(&|x, y| (x / 8 + 100 * (y / 8)) as f32);
    for (file, index, numbers) in [
        ("halves.exr", "IndexOB.X", &halves),
        ("squares.exr", "IndexMA.X", &squares),
        ("bare.exr", "other.X", &halves),
    ] {
        let picture = ["R", "G", "B", "Z"].map(|name| (name, &one));
        let wall = [
            ("N.X", &zero),
            ("N.Y", &zero),
            ("N.Z", &one),
            (index, numbers),
        ];
        desk.write_exr(file, &[picture, wall].concat());
    }
    let drawn = |words: &str| {
        let said = desk.make(format!(
            "hatch {words} --normal-space view --layers results -o out.exr"
        ));
        (desk.channel("out.exr", "strokes.contours"), said.stderr)
    };
    let columns = |ink: &Plane| -> Vec<usize> {
        let has_ink = |&x: &usize| (0..96).any(|y| ink.at(x, y) > 0.0);
        (0..128).filter(has_ink).collect()
    };
    // A pixel wide, between columns 63 and 64.
    let (line, said) = drawn("halves.exr -v");
    assert_eq!(columns(&line), [63, 64]);
    assert!(
        said.contains("objects") && said.contains("IndexOB"),
        "{said}"
    );
    assert_eq!(drawn("bare.exr --cryptomatte halves.exr").0, line);
    assert!(columns(&drawn("halves.exr --object-lines off").0).is_empty());
    let (none, said) = drawn("squares.exr");
    assert!(columns(&none).is_empty());
    assert!(said.contains("IndexMA: its objects are so small"), "{said}");
}
