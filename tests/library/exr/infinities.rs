//! Values beyond half floats are clamped and counted, and never read back as infinite.

use super::*;
use relievo::io::exr::OutputCompression;

const SIZE: [usize; 2] = [67, 40];

/// Writes three equal colours and a depth; returns the number of clamped samples, and red and depth as read back.
fn written(
    color: &Plane,
    sample_type: OutputType,
    compression: OutputCompression,
) -> (u64, [Plane; 2]) {
    let depth = Plane::filled(SIZE[0], SIZE[1], 1e9);
    let channels = [
        ("R", color),
        ("G", color),
        ("B", color),
        ("depth.Z", &depth),
    ];
    let channels = channels.map(|(name, plane)| (name, plane, sample_type));
    let part = OutputPart {
        chromaticities: None,
        compression,
        ..part_of("bright", Window::from_size(SIZE[0], SIZE[1]), &channels)
    };
    let mut file = Cursor::new(Vec::new());
    let writer = PartWriter::create(&mut file, Path::new(TARGET), &part.description());
    let mut writer = writer.unwrap();
    let planes: Vec<&Plane> = part.channels.iter().map(|channel| channel.plane).collect();
    // In two strips, the first of which ends within a block.
    writer.push(&planes, 0..21).unwrap();
    writer.push(&planes, 21..SIZE[1]).unwrap();
    let clamped = writer.finish().unwrap();
    let (_directory, file) = saved(&file.into_inner(), &Limits::default());
    // Channels are in the order of their names: B, G, R, depth.Z.
    let read = [2, 3].map(|channel| ChannelId { part: 0, channel });
    let planes = file.read_channels(&read).unwrap();
    (clamped, planes.try_into().unwrap())
}

fn largest(plane: &Plane) -> f32 {
    let sizes = plane.samples().iter().map(|v| v.abs());
    sizes.fold(0.0, f32::max)
}

#[test]
fn dwa_keeps_bright_colours_finite_and_says_how_many_were_clamped() {
    let [width, height] = SIZE;
    let pixels = (width * height) as u64;
    // Cosines overshoot at stripes and checks one pixel wide; a ramp finds the limit of every block.
    type Pattern = fn(usize, usize) -> bool;
    let patterns: [Pattern; 4] = [
        |x, _| x % 2 == 0,
        |x, y| (x + y) % 2 == 0,
        |x, _| x % 8 < 4,
        |_, _| true,
    ];
    for compression in [OutputCompression::Dwaa, OutputCompression::Dwab] {
        for pattern in patterns {
            let bright = |value: f32| {
                Plane::from_fn(
                    width,
                    height,
                    |x, y| if pattern(x, y) { value } else { 0.0 },
                )
            };
            let count = bright(1.0).samples().iter().filter(|&&v| v == 1.0).count() as u64;
            for value in [1e9, -1e9, 65504.0, f32::INFINITY, 60_000.0, 40_000.0] {
                for sample_type in [OutputType::Float, OutputType::Half] {
                    let name = format!("{compression} {sample_type:?} {value}");
                    let (clamped, [color, depth]) =
                        written(&bright(value), sample_type, compression);
                    let most = largest(&color);
                    assert!(most.is_finite() && most > 15_000.0, "{name}: {most}");
                    // Depth is no colour: floats keep it, halves do not, and count it.
                    let (of_depth, expected) = match sample_type {
                        OutputType::Float => (0, 1e9),
                        OutputType::Half => (pixels, 65504.0),
                    };
                    assert_eq!(largest(&depth), expected, "{name}");
                    let of_color = clamped - of_depth;
                    match value.abs() > 65504.0 {
                        true => assert_eq!(of_color, 3 * count, "{name}"),
                        false => {
                            assert!(of_color == 0 || of_color == 3 * count, "{name}: {of_color}")
                        }
                    }
                }
            }
            // Values clear of the limit are unchanged.
            let (clamped, _) = written(&bright(32_768.0), OutputType::Float, compression);
            assert_eq!(clamped, 0);
        }
    }
}

#[test]
fn no_picture_however_bright_comes_back_infinite_from_dwa() {
    // Noise over all of half precision: 2^-4 to 2^16, of either sign, by a fixed generator.
    let mut state = 1_u32;
    let mut next = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32
    };
    for round in 0..20 {
        let least = if round % 2 == 0 { -4.0 } else { 14.5 };
        let noise = Plane::from_fn(SIZE[0], SIZE[1], |_, _| {
            let size = (least + (16.5 - least) * next()).exp2();
            if round % 4 < 2 && next() < 0.5 {
                -size
            } else {
                size
            }
        });
        let (_, [color, _]) = written(&noise, OutputType::Float, OutputCompression::Dwaa);
        assert!(largest(&color).is_finite(), "round {round}");
    }
}

#[test]
fn halves_count_what_they_clamp_and_floats_clamp_nothing() {
    let [width, height] = SIZE;
    // 65519 still rounds to 65504; 65520 is the first that does not. Infinities and NaN were none to begin with.
    let values = [65_519.0, 65_520.0, -1e30, f32::INFINITY, f32::NAN, 1.0];
    let color = Plane::from_fn(width, height, |x, y| values[(x + y * width) % 6]);
    let two_of_six = (0..width * height)
        .filter(|i| [1, 2].contains(&(i % 6)))
        .count() as u64;
    let pixels = (width * height) as u64;
    let (clamped, [read, _]) = written(&color, OutputType::Half, OutputCompression::Zip);
    assert_eq!(clamped, 3 * two_of_six + pixels);
    assert_eq!(read.samples()[..3], [65504.0, 65504.0, -65504.0]);
    assert_eq!(read.samples()[3], f32::INFINITY);
    assert!(read.samples()[4].is_nan());
    let (clamped, [read, _]) = written(&color, OutputType::Float, OutputCompression::Piz);
    assert_eq!((clamped, read.samples()[2]), (0, -1e30));
}
