//! Channels added to a part: the existing ones stay, bit for bit.

use super::*;
use ::exr::prelude as reference;
use ::exr::prelude::{AnyChannel, AnyChannels, Blocks, Compression, FlatSamples, LineOrder, Vec2};
use ::exr::prelude::{ReadChannels, ReadLayers, WritableImage};
use half::f16;
use relievo::io::exr::SampleType;

/// Content of a channel, bit for bit, by the reference reader.
fn stored(samples: &FlatSamples) -> Vec<u32> {
    match samples {
        FlatSamples::F16(s) => s.iter().map(|v| v.to_bits().into()).collect(),
        FlatSamples::F32(s) => s.iter().map(|v| v.to_bits()).collect(),
        FlatSamples::U32(s) => s.clone(),
    }
}

/// Name and stored bits of every channel of every part, by the reference reader.
fn all_stored(bytes: &[u8]) -> Vec<Vec<(String, Vec<u32>)>> {
    let image = reference::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .from_buffered(Cursor::new(bytes))
        .unwrap();
    let layers = image.layer_data.into_iter();
    let channels = layers.map(|layer| {
        let channels = layer.channel_data.list.into_iter();
        let named = channels.map(|c| (c.name.to_string(), stored(&c.sample_data)));
        named.collect()
    });
    channels.collect()
}

/// A file of the size and place of `part`, with samples that do not survive conversion: unsigned
/// integers past 2^24, and halves that are NaN with every payload.
fn foreign(compression: Compression, blocks: Blocks) -> Vec<u8> {
    let (width, height) = (23, 71);
    let range = 0..(width * height) as u32;
    let all = || range.clone();
    let halves = all().map(|i| f16::from_bits(0x7c00 | (i % 1024) as u16));
    let plain = all().map(|i| f16::from_f32(i as f32 * 0.25));
    let floats = all().map(|i| f32::from_bits(0x7f80_0000 + i * 5000));
    let ids = all().map(|i| u32::MAX - i);
    let channels = [
        ("R", FlatSamples::F16(plain.clone().collect())),
        ("G", FlatSamples::F16(plain.clone().rev().collect())),
        ("B", FlatSamples::F16(plain.collect())),
        ("id", FlatSamples::U32(ids.collect())),
        ("odd", FlatSamples::F16(halves.collect())),
        ("Z", FlatSamples::F32(floats.collect())),
    ];
    let channels = channels.map(|(name, samples)| AnyChannel::new(name, samples));
    let mut attributes = reference::LayerAttributes::named("own");
    attributes.layer_position = Vec2(-4, 9);
    attributes.comments = Some("as it was".into());
    let encoding = reference::Encoding {
        compression,
        blocks,
        line_order: LineOrder::Increasing,
    };
    let channels = AnyChannels::sort(channels.into_iter().collect());
    let layer = reference::Layer::new((width, height), attributes, encoding, channels);
    let (mut bytes, image) = (Cursor::new(Vec::new()), reference::Image::from_layer(layer));
    image.write().to_buffered(&mut bytes).unwrap();
    bytes.into_inner()
}

#[test]
fn the_channels_of_the_part_keep_every_bit() {
    let planes = planes();
    let part = part(&planes);
    let tiles = Blocks::Tiles(Vec2(16, 32));
    for (compression, name) in [
        (Compression::Uncompressed, Some("none")),
        (Compression::RLE, Some("rle")),
        (Compression::ZIP1, Some("zips")),
        (Compression::ZIP16, Some("zip")),
        (Compression::PIZ, Some("piz")),
        (Compression::PXR24, None),
        (Compression::B44, None),
        (Compression::DWAA(None), None),
        (Compression::DWAB(Some(10.0)), None),
    ] {
        for blocks in [Blocks::ScanLines, tiles] {
            let bytes = foreign(compression, blocks);
            let (_directory, input) = saved(&bytes, &Limits::default());
            let (bytes_after, report) = merged(&input, 0, &part);
            let (_directory, output) = saved(&bytes_after, &Limits::default());
            let case = format!("{compression:?} {blocks:?}");

            // Lossy compression is decoded once, and not applied again.
            let [before, after] = [&bytes, &bytes_after].map(|b| all_stored(b));
            assert_eq!(after.len(), 1, "{case}");
            let own = |(n, _): &&(String, Vec<u32>)| !n.ends_with(".Z");
            assert!(after[0].iter().filter(own).eq(&before[0]), "{case}");

            let [ours, theirs] = [&output.parts[0], &input.parts[0]];
            assert_eq!(ours.compression, name.unwrap_or("zip"), "{case}");
            assert_eq!(report.warnings.len(), usize::from(name.is_none()), "{case}");
            assert!(!ours.tiled && ours.window == theirs.window, "{case}");
            assert_eq!(output.attributes["comments"], "as it was", "{case}");
            assert_eq!(output.attributes["software"], "relievo test", "{case}");
            assert_eq!(report.channels, ["b.Z", "c.Z", "a.Z"], "{case}");
            for (plane, name) in planes.iter().zip(&report.channels) {
                let channel = ours.channels.iter().position(|c| &c.name == name).unwrap();
                let id = output.channel_ids().nth(channel).unwrap();
                let read = output.read_channels(&[id]).unwrap();
                assert!(bits(&read[0]) == bits(plane), "{case} {name}");
            }
        }
    }
}

#[test]
fn other_parts_stay_as_they_were() {
    let planes = planes();
    let mut part = part(&planes);
    let bytes = foreign(Compression::DWAA(None), Blocks::Tiles(Vec2(32, 16)));
    let (_directory, single) = saved(&bytes, &Limits::default());
    let two = appended(&single, &part);
    let (_directory, input) = saved(&two, &Limits::default());
    for channel in &mut part.channels {
        channel.name = format!("more.{}", channel.name);
    }
    // To the second part: the DWA tiles of the first are copied.
    let (bytes, report) = merged(&input, 1, &part);
    let (_directory, output) = saved(&bytes, &Limits::default());
    assert_eq!(report.warnings, [""; 0]);
    assert_eq!(output.parts[0], input.parts[0]);
    assert_eq!(output.parts[1].name, input.parts[1].name);
    assert_eq!(output.parts[1].channels.len(), 6);
    let [before, after] = [&two, &bytes].map(|b| all_stored(b));
    assert_eq!(before[0], after[0]);
}

#[test]
fn a_layer_whose_channels_exist_is_renamed() {
    let planes = planes();
    let bytes = foreign(Compression::ZIP16, Blocks::ScanLines);
    let (_directory, input) = saved(&bytes, &Limits::default());
    let mut part = part(&planes);
    part.name = "relievo".into();
    for (channel, name) in part.channels.iter_mut().zip(["R", "A", "tone.V"]) {
        channel.name = name.into();
    }
    // A is free, but belongs to R.
    let (bytes, report) = merged(&input, 0, &part);
    assert_eq!(report.channels, ["relievo.R", "relievo.A", "tone.V"]);
    let (_directory, once) = saved(&bytes, &Limits::default());
    let (bytes, report) = merged(&once, 0, &part);
    assert_eq!(report.channels, ["relievo.2.R", "relievo.2.A", "tone.2.V"]);
    let (_directory, twice) = saved(&bytes, &Limits::default());
    assert_eq!(twice.parts[0].channels.len(), 12);
    let ids = twice.parts[0].channels.iter().find(|c| c.name == "id");
    assert_eq!(ids.unwrap().sample_type, SampleType::Uint);
}

#[test]
fn a_part_with_another_window_is_refused() {
    let plane = Plane::filled(5, 5, 0.0);
    let planes = [plane.clone(), plane.clone(), plane];
    let mut part = part(&planes);
    part.data_window = Window::from_size(5, 5);
    let bytes = foreign(Compression::ZIP16, Blocks::ScanLines);
    let (_directory, input) = saved(&bytes, &Limits::default());
    let mut file = Cursor::new(Vec::new());
    let (target, description) = (Path::new(TARGET), part.description());
    let writer = PartWriter::add_channels(&input, 0, &mut file, target, &description);
    let error = writer.err().unwrap();
    assert!(error.to_string().contains("5x5"), "{error}");
    assert!(file.into_inner().is_empty());
}

#[test]
fn a_part_that_is_added_to_does_not_depend_on_how_rows_were_cut() {
    let planes = planes();
    let part = part(&planes);
    // Bands of 256, 32 and 1 rows.
    for compression in [Compression::DWAB(None), Compression::PIZ, Compression::RLE] {
        let bytes = foreign(compression, Blocks::ScanLines);
        let (_directory, input) = saved(&bytes, &Limits::default());
        let (expected, _) = merged(&input, 0, &part);
        for heights in HEIGHTS {
            let mut file = Cursor::new(Vec::new());
            let description = part.description();
            let target = Path::new(TARGET);
            let added = PartWriter::add_channels(&input, 0, &mut file, target, &description);
            push_in_strips(added.unwrap().0, &planes, heights);
            assert!(file.into_inner() == expected, "{compression:?} {heights:?}");
        }
    }
}

#[test]
fn our_own_results_are_added_to_a_second_time() {
    let planes = planes();
    let (_directory, input) = saved(&whole(&part(&planes)), &Limits::default());
    let (bytes, report) = merged(&input, 0, &part(&planes));
    assert_eq!(report.channels, ["b.2.Z", "c.2.Z", "a.2.Z"]);
    let (_directory, output) = saved(&bytes, &Limits::default());
    let read = read_all(&output);
    // a.2.Z, a.Z, b.2.Z, b.Z, ...: each beside its twin.
    for pair in read.chunks(2) {
        assert_eq!(bits(&pair[0]), bits(&pair[1]));
    }
}
