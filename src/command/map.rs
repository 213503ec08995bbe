//! `relievo map`: its arguments, its plan, and the maps it makes.

use super::args::WorkArgs;
use super::axes::Axes;
use super::flags::{Section, one_of};
use super::output::Kind;
use crate::engine::outcome::Outcome;
use crate::error::{Error, Result};
use crate::frame::bend::Bend;
use crate::frame::detail::with_detail;
use crate::frame::{ColorPlanes, Frame, Mask, Plane, Vector3Planes};
use crate::io::inputs::Inputs;
use crate::io::{self, Loaded, Needs};
use crate::params::{Adaptive, Group, Params, Scale, ShapeParams, SoftThreshold};
use crate::plan::{Available, Plan};
use crate::product::Product;
use clap::Args;
use std::borrow::Cow;
use std::path::PathBuf;

/// The arguments of `map`.
#[derive(Debug, Args)]
#[command(mut_arg("wrap", |wrap| wrap.default_value("auto")), mut_arg("crease", |crease| crease.default_value("15,45")))]
pub(crate) struct MapArgs {
    #[command(flatten)]
    pub(crate) work: WorkArgs,
    #[command(flatten)]
    _relief: Section<{ Group::Relief as u8 }>,
    /// Maps to make. Several take {map} in the name of the output, as in -o brick_{map}.png, or an .exr for all.
    #[arg(
        long = "map",
        value_name = "MAP,..",
        value_delimiter = ',',
        default_value = "curvature",
        value_parser = one_of(Map::ALL.map(|map| (map, map.name()))),
        help_heading = "Maps"
    )]
    maps: Vec<Map>,
    /// Bits of a sample: 8 or 16 in PNG and TIFF, 16 by default in PNG; 32 in TIFF, by default: the numbers themselves, as
    /// in .npy.
    #[arg(long, value_name = "8|16|32", value_parser = ["8", "16", "32"], help_heading = "Maps")]
    bits: Option<String>,
    /// Axes of the normals that are written: opengl is x right, y up, z toward the viewer; directx has y down, opencv y down
    /// and z away, stablenormal x to the left; world takes a camera, and xy leaves z out.
    #[arg(
        hide_short_help = true,
        long = "as",
        value_name = "AXES",
        default_value = "opengl",
        value_parser = one_of(Axes::ALL),
        help_heading = "Maps"
    )]
    axes: Axes,
    /// Normal map of a detail that is laid over the normals, turned with them: of one size with IN, and read as IN is.
    #[arg(
        hide_short_help = true,
        long,
        value_name = "FILE",
        help_heading = "Maps"
    )]
    pub(crate) detail: Option<PathBuf>,
    /// Subtract the bend of the whole surface from the normals, as of a tablet that lies askew or is curved: the quadratic
    /// surface that most slopes below 30 degrees agree on.
    #[arg(hide_short_help = true, long, help_heading = "Maps")]
    flatten: bool,
    /// Adds the curvatures of all scales up to one map, by these weights: one for each, or one for all.
    #[arg(
        hide_short_help = true,
        long,
        value_name = "WEIGHT,..",
        value_delimiter = ',',
        allow_hyphen_values = true,
        help_heading = "Maps"
    )]
    sum: Vec<f32>,
}

/// A map.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Map {
    /// Mapped curvature: 0.5 is flat, brighter convex, darker concave.
    Curvature,
    /// Its convex part: 0 is flat, 1 sharply convex.
    Convex,
    /// Its concave part: 0 is flat, 1 sharply concave.
    Concave,
    /// Edges: 1 where the surface bends, either way, by the larger angle of --crease or more, or depth jumps.
    Edges,
    /// Height: 0 is the lowest, 1 the highest, which are said; as numbers in pixels, or as depth.
    Height,
    /// The share of the sky that is seen over the height: 1 is open, 0 hidden; see --occlusion-radius.
    Occlusion,
    /// Where the height cannot follow the normals, since no surface has them: the change per pixel that is missed.
    Residual,
    /// The normals that all commands use; see --as.
    Normals,
}

/// One map that is made.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    /// Its name in files and channels.
    pub(crate) name: String,
    map: Map,
    /// Index of the scale or radius it shows; `None` for a map of neither, or of the sum of all scales.
    scale: Option<usize>,
}

/// A run of the engine, and what maps take of it.
pub(crate) struct Pass {
    pub(crate) plan: Plan,
    kind: PassKind,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PassKind {
    /// Curvature at one scale.
    Scale,
    /// Silhouettes and creases.
    Edges,
    /// Height.
    Relief,
}

/// The planes that maps are made of.
#[derive(Debug, Default)]
pub(crate) struct Samples {
    /// Mapped curvature, by scale.
    kappa: Vec<Plane>,
    /// The larger of the weights of silhouettes and creases.
    edges: Option<Plane>,
    height: Option<Plane>,
    residual: Option<Plane>,
    /// The sky seen, by radius.
    sky: Vec<Plane>,
}

/// A map as it is computed, and the values shown in black and white.
pub(crate) struct Made {
    /// One, or the components of normals.
    planes: Vec<Plane>,
    range: [f32; 2],
}

impl Made {
    /// Its planes by their names: its own, or those of the components of normals.
    pub(crate) fn named(self, name: &str) -> Vec<(String, Plane)> {
        let is_one = self.planes.len() == 1;
        let components = self.planes.into_iter().zip(["x", "y", "z"]);
        let name = |axis: &str| match is_one {
            true => name.to_string(),
            false => format!("normal.{axis}"),
        };
        components
            .map(|(plane, axis)| (name(axis), plane))
            .collect()
    }

    /// What its grey does not tell: the values shown in black and white, of a picture, and how much is missed.
    pub(crate) fn in_words(&self, part: &Part, mask: &Mask, is_picture: bool) -> Option<String> {
        let [black, white] = self.range;
        match part.map {
            Map::Height if is_picture => {
                Some(format!("height {black:.3} is black, {white:.3} white"))
            }
            Map::Residual => {
                let runs = |y: usize| {
                    mask.runs(y)
                        .flat_map(move |run| &self.planes[0].row(y)[run])
                };
                let squares = (0..mask.height()).flat_map(runs).map(|&v| f64::from(v * v));
                let mean = squares.sum::<f64>() / mask.count().max(1) as f64;
                let missed = mean.sqrt();
                Some(format!(
                    "the height misses {missed:.4} per pixel, root mean square"
                ))
            }
            _ => None,
        }
    }

    /// In grey, or normals in colours, 0..1; what is no surface is flat or black.
    pub(crate) fn picture(self, mask: &Mask) -> ColorPlanes {
        let [black, white] = self.range;
        let scale = 1.0 / (white - black);
        let middle = if black < 0.0 && white == -black {
            0.5
        } else {
            0.0
        };
        let facing = [middle, middle, 1.0];
        let outside = if self.planes.len() == 1 {
            [middle; 3]
        } else {
            facing
        };
        let shown = |(mut plane, outside): (Plane, f32)| {
            plane.each_row(|y, row| {
                for (v, &covered) in row.iter_mut().zip(mask.row(y)) {
                    let grey = ((*v - black) * scale).clamp(0.0, 1.0);
                    *v = if covered { grey } else { outside };
                }
            });
            plane
        };
        let mut planes = self.planes.into_iter().zip(outside).map(shown);
        let blank = || Plane::filled(mask.width(), mask.height(), 0.0);
        let r = planes.next().unwrap_or_else(blank);
        match planes.next() {
            None => ColorPlanes {
                r,
                ..ColorPlanes::default()
            },
            Some(g) => ColorPlanes {
                r,
                g,
                b: planes.next().unwrap_or_else(blank),
            },
        }
    }

    /// Whether its picture is grey.
    pub(crate) fn is_grey(&self) -> bool {
        self.planes.len() == 1
    }
}

impl Map {
    const ALL: [Self; 8] = [
        Self::Curvature,
        Self::Convex,
        Self::Concave,
        Self::Edges,
        Self::Height,
        Self::Occlusion,
        Self::Residual,
        Self::Normals,
    ];

    fn name(self) -> &'static str {
        match self {
            Self::Curvature => "curvature",
            Self::Convex => "convex",
            Self::Concave => "concave",
            Self::Edges => "edges",
            Self::Height => "height",
            Self::Residual => "residual",
            Self::Occlusion => "occlusion",
            Self::Normals => "normals",
        }
    }

    /// Whether it is made once for each scale.
    fn has_scales(self) -> bool {
        matches!(self, Self::Curvature | Self::Convex | Self::Concave)
    }
}

/// Curvature of a texture goes on across its sharpest edges, which are what it is made for.
const NO_CREASES: SoftThreshold = SoftThreshold {
    lo: 180.0,
    hi: 180.0,
};

impl MapArgs {
    /// Whether this plane of a map is a component of normals.
    pub(crate) fn is_of_normals(&self, plane: &str) -> bool {
        self.maps.contains(&Map::Normals) && plane.starts_with("normal.")
    }

    /// Bits of a sample of a picture.
    pub(crate) fn bits(&self) -> u8 {
        match self.bits.as_deref() {
            Some("8") => 8,
            _ => 16,
        }
    }

    /// Whether a TIFF holds the numbers of maps, rather than codes.
    pub(crate) fn keeps_numbers(&self) -> bool {
        matches!(self.bits.as_deref(), None | Some("32"))
    }

    /// All scales in pixels, the first one included.
    fn sigmas(&self) -> Vec<f32> {
        let flags = &self.work.flags;
        let first = match flags.params.shape.scale {
            Scale::Sigma(sigma) => sigma,
            _ => flags.params.shape.scale_px() as f32,
        };
        let more = flags.more_scales().iter().copied();
        std::iter::once(first).chain(more).collect()
    }

    /// The maps, each at each scale unless scales are added up.
    pub(crate) fn parts(&self) -> Vec<Part> {
        let (sigmas, radii) = (self.sigmas(), self.work.flags.radii());
        let mut parts: Vec<Part> = Vec::new();
        for &map in &self.maps {
            let sizes = match map {
                Map::Occlusion => radii,
                _ if map.has_scales() && self.sum.is_empty() => &sigmas,
                _ => &[],
            };
            let one = |scale: Option<usize>, name: String| Part { name, map, scale };
            match sizes.len() > 1 {
                true => parts.extend(
                    sizes
                        .iter()
                        .enumerate()
                        .map(|(scale, size)| one(Some(scale), format!("{}_{size}", map.name()))),
                ),
                false => parts.push(one(None, map.name().into())),
            }
        }
        let mut known = Vec::new();
        parts.retain(|part| {
            let is_new = !known.contains(&part.name);
            known.push(part.name.clone());
            is_new
        });
        parts
    }

    /// Refuses several maps for one file, bits that it does not have, and weights that do not match the scales.
    pub(crate) fn check(&self) -> Result<()> {
        let bad = |name, found: String, remedy: &str| {
            Err(Error::BadParameter {
                name,
                found,
                remedy: remedy.into(),
            })
        };
        let (parts, sigmas) = (self.parts(), self.sigmas());
        let kind = self.work.output.kind()?;
        let output = &self.work.output;
        let named = output.output.is_none() || output.is_per_map();
        if parts.len() > 1 && !named && kind != Kind::Exr {
            let found = format!("is one file for {} maps", parts.len());
            return bad("-o", found, "put {map} into its name, or write an .exr");
        }
        match (kind, self.bits.as_deref()) {
            (Kind::Picture(_), Some("32")) => {
                let found = "is 32, which a picture does not hold".to_string();
                return bad("--bits", found, "write a .tif, .npy or .exr");
            }
            (Kind::Numbers(_), Some(bits @ ("8" | "16"))) => {
                let found = format!("is {bits}, and numbers are written as floats");
                return bad("--bits", found, "leave it out, or write a .png or .tif");
            }
            _ => {}
        }
        let changes = [
            ("--detail", self.detail.is_some()),
            ("--flatten", self.flatten),
        ];
        let changes = changes.into_iter().find(|(_, is_given)| *is_given);
        if let Some((name, _)) = changes
            && !self.maps.contains(&Map::Normals)
        {
            let found = "is of normals, and they are not made".to_string();
            return bad(name, found, "add --map normals");
        }
        if let (Some(_), Some([name, found, remedy])) =
            (self.work.sequence.grid, self.of_one_picture(kind))
        {
            return bad(name, found.into(), remedy);
        }
        if !self.sum.is_empty() {
            if ![1, sigmas.len()].contains(&self.sum.len()) {
                let (weights, scales) = (self.sum.len(), sigmas.len());
                let found = format!("has {weights} weights for {scales} scales");
                return bad("--sum", found, "give one for each scale, or one for all");
            }
            let total: f32 = self.sum.iter().map(|weight| weight.abs()).sum();
            if !(total > 0.0 && total.is_finite()) {
                let found = "has weights that add up to nothing".to_string();
                return bad("--sum", found, "give finite numbers, not all of them 0");
            }
        }
        Ok(())
    }

    /// A setting that is of a whole picture, and would differ from cell to cell of a sheet: its name, why, and what to do.
    fn of_one_picture(&self, kind: Kind) -> Option<[&'static str; 3]> {
        let whole = "is of a whole picture, and --grid cuts it";
        let gain = self.work.flags.params.scaling.curvature_gain;
        let has_scales = self.maps.iter().any(|map| map.has_scales());
        if self.detail.is_some() {
            Some(["--detail", whole, "leave one of them out"])
        } else if self.flatten {
            Some(["--flatten", whole, "leave one of them out"])
        } else if has_scales && self.sigmas().len() > 1 && gain == Adaptive::Auto {
            let found = "takes a gain for each scale, of a whole picture, and --grid cuts it";
            Some(["--scale", found, "give one, or --curvature-gain"])
        } else if matches!(kind, Kind::Picture(_)) && self.maps.contains(&Map::Height) {
            let found = "height runs from black to white in each picture, and --grid makes many";
            Some(["--map", found, "write an .npy, .tif or .exr"])
        } else {
            None
        }
    }

    /// Inputs and layers to read for a frame.
    pub(crate) fn reading(&self, frame: Option<i32>) -> (Inputs, Needs) {
        let needs = Needs {
            projection: true,
            ..Needs::default()
        };
        (self.work.inputs(frame), needs)
    }

    /// The detail that is laid over the normals of a frame, read as they are.
    ///
    /// # Errors
    /// As [`io::load`]; [`Error::SizeMismatch`] where it is of another size.
    pub(crate) fn detail(&self, inputs: &Inputs, frame: &Frame) -> Result<Option<Loaded>> {
        let Some(path) = &self.detail else {
            return Ok(None);
        };
        let own = Inputs {
            picture: path.clone(),
            normal_space: inputs.normal_space,
            normal_encoding: inputs.normal_encoding,
            normal_flip: inputs.normal_flip,
            wrap: inputs.wrap,
            ..Inputs::default()
        };
        let detail = io::load(&own, Needs::default())?;
        let [size, expected] = [&detail.frame, frame].map(|f| (f.mask.width(), f.mask.height()));
        match size == expected {
            true => Ok(Some(detail)),
            false => Err(Error::SizeMismatch {
                path: path.clone(),
                found: format!("{}x{}", size.0, size.1),
                expected: format!("the normals are {}x{}", expected.0, expected.1),
            }),
        }
    }

    /// The normals of a frame with what was asked for, and what was subtracted from them, in words.
    ///
    /// # Errors
    /// [`Error::BadParameter`] where there is no bend to be found.
    pub(crate) fn normals<'f>(
        &self,
        frame: &'f Frame,
        detail: Option<&Frame>,
    ) -> Result<(Cow<'f, Vector3Planes>, Option<String>)> {
        let (mut normal, mut said) = (Cow::Borrowed(&frame.normal), None);
        if self.flatten {
            let bend = Bend::of(&normal, &frame.mask).ok_or_else(|| Error::BadParameter {
                name: "--flatten",
                found: "finds too few pixels that lean less than 30 degrees".into(),
                remedy: "leave it out".into(),
            })?;
            normal = Cow::Owned(bend.subtract(&normal));
            said = Some(bend.in_words());
        }
        if let Some(detail) = detail {
            normal = Cow::Owned(with_detail(&normal, &detail.normal, &detail.mask));
        }
        Ok((normal, said))
    }

    /// The runs that all maps of a frame take: one for each scale, since each has a gain of its own.
    pub(crate) fn passes(&self, frame: &Frame) -> Result<Vec<Pass>> {
        let Params { shape, scaling, .. } = self.work.flags.params;
        let available = Available::in_frame(frame);
        let pass = |kind, products: &[Product], shape| {
            let plan = Plan::of_products(products, available, shape, scaling, &[])?;
            Ok(Pass { plan, kind })
        };
        let mut passes = Vec::new();
        if self.maps.iter().any(|map| map.has_scales()) {
            let more = self.work.flags.more_scales().iter();
            let scales = std::iter::once(shape.scale).chain(more.map(|&px| Scale::Sigma(px)));
            for scale in scales {
                let shape = ShapeParams {
                    scale,
                    crease: NO_CREASES,
                    ..shape
                };
                passes.push(pass(PassKind::Scale, &[Product::MappedCurvature], shape)?);
            }
        }
        if self.maps.contains(&Map::Edges) {
            let products = [Product::Silhouette, Product::Crease, Product::Conductance];
            passes.push(pass(PassKind::Edges, &products, shape)?);
        }
        let relief = [
            (Map::Height, Product::Height),
            (Map::Residual, Product::HeightResidual),
            (Map::Occlusion, Product::Sky),
        ];
        let relief = relief.iter().filter(|(map, _)| self.maps.contains(map));
        let products: Vec<_> = relief.map(|(_, product)| *product).collect();
        let radii = match self.maps.contains(&Map::Occlusion) {
            true => self.work.flags.radii(),
            false => &[shape.occlusion_radius],
        };
        for &occlusion_radius in radii.iter().filter(|_| !products.is_empty()) {
            let shape = ShapeParams {
                crease: NO_CREASES,
                occlusion_radius,
                ..shape
            };
            shape.validate()?;
            passes.push(pass(PassKind::Relief, &products, shape)?);
        }
        Ok(passes)
    }

    /// One of the maps of a frame, whose normals are these.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for normals in world space without a camera.
    pub(crate) fn made(
        &self,
        part: &Part,
        samples: &Samples,
        frame: &Frame,
        normal: &Vector3Planes,
    ) -> Result<Made> {
        let one = |plane: Plane, range: [f32; 2]| Made {
            planes: vec![plane],
            range,
        };
        Ok(match part.map {
            Map::Curvature => one(self.kappa(part, samples), [-1.0, 1.0]),
            Map::Convex => {
                let kappa = self.kappa(part, samples);
                one(kappa.map(|kappa| kappa.max(0.0)), [0.0, 1.0])
            }
            Map::Concave => {
                let kappa = self.kappa(part, samples);
                one(kappa.map(|kappa| (-kappa).max(0.0)), [0.0, 1.0])
            }
            Map::Edges => {
                let edges = samples.edges.clone();
                one(edges.expect("a pass makes edges"), [0.0, 1.0])
            }
            Map::Height => {
                let height = samples.height.clone().expect("a pass makes the height");
                let range = range_of(&height, &frame.mask);
                one(height, range)
            }
            Map::Occlusion => one(samples.sky[part.scale.unwrap_or(0)].clone(), [0.0, 1.0]),
            Map::Residual => {
                let residual = samples.residual.clone();
                one(residual.expect("a pass makes the residual"), [0.0, 1.0])
            }
            Map::Normals => Made {
                planes: self.axes.of_view(frame, normal)?,
                range: [-1.0, 1.0],
            },
        })
    }

    /// Mapped curvature at one scale, or the weighted mean over all.
    fn kappa(&self, part: &Part, samples: &Samples) -> Plane {
        let all = &samples.kappa;
        if self.sum.is_empty() {
            return all[part.scale.unwrap_or(0)].clone();
        }
        let weights: Vec<f32> = match self.sum[..] {
            [one] => vec![one; all.len()],
            _ => self.sum.clone(),
        };
        let total: f32 = weights.iter().map(|weight| weight.abs()).sum();
        let mut sum = Plane::filled(all[0].width(), all[0].height(), 0.0);
        sum.each_row(|y, row| {
            for (plane, weight) in all.iter().zip(&weights) {
                let samples = row.iter_mut().zip(plane.row(y));
                samples.for_each(|(sum, kappa)| *sum += weight / total * kappa);
            }
        });
        sum
    }
}

impl Samples {
    /// Takes what maps are made of from the outcome of a pass.
    pub(crate) fn take(&mut self, pass: &Pass, outcome: &mut Outcome) {
        let shape = &mut outcome.shape;
        match pass.kind {
            PassKind::Scale => self.kappa.extend(shape.kappa.take()),
            PassKind::Relief => {
                self.height = shape.height.take();
                self.residual = shape.height_residual.take();
                self.sky.extend(shape.sky.take());
            }
            PassKind::Edges => self.edges = larger(shape.crease.take(), shape.silhouette.take()),
        }
    }
}

/// The lowest and the highest value of a surface; 1 apart where they are equal or none.
fn range_of(plane: &Plane, mask: &Mask) -> [f32; 2] {
    let runs = |y: usize| mask.runs(y).flat_map(move |run| &plane.row(y)[run]);
    let samples = (0..mask.height()).flat_map(runs);
    let (low, high) = samples.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), &v| {
        (low.min(v), high.max(v))
    });
    match (low < high, low.is_finite()) {
        (true, _) => [low, high],
        (false, true) => [low, low + 1.0],
        (false, false) => [0.0, 1.0],
    }
}

/// The larger of two planes, pixel by pixel, or the one that there is.
fn larger(one: Option<Plane>, other: Option<Plane>) -> Option<Plane> {
    let (mut one, other) = match (one, other) {
        (Some(one), Some(other)) => (one, other),
        (one, other) => return one.or(other),
    };
    one.each_row(|y, row| {
        let samples = row.iter_mut().zip(other.row(y));
        samples.for_each(|(one, other)| *one = one.max(*other));
    });
    Some(one)
}
