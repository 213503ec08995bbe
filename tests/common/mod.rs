//! Shared by the tests: inputs, runs of the program, and rotated and mirrored frames.

#![allow(dead_code, reason = "each test binary uses its own part")]
#![allow(unreachable_pub, reason = "each test binary is its own crate")]

pub mod cpu;
pub mod exr;
pub mod planes;
pub mod program;
pub mod real_files;
pub mod relit;

use exr::{Part, Stored};
use glam::{DAffine3, DMat3, DVec2, DVec3, Vec3};
use relievo::engine::Drawing;
use relievo::frame::{
    Camera, ColorPlanes, Frame, Mask, NormalSpace, Plane, Projection, Vector2Planes, Vector3Planes,
    Window,
};
use relievo::io::inputs::Inputs;
use relievo::io::{self, Loaded};

/// Layers with view-space normals and a picture, written to a file with samples stored so, and loaded.
pub fn through_a_file(layers: &[(&str, &Plane)], stored: Stored) -> Loaded {
    let mut part = Part::of(layers.iter().copied());
    for channel in &mut part.channels {
        channel.1 = stored;
    }
    let desk = tempfile::tempdir().unwrap();
    let picture = desk.path().join("render.exr");
    part.write(&picture);
    let inputs = Inputs {
        picture,
        normal_space: Some(NormalSpace::View),
        ..Inputs::default()
    };
    let needs = io::Needs {
        color: true,
        projection: true,
        ..io::Needs::default()
    };
    io::load(&inputs, needs).unwrap()
}

/// The frame as seen in a mirror to its left: columns reversed, x of vectors negated.
///
/// The camera's world is mirrored with it, so that its rotation stays proper.
pub fn mirrored(frame: &Frame) -> Frame {
    let shown = frame.display_window;
    let flip = |x: i32| shown.x0 + shown.x1 - x;
    let data = frame.data_window;
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let sides = f64::from(shown.x0 + shown.x1);
    let turn = Rearranged {
        width: data.width(),
        height: data.height(),
        from: move |x, y| (data.width() - 1 - x, y),
        vector: |v: DVec3| DVec3::new(-v.x, v.y, v.z),
    };
    turn.frame(
        frame,
        Window {
            x0: flip(data.x1),
            x1: flip(data.x0),
            ..data
        },
        shown,
        frame.pixel_aspect,
        |camera| Camera {
            view_from_world: mirror * camera.view_from_world * mirror,
            projection: match camera.projection {
                Projection::Perspective { fx, fy, cx, cy } => Projection::Perspective {
                    fx,
                    fy,
                    cx: sides - cx,
                    cy,
                },
                Projection::Orthographic { sx, sy, cx, cy } => Projection::Orthographic {
                    sx,
                    sy,
                    cx: sides - cx,
                    cy,
                },
            },
        },
    )
}

/// The frame rotated a quarter turn counterclockwise: the right side becomes the top.
///
/// The world stays as it is; the camera is rolled.
pub fn quarter_turned(frame: &Frame) -> Frame {
    let shown = frame.display_window;
    let data = frame.data_window;
    // A position (x, y), rows running down, moves to (y, x0 + x1 - x).
    let turned_window = |w: Window| Window {
        x0: w.y0,
        x1: w.y1,
        y0: shown.x0 + shown.x1 - w.x1,
        y1: shown.x0 + shown.x1 - w.x0,
    };
    let roll = DAffine3::from_mat3(DMat3::from_cols(DVec3::Y, DVec3::NEG_X, DVec3::Z));
    let sides = f64::from(shown.x0 + shown.x1);
    let turn = Rearranged {
        width: data.height(),
        height: data.width(),
        from: move |x, y| (data.width() - 1 - y, x),
        vector: |v: DVec3| DVec3::new(-v.y, v.x, v.z),
    };
    turn.frame(
        frame,
        turned_window(data),
        turned_window(shown),
        1.0 / frame.pixel_aspect,
        |camera| Camera {
            view_from_world: roll * camera.view_from_world,
            projection: match camera.projection {
                Projection::Perspective { fx, fy, cx, cy } => Projection::Perspective {
                    fx: fy,
                    fy: fx,
                    cx: cy,
                    cy: sides - cx,
                },
                Projection::Orthographic { sx, sy, cx, cy } => Projection::Orthographic {
                    sx: sy,
                    sy: sx,
                    cx: cy,
                    cy: sides - cx,
                },
            },
        },
    )
}

/// The frame with every sample outside the mask, of every plane but the picture's own, replaced by
/// `poison`: nothing computed may change.
pub fn poisoned(frame: &Frame, poison: f32) -> Frame {
    let spoil = |p: &Plane| {
        Plane::from_fn(p.width(), p.height(), |x, y| {
            if frame.mask.at(x, y) {
                p.at(x, y)
            } else {
                poison
            }
        })
    };
    Frame {
        normal: Vector3Planes {
            x: spoil(&frame.normal.x),
            y: spoil(&frame.normal.y),
            z: spoil(&frame.normal.z),
        },
        normal_length: frame.normal_length.as_ref().map(spoil),
        confidence: frame.confidence.clone(),
        depth: frame.depth.as_ref().map(spoil),
        ..frame.clone()
    }
}

/// The frame with its normals passed through `round`, and normalised as loading does.
pub fn rounded(mut frame: Frame, rounding: f32, round: impl Fn(f32) -> f32) -> Frame {
    let n = &mut frame.normal;
    let xy = n.x.samples_mut().iter_mut().zip(n.y.samples_mut());
    for ((x, y), z) in xy.zip(n.z.samples_mut()) {
        let v = Vec3::new(round(*x), round(*y), round(*z)).normalize_or_zero();
        (*x, *y, *z) = v.into();
    }
    frame.source.normal_rounding = rounding;
    frame
}

/// The frame with its normals as 8 bits over -1..1 store them.
pub fn in_8_bits(frame: Frame) -> Frame {
    rounded(frame, 1.0 / 255.0, |v| {
        ((v * 0.5 + 0.5) * 255.0).round() / 255.0 * 2.0 - 1.0
    })
}

pub fn without_depth(frame: Frame) -> Frame {
    Frame {
        depth: None,
        ..frame
    }
}

/// The direction at a pixel.
pub fn direction_at(found: &Vector2Planes, x: usize, y: usize) -> DVec2 {
    DVec2::new(found.x.at(x, y).into(), found.y.at(x, y).into())
}

/// The quantile of the sorted values for this share.
pub fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// Whether every sample of all layers is a share.
pub fn is_a_drawing(drawn: &Drawing) -> bool {
    let layers = std::iter::once(&drawn.hatching).chain(&drawn.contours);
    layers
        .flat_map(|plane| plane.samples())
        .all(|v| (0.0..=1.0).contains(v))
}

/// The bits of all samples.
pub fn bits(plane: &Plane) -> Vec<u32> {
    plane.samples().iter().map(|s| s.to_bits()).collect()
}

/// A plane rotated like a frame by `quarter_turned`.
pub fn quarter_turned_plane<T: Copy>(plane: &Plane<T>) -> Plane<T> {
    Plane::from_fn(plane.height(), plane.width(), |x, y| {
        plane.at(plane.width() - 1 - y, x)
    })
}

/// A plane mirrored like a frame by `mirrored`.
pub fn mirrored_plane<T: Copy>(plane: &Plane<T>) -> Plane<T> {
    Plane::from_fn(plane.width(), plane.height(), |x, y| {
        plane.at(plane.width() - 1 - x, y)
    })
}

/// Rearrangement of samples and vectors: the sample at (x, y) comes from `from(x, y)`.
struct Rearranged<P, V> {
    width: usize,
    height: usize,
    from: P,
    vector: V,
}

impl<P: Fn(usize, usize) -> (usize, usize), V: Fn(DVec3) -> DVec3> Rearranged<P, V> {
    fn plane<T: Copy>(&self, plane: &Plane<T>) -> Plane<T> {
        Plane::from_fn(self.width, self.height, |x, y| {
            let (x, y) = (self.from)(x, y);
            plane.at(x, y)
        })
    }

    fn vectors(&self, planes: &Vector3Planes) -> Vector3Planes {
        let component = |pick: fn(DVec3) -> f64| {
            Plane::from_fn(self.width, self.height, |x, y| {
                let (x, y) = (self.from)(x, y);
                let at = |p: &Plane| f64::from(p.at(x, y));
                let turned = (self.vector)(DVec3::new(at(&planes.x), at(&planes.y), at(&planes.z)));
                pick(turned) as f32
            })
        };
        Vector3Planes {
            x: component(|v| v.x),
            y: component(|v| v.y),
            z: component(|v| v.z),
        }
    }

    fn frame(
        &self,
        frame: &Frame,
        data_window: Window,
        display_window: Window,
        pixel_aspect: f32,
        camera: impl Fn(Camera) -> Camera,
    ) -> Frame {
        let plane = |p: &Plane| self.plane(p);
        let colors = |c: &ColorPlanes| ColorPlanes {
            r: plane(&c.r),
            g: plane(&c.g),
            b: plane(&c.b),
        };
        Frame {
            data_window,
            display_window,
            pixel_aspect,
            mask: Mask::new(self.plane(frame.mask.plane())),
            normal: self.vectors(&frame.normal),
            normal_length: frame.normal_length.as_ref().map(plane),
            confidence: frame.confidence.as_ref().map(plane),
            depth: frame.depth.as_ref().map(plane),
            occlusion: frame.occlusion.as_ref().map(plane),
            importance: frame.importance.as_ref().map(plane),
            strength: frame.strength.as_ref().map(plane),
            // No test scene has objects, with directions of their own or without.
            objects: None,
            stroke_fallback: None,
            color: frame.color.as_ref().map(colors),
            albedo: frame.albedo.as_ref().map(colors),
            alpha: frame.alpha.as_ref().map(plane),
            light: frame.light.map(plane),
            camera: frame.camera.map(camera),
            wraps: frame.wraps,
            source: frame.source.clone(),
        }
    }
}
