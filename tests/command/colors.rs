//! Colour spaces: layers keep theirs, displays get sRGB, data are never touched.

use super::{Part, ended, relievo, write_part};
use relievo::frame::Plane;
use relievo::io::exr::{ChannelId, ExrFile};
use relievo::io::photo::Photo;
use std::path::Path;

/// A wall of one colour.
fn write_wall(path: &Path, color: [f32; 3], chromaticities: Option<[f32; 8]>) {
    let flat = |value| Plane::filled(8, 8, value);
    let [r, g, b] = color.map(flat);
    let channels = [
        ("R", r),
        ("G", g),
        ("B", b),
        ("N.X", flat(0.0)),
        ("N.Y", flat(0.0)),
        ("N.Z", flat(1.0)),
    ];
    write_part(path, &channels, Part { chromaticities });
}

fn pixel(path: &Path, name: &str) -> f32 {
    let file = ExrFile::open(path, &Default::default()).unwrap();
    let index = |id: &ChannelId| file.parts[id.part].channels[id.channel].name == name;
    let id = file.channel_ids().find(index).unwrap();
    file.read_channels(&[id]).unwrap()[0].at(3, 3)
}

fn shown(path: &Path) -> [f32; 3] {
    let photo = Photo::read(path).unwrap().to_linear();
    [0, 1, 2].map(|c| photo[c].at(3, 3))
}

#[test]
fn acescg_is_shown_in_srgb_and_kept_in_layers() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_wall(&here.join("told.exr"), [0.5, 0.4, 0.2], None);
    // The file itself says AP1.
    let ap1 = relievo::io::colorspace::AP1;
    write_wall(&here.join("tagged.exr"), [0.5, 0.4, 0.2], Some(ap1));
    // 1.70505 * 0.5 - 0.62179 * 0.4 - 0.08326 * 0.2, and so on, of the published matrix.
    let expected = [0.5872, 0.3891, 0.1670];
    for (name, flags) in [("told", "--colorspace acescg"), ("tagged", "")] {
        for format in ["hdr", "png"] {
            let words = format!("enhance {name}.exr -o {name}.{format} --scaling 0 {flags}");
            ended(relievo(here, &words), 0);
            let found = shown(&here.join(format!("{name}.{format}")));
            for (found, expected) in found.into_iter().zip(expected) {
                // A step of RGBE, or of 8 bits at these brightnesses.
                assert!(
                    (found - expected).abs() < 0.006,
                    "{name}.{format}: {found} for {expected}"
                );
            }
        }
        let words =
            format!("enhance {name}.exr -o {name}.out.exr --scaling 0 --layers results {flags}");
        ended(relievo(here, &words), 0);
        let out = here.join(format!("{name}.out.exr"));
        assert_eq!(
            [pixel(&out, "R"), pixel(&out, "G"), pixel(&out, "B")],
            [0.5, 0.4, 0.2]
        );
        let file = ExrFile::open(&out, &Default::default()).unwrap();
        assert_eq!(file.chromaticities, Some(ap1));
    }
}

#[test]
fn encoded_colours_are_made_linear_and_data_are_not() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_wall(&here.join("in.exr"), [0.5, 0.25, 1.0], None);
    ended(
        relievo(
            here,
            "enhance in.exr -o out.exr --scaling 0 --layers results --colorspace srgb",
        ),
        0,
    );
    // ((0.5 + 0.055) / 1.055)^2.4 and ((0.25 + 0.055) / 1.055)^2.4.
    for (name, expected) in [("R", 0.214_041), ("G", 0.050_876), ("B", 1.0)] {
        let found = pixel(&here.join("out.exr"), name);
        assert!((found - expected).abs() < 1e-5, "{name}: {found}");
    }
    ended(
        relievo(
            here,
            "shape in.exr -o shape.exr --layers results --colorspace srgb",
        ),
        0,
    );
    assert_eq!(pixel(&here.join("shape.exr"), "normal.z"), 1.0);
    // A photo of linear numbers: what is stored is what counts.
    ended(
        relievo(
            here,
            "enhance in.exr -o linear.png --scaling 0 --view-transform none",
        ),
        0,
    );
    ended(
        relievo(
            here,
            "enhance linear.png --normal in.exr -o again.exr --scaling 0 --colorspace linear",
        ),
        0,
    );
    let found = pixel(&here.join("again.exr"), "R");
    assert!((found - 0.5).abs() < 0.003, "{found}");
}
