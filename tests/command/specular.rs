//! Mirrors and lenses on the command line.

use crate::common::program::Desk;

#[test]
fn a_mirror_is_drawn_and_lit() {
    // A pass of its own in drawings, a step of new light.
    let rows = "
        hatch --enlarge 2 => 0: ran   specular-trace
        relight --material mirror => 0: what mirrored or refracted sight lines meet
    ";
    let mirror = "--specular-mask Mirror --surroundings fixtures/mirror.surroundings.exr";
    let common = format!("{{}} fixtures/mirror.exr {mirror} --explain -o out.png");
    Desk::new().check(&common, rows);
}

#[test]
fn what_cannot_be_traced_is_refused_in_one_line() {
    let rows = "
        --specular-mask Mirror => 2: --specular-mask names mirrors, but nothing for them to show
        --back fixtures/mirror.exr => 2: --back bends sight lines
        --surroundings-camera x.json => 2: give --surroundings FILE
        --surroundings fixtures/bust.exr => 1: no equirectangular map
        --surroundings fixtures/tablet.color.jpg => 1: has no position layer
        --surroundings absent.exr => 1: absent.exr
        --behind fixtures/bust.exr => 1: but the picture is
        --surroundings fixtures/mirror.surroundings.exr --specular-mask Glass => 1: --specular-mask
        --surroundings fixtures/mirror.surroundings.exr --search-steps 0 => 2: --search-steps is 0
        --hit-position Glass => 1: --hit-position
    ";
    let desk = Desk::new();
    desk.check("hatch fixtures/mirror.exr -o out.png {}", rows);
    let rows = "
        hatch fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png => 1: camera
        relight fixtures/mirror.exr --light 90,40 => 2: --material is neither mirror nor glass
    ";
    desk.check(
        "{} --surroundings fixtures/mirror.surroundings.exr -o out.png",
        rows,
    );
}
