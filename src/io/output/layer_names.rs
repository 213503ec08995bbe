//! The names of our channels in an EXR.
//!
//! Blender splits a name at its dots into layer, pass and channel, and shows passes of three or four channels, and of one
//! channel named by one letter. Others take everything before the last dot as the layer. So the picture and vectors of
//! three components are layers, and each other number is a layer of its own with the channel `V`.

use crate::product::PART;

/// The channel name for the `short` name in our tables: `normal.x`, `curvature.kappa`, `relievo.R`.
///
/// A picture in a file of its own keeps the bare `R`, `G`, `B` and `A`.
pub(crate) fn full_name(short: &str) -> String {
    let Some((layer, component)) = short.rsplit_once('.') else {
        return short.into();
    };
    match (layer, component) {
        (PART, _) => format!("{PART}.Picture.{component}"),
        ("normal", _) => format!("{PART}.Normal.{component}"),
        _ => format!("{PART}.{}{}.V", in_capitals(layer), in_capitals(component)),
    }
}

/// Names that select a channel: its full name, its layer, and each word of it.
#[cfg(feature = "cli")]
pub(crate) fn names_of(channel: &str) -> impl Iterator<Item = &str> {
    let layer = channel.rsplit_once('.').map(|(layer, _)| layer);
    std::iter::once(channel)
        .chain(layer)
        .chain(channel.split('.'))
}

/// `direction_view` as `DirectionView`; numbers keep their underscores: `curvature_2_5px` is `Curvature_2_5px`.
fn in_capitals(name: &str) -> String {
    let words = name.split('_');
    words
        .map(|word| {
            let mut letters = word.chars();
            match letters.next() {
                Some(digit) if digit.is_ascii_digit() => format!("_{word}"),
                Some(first) => first.to_ascii_uppercase().to_string() + letters.as_str(),
                None => String::new(),
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::product::Product;

    #[test]
    fn every_channel_has_a_full_name_of_three_words_and_one_letter() {
        let products = Product::all().flat_map(|p| p.channels().chain(p.channels_at(2.5)));
        let others = [
            "normal.x",
            "relievo.R",
            "strokes.hatching",
            "weights.confidence",
        ];
        let short: Vec<String> = products.chain(others.map(String::from)).collect();
        let mut full: Vec<String> = short.iter().map(|name| full_name(name)).collect();
        for name in &full {
            let words: Vec<&str> = name.split('.').collect();
            assert_eq!(
                (words.len(), words[0], words[2].len()),
                (3, PART, 1),
                "{name}"
            );
        }
        full.sort();
        full.dedup();
        assert_eq!(full.len(), short.len());
        for (short, full) in [
            ("relievo.A", "relievo.Picture.A"),
            ("normal.y", "relievo.Normal.y"),
            ("curvature.kappa", "relievo.CurvatureKappa.V"),
            ("curvature_2_5px.u", "relievo.Curvature_2_5pxU.V"),
            ("direction_view.x", "relievo.DirectionViewX.V"),
            ("G", "G"),
        ] {
            assert_eq!(full_name(short), full);
        }
    }
}
