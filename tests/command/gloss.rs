//! `relievo relight` of metals, glass and lamps, under the names that renderers give their layers.

use crate::common::exr::{Part, Stored, channel};
use crate::common::program::{Ran, relievo};
use relievo::frame::Plane;
use std::path::Path;

/// Columns of each material.
const BAND: usize = 8;

/// Plastic, gold, glass, a lamp, and what no colour tells of: what a renderer that writes reflectances has in its layers of
/// diffuse and glossy colour, mirrored lamps and scene (without colour), transmission (colour, then light), and emission.
#[rustfmt::skip]
const MATERIALS: [[[f32; 3]; 7]; 5] = [
    [[0.5; 3], [0.04; 3], [2.0; 3], [0.5; 3], [0.0; 3], [0.0; 3], [0.0; 3]],
    [[0.0; 3], GOLD, [2.0; 3], [0.5; 3], [0.0; 3], [0.0; 3], [0.0; 3]],
    [[0.0; 3], [0.04; 3], [0.0; 3], [0.5; 3], [0.96; 3], [0.2, 0.3, 0.4], [0.0; 3]],
    [[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [1.5, 1.2, 0.7]],
    [[0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3], [0.0; 3]],
];
const GOLD: [f32; 3] = [1.0, 0.6, 0.15];

/// Light of the last material, which no layer but the picture has.
const UNTOLD: [f32; 3] = [0.1, 0.2, 0.3];

/// How a renderer writes the layers of [`MATERIALS`].
struct Writer {
    layers: [&'static str; 7],
    /// Whether plastic and metals have a tint of 1 in place of their reflectance; and whether metals have a grey one.
    tints: [bool; 2],
    /// Whether light includes the colour.
    colored: bool,
}

const BLENDER: Writer = Writer {
    layers: [
        "DiffCol", "GlossCol", "GlossDir", "GlossInd", "TransCol", "TransDir", "Emit",
    ],
    tints: [true, true],
    colored: false,
};

#[rustfmt::skip]
const WRITERS: [Writer; 5] = [
    BLENDER,
    Writer {
        layers: [
            "Diffuse Color", "Glossy Color", "Glossy Direct", "Glossy Indirect", "Transmission Color", "Transmission Direct",
            "Emission",
        ],
        tints: [false, false],
        colored: false,
    },
    Writer {
        layers: [
            "diffuse_albedo", "specular_albedo", "specular_direct", "specular_indirect", "transmission_albedo",
            "transmission_direct", "emission",
        ],
        tints: [false, false],
        colored: true,
    },
    Writer {
        layers: [
            "diffuseFilter", "reflectionFilter", "specular", "reflection", "refractionFilter", "refraction",
            "selfIllumination",
        ],
        tints: [true, false],
        colored: true,
    },
    Writer {
        layers: [
            "DiffuseFilter", "ReflectionsFilter", "SpecularLighting", "Reflections", "RefractionsFilter", "Refractions",
            "Emission",
        ],
        tints: [true, false],
        colored: true,
    },
];

impl Writer {
    /// A layer of a material.
    fn layer(&self, layer: usize, material: usize) -> [f32; 3] {
        let of = |layer: usize| MATERIALS[material][layer];
        let is_mirror = material < 2;
        let grey = self.tints[1] || material == 0;
        [0, 1, 2].map(|k| match layer {
            1 if is_mirror && self.tints[0] && grey => 1.0,
            2 | 3 if self.colored => of(layer)[k] * of(1)[k],
            // Light over its colour.
            2 | 3 if is_mirror && self.tints[0] && grey => of(layer)[k] * of(1)[k],
            5 if self.colored => of(5)[k] * of(4)[k],
            _ => of(layer)[k],
        })
    }

    /// A file of all materials, with as many of the layers, of a surface at 60 degrees.
    fn write(&self, path: &Path, [width, height]: [usize; 2], count: usize) {
        let material = |x: usize| x / BAND % MATERIALS.len();
        let plane =
            |of: &dyn Fn(usize) -> f32| Plane::from_fn(width, height, |x, _| of(material(x)));
        let mut part = Part::new(relievo::frame::Window::from_size(width, height));
        for (name, value) in
            ["normal.X", "normal.Y", "normal.Z"]
                .into_iter()
                .zip([0.75_f32.sqrt(), 0.0, 0.5])
        {
            part = part.channel(name, Stored::Float, &plane(&|_| value));
        }
        part = part.channel(
            "IndexOB.X",
            Stored::Float,
            &plane(&|material| material as f32 + 1.0),
        );
        for (k, letter) in ["R", "G", "B"].into_iter().enumerate() {
            part = part.channel(
                &format!("Combined.{letter}"),
                Stored::Float,
                &plane(&|m| picture(m)[k]),
            );
            for (layer, name) in self.layers.iter().enumerate().take(count) {
                let name = format!("{name}.{letter}");
                part = part.channel(&name, Stored::Float, &plane(&|m| self.layer(layer, m)[k]));
            }
        }
        part.write(path);
    }
}

/// What the picture shows of a material.
fn picture(material: usize) -> [f32; 3] {
    let [diffuse, gloss, lamps, scene, through, light, emitted] = MATERIALS[material];
    [0, 1, 2].map(|k| match material {
        4 => UNTOLD[k],
        _ => {
            0.7 * diffuse[k] + gloss[k] * (lamps[k] + scene[k]) + through[k] * light[k] + emitted[k]
        }
    })
}

/// Lit by one lamp, mirrored toward the viewer.
fn relit(desk: &Path, file: &str, flags: &str) -> Ran {
    let words = format!(
        "relight {file}.exr -o {file}.lit.exr --light 0,-30 --ambient 0 --method plain --normal-space view \
         --layers results {flags}"
    );
    relievo(desk, &words).done()
}

fn colors(desk: &Path, file: &str) -> Vec<[f32; 3]> {
    let planes = ["R", "G", "B"].map(|name| channel(&desk.join(format!("{file}.lit.exr")), name));
    let at = |x: usize| planes.each_ref().map(|plane| plane.at(x, 0));
    (0..planes[0].width()).map(at).collect()
}

const SIZE: [usize; 2] = [5 * BAND, 6];

#[test]
fn metals_mirror_new_light_and_lamps_stay_under_every_renderers_names() {
    // Normal, light and viewer are 60 degrees apart, so h is the normal: n.l = n.e = h.e = 1/2. With a = 0.0144, D pi = 1/a
    // = 69.444; G / (4 n.l n.e) = 1 / (2 (2 n.l hidden)), hidden = sqrt(a + (1 - a)/4) = 0.51069; times n.l: 33.996. Schlick's
    // share of grazing is (1 - 1/2)^5 = 1/32.
    let lobe = |reflectance: f32| 33.996 * (reflectance * (1.0 - 1.0 / 32.0) + 1.0 / 32.0);
    let desk = tempfile::tempdir().unwrap();
    for writer in &WRITERS {
        writer.write(&desk.path().join("in.exr"), SIZE, 7);
        let ran = relit(desk.path(), "in", "");
        let said =
            "80.0 % of the surface has no diffuse colour (object 2, object 3, object 4, object 5)";
        assert!(ran.stderr.contains(said), "{}", ran.stderr);
        let lit = colors(desk.path(), "in");
        let near = |material: usize, expected: [f32; 3], tolerance: f32| {
            for k in 0..3 {
                let (found, expected) = (lit[material * BAND + 3][k], expected[k]);
                let error = (found - expected).abs() / expected;
                assert!(
                    error < tolerance,
                    "{}, {material}: {found}, not {expected}",
                    writer.layers[1]
                );
            }
        };
        // 0.9 is the factor of diffuse light.
        near(0, [0.5 * 0.5 * 0.9 + lobe(0.04) + 0.04 * 0.5; 3], 1e-3);
        near(1, GOLD.map(|own| lobe(own) + 0.5 * own), 3e-3);
        near(
            2,
            [0.2, 0.3, 0.4].map(|seen| 0.96 * seen + 0.04 * 0.5 + lobe(0.04)),
            3e-2,
        );
        // Bit for bit.
        assert_eq!(lit[3 * BAND + 3], picture(3));
        assert_eq!(lit[4 * BAND + 3], UNTOLD);
    }
}

#[test]
fn materials_with_a_highlight_put_it_on_diffuse_surfaces_alone() {
    let desk = tempfile::tempdir().unwrap();
    BLENDER.write(&desk.path().join("in.exr"), SIZE, 7);
    relit(desk.path(), "in", "");
    let matt = colors(desk.path(), "in");
    for material in ["phong", "blinn-phong", "ashikhmin-shirley"] {
        relit(desk.path(), "in", &format!("--material {material}"));
        let lit = colors(desk.path(), "in");
        assert_eq!(lit[BAND..], matt[BAND..], "{material}");
        assert_ne!(lit[0], matt[0], "{material}");
    }
}

#[test]
fn an_environment_takes_the_place_of_the_mirrored_scene() {
    let desk = tempfile::tempdir().unwrap();
    BLENDER.write(&desk.path().join("in.exr"), SIZE, 7);
    image::Rgb32FImage::from_pixel(64, 32, image::Rgb([0.25; 3]))
        .save(desk.path().join("sky.hdr"))
        .unwrap();
    let flags = "relight in.exr -o in.lit.exr --environment sky.hdr --environment-gain 2 --ambient 0 --method plain \
                 --normal-space view --layers results";
    relievo(desk.path(), flags).done();
    // Radiance 0.5 from everywhere, n.e = 1/2.
    for (found, own) in colors(desk.path(), "in")[BAND + 3].into_iter().zip(GOLD) {
        let expected = 0.5 * (own * (1.0 - 1.0 / 32.0) + 1.0 / 32.0);
        assert!((found - expected).abs() < 5e-3, "{found}, not {expected}");
    }
}

#[test]
fn a_diffuse_colour_alone_is_lit_as_ever() {
    let desk = tempfile::tempdir().unwrap();
    BLENDER.write(&desk.path().join("bare.exr"), SIZE, 1);
    BLENDER.write(&desk.path().join("all.exr"), SIZE, 7);
    let ran = relit(desk.path(), "bare", "");
    assert!(
        ran.stderr.contains("turns black: layers of glossy color"),
        "{}",
        ran.stderr
    );
    let bare = colors(desk.path(), "bare");
    for (file, x) in (0..SIZE[0]).map(|x| ("bare", x)) {
        let expected = if x < BAND { 0.5 * 0.5 * 0.9 } else { 0.0 };
        assert!((bare[x][1] - expected).abs() < 1e-6, "{file}");
    }
    // The former way of a file with all layers, and no word of it.
    let ran = relit(desk.path(), "all", "--albedo-from layer");
    assert!(!ran.stderr.contains("diffuse colour"), "{}", ran.stderr);
    assert_eq!(colors(desk.path(), "all"), bare);
}

#[test]
fn strips_decide_as_the_whole_does() {
    let desk = tempfile::tempdir().unwrap();
    BLENDER.write(&desk.path().join("in.exr"), [160, 4000], 7);
    let mut lit = Vec::new();
    for memory in ["8G", "62M"] {
        relit(desk.path(), "in", &format!("--max-memory {memory}"));
        lit.push(std::fs::read(desk.path().join("in.lit.exr")).unwrap());
    }
    assert!(lit[0] == lit[1]);
}

#[test]
fn hostile_layers_and_a_single_pixel_give_finite_light() {
    let desk = tempfile::tempdir().unwrap();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0] {
        for hostile in 0..BLENDER.layers.len() {
            let mut part = Part::new(relievo::frame::Window::from_size(1, 1));
            let one = |value| Plane::filled(1, 1, value);
            part = part.channel("normal.X", Stored::Float, &one(0.0));
            part = part.channel("normal.Y", Stored::Float, &one(0.0));
            part = part.channel("normal.Z", Stored::Float, &one(1.0));
            for letter in ["R", "G", "B"] {
                part = part.channel(&format!("Combined.{letter}"), Stored::Float, &one(0.5));
                for (layer, name) in BLENDER.layers.iter().enumerate() {
                    let value = if layer == hostile { value } else { 0.01 };
                    part = part.channel(&format!("{name}.{letter}"), Stored::Float, &one(value));
                }
            }
            part.write(&desk.path().join("in.exr"));
            relit(desk.path(), "in", "");
            let [pixel] = colors(desk.path(), "in")[..] else {
                panic!("one pixel")
            };
            assert!(
                pixel.iter().all(|channel| channel.is_finite()),
                "{hostile} of {value}: {pixel:?}"
            );
        }
    }
}
