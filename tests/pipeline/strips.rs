//! Pictures that do not fit in the memory they are given: the same bits, strip by strip.

use super::{bytes, ended, relievo, write_bumps};

/// 512 x 6400 pixels take about 310 MiB, of 100 bytes each; in 300 MiB a strip has some 900 rows.
const SIZE: [usize; 2] = [512, 6400];

#[test]
fn strips_are_the_whole_bit_for_bit() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_bumps(&here.join("in.exr"), 1, SIZE, 0.7);
    for (name, flags) in [
        ("explicit", "--solver explicit --layers results"),
        ("chebyshev", "--scale 3 --foreshortening 0.5"),
        ("into", "--layers channels --compression zips"),
        (
            "given",
            "--curvature-gain 3 --white-level 0.5 --depth-of-output half",
        ),
        ("idle", "--scaling 0"),
    ] {
        for (kind, memory) in [("whole", "8G"), ("strips", "300M")] {
            let words =
                format!("enhance in.exr -o {name}.{kind}.exr --max-memory {memory} {flags}");
            ended(relievo(here, &words), 0);
        }
        let [whole, strips] = ["whole", "strips"].map(|k| bytes(here, &format!("{name}.{k}.exr")));
        assert!(whole == strips, "{name}");
    }
}

#[test]
fn what_needs_the_picture_whole_is_refused() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    write_bumps(&here.join("in.exr"), 1, SIZE, 0.7);
    for (words, expected) in [
        (
            "hatch in.exr -o out.png --max-memory 300M",
            "needs the picture whole",
        ),
        (
            "enhance in.exr -o out.png --max-memory 300M",
            "from EXR to EXR alone",
        ),
        (
            "enhance in.exr -o out.exr --max-memory 100M",
            "even in strips",
        ),
    ] {
        let said = ended(relievo(here, words), 1);
        assert!(
            said.contains(expected) && said.contains("--max-memory"),
            "{said}"
        );
        assert_eq!(said.lines().count(), 1, "{said}");
    }
}
