//! `relievo relight` as a user runs it.

use crate::common::program::Desk;
use relievo::frame::Plane;
use relievo::io::photo::Photo;
use relievo::io::read_environment;

/// The photo of the tablet and its normal map in new light.
fn tablet(desk: &Desk, flags: &str) -> Photo {
    let photo = "fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png";
    desk.picture(format!("relight {photo} {flags}"))
}

/// A desk with a small sky, bright to the left of the viewer.
fn under_a_sky() -> Desk {
    let desk = Desk::new();
    // Column 16 of 64 is a quarter turn left of the view direction.
    let pixel = |x: u32, _| image::Rgb([if (8..24).contains(&x) { 4.0_f32 } else { 0.25 }; 3]);
    let sky = image::Rgb32FImage::from_fn(64, 32, pixel);
    sky.save(desk.at("sky.hdr")).unwrap();
    desk
}

/// Mean of a channel over the left and over the right half.
fn halves(plane: &Plane) -> [f32; 2] {
    let half = plane.width() / 2;
    let mut sums = [0.0; 2];
    for y in 0..plane.height() {
        for (x, v) in plane.row(y).iter().enumerate() {
            sums[usize::from(x >= half)] += v;
        }
    }
    sums
}

#[test]
fn a_photo_is_lit_anew_by_every_method_and_keeps_its_size() {
    let desk = Desk::new();
    let made = ["plain", "warp", "scale", "both"].map(|method| {
        let photo = tablet(&desk, &format!("--light 75,10 --method {method}"));
        assert_eq!((photo.width, photo.height), (256, 256));
        photo.channels
    });
    for (i, a) in made.iter().enumerate() {
        let differs = made[i + 1..].iter().all(|b| a != b);
        assert!(differs, "two methods gave one picture");
    }
}

#[test]
fn colours_of_lights_and_of_the_photo_meet() {
    let flags = "--light 90,45,1,0,0 --ambient 0 --method plain";
    let red = tablet(&Desk::new(), flags);
    assert!(red.channels[0].samples().iter().any(|&v| v > 0.3));
    assert!(red.channels[1].samples().iter().all(|&v| v == 0.0));
}

#[test]
fn every_material_runs_in_an_environment() {
    let desk = under_a_sky();
    for material in [
        "lambert",
        "phong",
        "blinn-phong",
        "toon",
        "sublambert",
        "ashikhmin-shirley",
        "mirror",
        "glass",
    ] {
        let flags = format!("--environment sky.hdr --material {material}");
        let made = tablet(&desk, &flags);
        let samples = made.channels[0].samples().iter();
        let lit = samples.filter(|&&v| v > 0.02).count();
        assert!(lit > 10_000, "{material} shows {lit} lit pixels");
    }
}

#[test]
fn an_environment_lights_from_the_side_where_it_is_bright() {
    // Left of the map's middle is left of the viewer; rotated by half a turn it is right.
    let desk = under_a_sky();
    let sky = read_environment(&desk.at("sky.hdr")).unwrap();
    assert!(sky.radiance([-1.0, 0.0, 0.0])[0] > 3.0);
    let lit = |turn: &str| {
        let flags = "--environment sky.hdr --method plain --albedo-from white --environment-rotate";
        let lit = desk.picture(format!("relight fixtures/bust.exr {flags} {turn}"));
        halves(&lit.channels[0])
    };
    let ([left, right], [turned_left, turned_right]) = (lit("0"), lit("180"));
    let [straight, turned] = [left / right, turned_left / turned_right];
    assert!(straight > 1.2 * turned, "{straight} {turned}");
}

#[test]
fn explain_tells_what_was_left_out() {
    let rows = "
        // Equation 1 needs no Jacobian.
        --environment sky.hdr --method warp --warp-by lookups => 0: -     jacobian  ... warping: strength
        --environment sky.hdr --method warp => 0: jacobian:
        // Isotropic scaling needs no eigenvectors, nor the Hessian; lights with directions need no prefilter.
        --light 135,40 --method scale => 0: -     directions
        // Plain light needs nothing of shape.
        --light 135,40 --method plain => 0: -     conductance  ... -     diffusion  ... -     trace  ... -     auto-gain
    ";
    let desk = under_a_sky();
    desk.check("relight fixtures/bust.exr -o out.png --explain -v {}", rows);
    let scaled = "relight fixtures/bust.exr -o out.png --explain -v --light 135,40 --method scale";
    let scaled = desk.make(scaled).stdout;
    for (stage, reason) in [
        ("hessian", "no eigenvectors"),
        ("environment-prefilter", "directions"),
    ] {
        let mut lines = scaled.lines();
        let line = lines.find(|line| line.split_whitespace().nth(1) == Some(stage));
        assert!(line.unwrap().contains(reason), "{stage}: {scaled}");
    }
}

#[test]
fn light_that_is_hardly_meant_is_told() {
    let desk = Desk::new();
    let rows = "
        => 0: no light is given: --light 135,40
        --ambient 1 => 0: !no light
        // 120 degrees up are 60 degrees down to the other side.
        --light 10,120 => 0: it shines from 190,60
        --lit-sphere fixtures/room.hdr => 1: --environment
        --light 0,45 --scaling 5 => 0: warning: --scaling 5 is past
    ";
    desk.check("relight fixtures/bust.exr -o a.png {}", rows);
}

/// What shadows were chosen is said, and what they cannot do.
#[test]
fn shadows_are_told() {
    let desk = Desk::new();
    let photo = "fixtures/tablet.color.jpg --normal fixtures/tablet.normal.png";
    let rows = "
        --light 75,20 => 0: : shadows on
        --light 75,60 => 0: : shadows off
        --light 75,20 --raking best => 0: : shadows off
        --environment fixtures/room.hdr => 0: : sky-shadows on
        --environment fixtures/room.hdr --shadows on => 2: --sky-shadows on is for environments
        --environment fixtures/room.hdr --material mirror --sky-shadows on => 2: a --material that scatters light
    ";
    desk.check(
        &format!("relight {photo} --method plain -o a.png {{}}"),
        rows,
    );
    let rows = "
        --environment fixtures/room.hdr => 0: : sky-shadows off
        --environment fixtures/room.hdr --occlusion computed => 0: --sky-shadows on takes what stands before a background for solid
        --light 150,25 --shadows on --thickness 0 => 2: --thickness
    ";
    desk.check("relight fixtures/bust.exr --method plain -o a.png {}", rows);
    for preset in ["raking", "inscription-raking"] {
        desk.make(format!("run {preset} {photo} -o b.png"));
    }
}
