//! Pictures that do not fit in the memory they are given: the same bits, strip by strip.

use super::{bytes, ended, relievo, write_bumps};

/// 512 x 6400 pixels take about 310 MiB, of 100 bytes each; in 300 MiB a strip has some 900 rows.
const SIZE: [usize; 2] = [512, 6400];

#[test]
fn strips_are_the_whole_bit_for_bit() {
    let desk = tempfile::tempdir().unwrap();
    let here = desk.path();
    // Directions on the planes come from the bumps above and below.
    write_bumps(&here.join("in.exr"), 1, SIZE, 0.7, |y| y / 100 % 3 == 0);
    for (name, work) in [
        ("explicit", "enhance --solver explicit --layers results"),
        ("chebyshev", "enhance --scale 3 --foreshortening 0.5"),
        ("into", "enhance --layers channels --compression zips"),
        (
            "given",
            "enhance --curvature-gain 3 --white-level 0.5 --depth-of-output half",
        ),
        ("idle", "enhance --scaling 0"),
        ("layers", "shape --layers results"),
        (
            "scales",
            "shape --scale 2,3 --layers results --depth-of-output half",
        ),
        (
            "lit",
            "relight --light 30,40 --method both --albedo-from white",
        ),
        (
            "grain",
            "relight --light 30,40 --method scale --anisotropy 0.5 --albedo-from picture \
             --material ashikhmin-shirley --coat 10,200 --tangent curvature",
        ),
    ] {
        for (kind, memory) in [("whole", "8G"), ("strips", "300M")] {
            let words = format!("{work} in.exr -o {name}.{kind}.exr --max-memory {memory}");
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
    write_bumps(&here.join("in.exr"), 1, SIZE, 0.7, |_| false);
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
            "relight in.exr -o out.exr --light 30,40 --max-memory 300M",
            "estimates the albedo",
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
