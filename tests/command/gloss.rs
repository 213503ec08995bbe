//! `relievo relight` of metals, glass and lamps, under the names that renderers give their layers.

use crate::common::exr::Part;
use crate::common::program::Desk;
use relievo::frame::Plane;

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

#[rustfmt::skip]
const BLENDER: Writer = Writer {
    layers: ["DiffCol", "GlossCol", "GlossDir", "GlossInd", "TransCol", "TransDir", "Emit"],
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
    fn write(&self, desk: &Desk, [width, height]: [usize; 2], count: usize) {
        let plane = |of: &dyn Fn(usize) -> f32| {
            Plane::from_fn(width, height, |x, _| of(x / BAND % MATERIALS.len()))
        };
        let index = ("IndexOB.X".to_string(), plane(&|m| m as f32 + 1.0));
        let normal = [("X", 0.75_f32.sqrt()), ("Y", 0.0), ("Z", 0.5)];
        let normal = normal.map(|(axis, value)| (format!("normal.{axis}"), plane(&|_| value)));
        let mut channels: Vec<(String, Plane)> = normal.into_iter().chain([index]).collect();
        for (k, letter) in ["R", "G", "B"].into_iter().enumerate() {
            channels.push((format!("Combined.{letter}"), plane(&|m| picture(m)[k])));
            for (layer, name) in self.layers.iter().enumerate().take(count) {
                let of_layer = plane(&|m| self.layer(layer, m)[k]);
                channels.push((format!("{name}.{letter}"), of_layer));
            }
        }
        let channels = channels.iter().map(|(name, plane)| (name, plane));
        Part::of(channels).write(&desk.at("in.exr"));
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

const RELIGHT: &str =
    "relight in.exr -o lit.exr --ambient 0 --method plain --normal-space view --layers results";

/// The colours of a row lit by one lamp, mirrored toward the viewer, and what is said.
fn relit(desk: &Desk, flags: &str) -> (Vec<[f32; 3]>, String) {
    let ran = desk.make(format!("{RELIGHT} --light 0,-30 {flags}"));
    (colors(desk), ran.stderr)
}

fn colors(desk: &Desk) -> Vec<[f32; 3]> {
    let planes = ["R", "G", "B"].map(|name| desk.channel("lit.exr", name));
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
    let desk = Desk::new();
    for writer in &WRITERS {
        writer.write(&desk, SIZE, 7);
        let (lit, said) = relit(&desk, "");
        let told =
            "80.0 % of the surface has no diffuse colour (object 2, object 3, object 4, object 5)";
        assert!(said.contains(told), "{said}");
        let near = |material: usize, expected: [f32; 3], tolerance: f32| {
            for (found, expected) in lit[material * BAND + 3].iter().zip(expected) {
                let is_near = (found - expected).abs() < tolerance * expected;
                let name = writer.layers[1];
                assert!(is_near, "{name}, {material}: {found}, not {expected}");
            }
        };
        // 0.9 is the factor of diffuse light.
        near(0, [0.5 * 0.5 * 0.9 + lobe(0.04) + 0.04 * 0.5; 3], 1e-3);
        near(1, GOLD.map(|own| lobe(own) + 0.5 * own), 3e-3);
        let through = |seen: f32| 0.96 * seen + 0.04 * 0.5 + lobe(0.04);
        near(2, [0.2, 0.3, 0.4].map(through), 3e-2);
        // Bit for bit.
        assert_eq!(lit[3 * BAND + 3], picture(3));
        assert_eq!(lit[4 * BAND + 3], UNTOLD);
    }
}

#[test]
fn materials_with_a_highlight_put_it_on_diffuse_surfaces_alone() {
    let desk = Desk::new();
    BLENDER.write(&desk, SIZE, 7);
    let (matt, _) = relit(&desk, "");
    for material in ["phong", "blinn-phong", "ashikhmin-shirley"] {
        let (lit, _) = relit(&desk, &format!("--material {material}"));
        assert_eq!(lit[BAND..], matt[BAND..], "{material}");
        assert_ne!(lit[0], matt[0], "{material}");
    }
}

#[test]
fn an_environment_takes_the_place_of_the_mirrored_scene() {
    let desk = Desk::new();
    BLENDER.write(&desk, SIZE, 7);
    let sky = image::Rgb32FImage::from_pixel(64, 32, image::Rgb([0.25; 3]));
    sky.save(desk.at("sky.hdr")).unwrap();
    desk.make(format!(
        "{RELIGHT} --environment sky.hdr --environment-gain 2"
    ));
    // Radiance 0.5 from everywhere, n.e = 1/2.
    for (found, own) in colors(&desk)[BAND + 3].into_iter().zip(GOLD) {
        let expected = 0.5 * (own * (1.0 - 1.0 / 32.0) + 1.0 / 32.0);
        assert!((found - expected).abs() < 5e-3, "{found}, not {expected}");
    }
}

#[test]
fn a_diffuse_colour_alone_is_lit_as_ever() {
    let desk = Desk::new();
    BLENDER.write(&desk, SIZE, 1);
    let (bare, said) = relit(&desk, "");
    assert!(
        said.contains("turns black: layers of glossy color"),
        "{said}"
    );
    for (x, color) in bare.iter().enumerate() {
        let expected = if x < BAND { 0.5 * 0.5 * 0.9 } else { 0.0 };
        assert!((color[1] - expected).abs() < 1e-6, "{x}");
    }
    // The former way of a file with all layers, and no word of it.
    BLENDER.write(&desk, SIZE, 7);
    let (all, said) = relit(&desk, "--albedo-from layer");
    assert!(!said.contains("diffuse colour"), "{said}");
    assert_eq!(all, bare);
}

#[test]
fn strips_decide_as_the_whole_does() {
    let desk = Desk::new();
    BLENDER.write(&desk, [160, 4000], 7);
    let [whole, strips] = ["8G", "62M"].map(|memory| {
        relit(&desk, &format!("--max-memory {memory}"));
        desk.bytes("lit.exr")
    });
    assert!(whole == strips);
}

#[test]
fn hostile_layers_and_a_single_pixel_give_finite_light() {
    let desk = Desk::new();
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, -1.0] {
        for hostile in 0..BLENDER.layers.len() {
            let [zero, half, one, usual, wild] =
                [0.0, 0.5, 1.0, 0.01, value].map(|value| Plane::filled(1, 1, value));
            let normal = [("normal.X", &zero), ("normal.Y", &zero), ("normal.Z", &one)];
            let mut channels = normal
                .map(|(name, plane)| (name.to_string(), plane))
                .to_vec();
            for letter in ["R", "G", "B"] {
                channels.push((format!("Combined.{letter}"), &half));
                for (layer, name) in BLENDER.layers.iter().enumerate() {
                    let plane = if layer == hostile { &wild } else { &usual };
                    channels.push((format!("{name}.{letter}"), plane));
                }
            }
            Part::of(channels).write(&desk.at("in.exr"));
            let (lit, _) = relit(&desk, "");
            let is_finite = lit.iter().flatten().all(|channel| channel.is_finite());
            assert!(is_finite && lit.len() == 1, "{hostile} of {value}: {lit:?}");
        }
    }
}
