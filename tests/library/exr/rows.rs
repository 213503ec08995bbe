//! Rows on demand, and files written strip by strip: both equal reading and writing whole.

use super::*;
use relievo::io::exr::OutputCompression;

/// The bits of the rows `rows`.
fn row_bits(plane: &Plane, rows: Range<usize>) -> Vec<u32> {
    let all = bits(plane);
    all[rows.start * plane.width()..rows.end * plane.width()].to_vec()
}

#[test]
fn a_file_does_not_depend_on_how_its_rows_were_cut() {
    let planes = planes();
    let mut part = part(&planes);
    for compression in OutputCompression::ALL {
        part.compression = compression;
        let expected = whole(&part);
        for heights in HEIGHTS {
            let mut file = Cursor::new(Vec::new());
            let description = part.description();
            let writer = PartWriter::create(&mut file, Path::new(TARGET), &description);
            push_in_strips(writer.unwrap(), &planes, heights);
            assert!(file.into_inner() == expected, "{compression} {heights:?}");
        }
    }
}

#[test]
fn a_part_added_does_not_depend_on_how_its_rows_were_cut() {
    let planes = planes();
    let part = part(&planes);
    let (_directory, own) = saved(&whole(&part), &Limits::default());
    let others = files(
        "conformance/structure/lineOrder_decreasing conformance/multires/MirrorPattern
        renders/tiny_bunny_64_multipart",
    );
    for input in std::iter::once(own).chain(others.map(|path| open(&path))) {
        let (expected, description) = (appended(&input, &part), part.description());
        for heights in HEIGHTS {
            let mut file = Cursor::new(Vec::new());
            let writer = PartWriter::append(&input, &mut file, Path::new(TARGET), &description);
            push_in_strips(writer.unwrap(), &planes, heights);
            assert!(file.into_inner() == expected, "{heights:?}");
        }
    }
}

#[test]
fn lossless_compressions_keep_every_sample_and_dwa_keeps_colours_close() {
    // A ramp in the colours, and a NaN sample in alpha.
    let color = Plane::from_fn(67, 300, |x, y| 0.01 * x as f32 + 0.002 * y as f32);
    let mut alpha = Plane::filled(67, 300, 1.0);
    alpha.samples_mut()[5] = f32::NAN;
    let channels = [("R", &color), ("G", &color), ("B", &color), ("A", &alpha)];
    let channels = channels.map(|(name, plane)| (name, plane, OutputType::Float));
    for compression in OutputCompression::ALL {
        let part = OutputPart {
            compression,
            ..part_of("ramp", Window::from_size(67, 300), &channels)
        };
        let (_directory, file) = saved(&whole(&part), &Limits::default());
        assert_eq!(file.parts[0].compression, compression.name());
        // A, B, G, R.
        for (i, plane) in read_all(&file).iter().enumerate() {
            let expected = if i == 0 { &alpha } else { &color };
            match file.parts[0].is_lossy(i) {
                false => assert!(bits(plane) == bits(expected), "{compression}"),
                true => {
                    assert!(compression.is_lossy());
                    // Far below the step of 0.01 between pixels; the ramp ends at 1.27.
                    let apart = apart(plane, expected);
                    assert!(apart < 5e-3, "{compression} {apart}");
                }
            }
        }
    }
}

#[test]
fn data_are_not_compressed_with_loss() {
    let planes = planes();
    let mut part = part(&planes);
    part.compression = OutputCompression::Dwaa;
    part.channels[1].name = "normal.Y".into();
    let mut file = Cursor::new(Vec::new());
    let error = write_results(&mut file, Path::new(TARGET), &part).unwrap_err();
    assert!(error.to_string().contains("normal.Y"), "{error}");
    assert!(file.into_inner().is_empty());
}

/// Compares rows with the same rows of whole channels.
fn check_rows(file: &ExrFile) {
    for part in 0..file.parts.len() {
        let wanted: Vec<ChannelId> = file.channel_ids().filter(|id| id.part == part).collect();
        // One channel twice, and not in order.
        let wanted = [&wanted[wanted.len() / 2..], &wanted[..1]].concat();
        let whole = file.read_channels(&wanted).unwrap();
        let height = file.parts[part].window.height();
        let mut ranges = vec![0..height, height..height, 0..0, height / 2..height];
        ranges.extend([0..1, height - 1..height, height / 3..height - height / 4]);
        let strip = (height / 5).max(3);
        let strips = (0..height).step_by(strip);
        ranges
            .extend(strips.map(|y| y.saturating_sub(strip / 2)..height.min(y + strip + strip / 3)));
        for rows in ranges {
            let alone = file.read_rows(&wanted, rows.clone()).unwrap();
            for (whole, alone) in whole.iter().zip(&alone) {
                let expected = row_bits(whole, rows.clone());
                let name = file.path.display();
                assert_eq!((alone.width(), alone.height()), (whole.width(), rows.len()));
                assert!(bits(alone) == expected, "{name} {rows:?}");
            }
        }
    }
}

#[test]
fn rows_are_those_of_the_whole() {
    let planes = planes();
    check_rows(&saved(&whole(&part(&planes)), &Limits::default()).1);
    let folders = ["compression/f16", "compression/f32"];
    let folders = folders.map(|f| real(&format!("conformance/{f}")));
    let listed = folders.into_iter().flatten().flat_map(|folder| {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().path())
    });
    let named = files(
        "conformance/structure/lineOrder_decreasing conformance/structure/tiled_with_scanlineimage_type
        conformance/multires/MirrorPattern conformance/displaywindow/t16
        renders/suzanne_640_half_dwaa renders/tiny_bunny_64_multipart",
    );
    for path in named.chain(listed) {
        if let Ok(file) = ExrFile::open(&path, &Limits::default()) {
            check_rows(&file);
        }
    }
}

#[test]
fn limits_count_for_the_rows_that_are_read() {
    let planes = planes();
    // 23 columns of 71 rows are 1633 pixels; 20 rows are 460.
    let limits = default_but(|limits: &mut Limits| limits.max_pixels = 500);
    let (_directory, file) = saved(&whole(&part(&planes)), &limits);
    let wanted = ids(&file);
    let error = file.read_channels(&wanted).unwrap_err().to_string();
    assert!(error.contains("1633 pixels"), "{error}");
    assert!(file.read_rows(&wanted, 40..62).is_err());
    assert_eq!(file.read_rows(&wanted, 40..60).unwrap()[0].height(), 20);
    let few_bytes = default_but(|limits: &mut Limits| limits.max_bytes = 1000);
    let (_directory, file) = saved(&whole(&part(&planes)), &few_bytes);
    assert!(file.read_channels(&wanted).is_err());
}

#[test]
fn only_the_blocks_that_hold_the_rows_are_read() {
    let planes = planes();
    let mut bytes = whole(&part(&planes));
    // The last of five blocks, rows 64 to 70, claims another position.
    let place = 73i32.to_le_bytes();
    let at = bytes.windows(4).rposition(|w| w == place).unwrap();
    bytes[at] ^= 1;
    let (_directory, file) = saved(&bytes, &Limits::default());
    let wanted = ids(&file);
    assert!(file.read_rows(&wanted, 0..64).is_ok());
    assert!(file.read_rows(&wanted, 60..65).is_err());
}
