//! `relievo map` and `relievo normals`: maps of a texture or a frame, made by several plans.

use super::{FrameSeen, FrameWork, Results};
use crate::command::args::WorkArgs;
use crate::command::flags::weights_for;
use crate::command::map::{MapArgs, MapKind, MapPart};
use crate::command::named::Named;
use crate::error::{Error, Result, bad};
use crate::frame::bend::Quadric;
use crate::frame::detail::with_detail;
use crate::frame::{ColorPlanes, Frame, Mask, Plane, Vector3Planes};
use crate::io::inputs::Inputs;
use crate::io::output::OutputKind;
use crate::io::output::picture::{Form, MadePicture};
use crate::io::picture::ViewTransform;
use crate::io::{self, Needs};
use crate::kernel::timings::add_timings;
use crate::light::lights::Illumination;
use crate::params::{Adaptive, Params, Scale, ShapeParams, SoftThreshold};
use crate::plan::outcome::Outcome;
use crate::plan::{Available, Goal, Plan};
use crate::product::Product;
use std::borrow::Cow;

/// The planes that maps are made of.
#[derive(Debug, Default)]
pub(crate) struct MapSamples {
    /// The normals, where they are not those of the frame.
    normal: Option<Vector3Planes>,
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
pub(crate) struct MadeMap {
    pub(crate) part: MapPart,
    /// One, or the components of normals.
    planes: Vec<Plane>,
    range: [f32; 2],
}

impl MadeMap {
    /// Its planes by their names: its own, or those of the components of normals.
    pub(crate) fn named(self) -> Vec<(String, Plane)> {
        let is_one = self.planes.len() == 1;
        let components = self.planes.into_iter().zip(["x", "y", "z"]);
        let name = |axis: &str| match is_one {
            true => self.part.name.clone(),
            false => format!("normal.{axis}"),
        };
        components
            .map(|(plane, axis)| (name(axis), plane))
            .collect()
    }

    /// What its grey does not tell: the values shown in black and white, of a picture, and how much is missed.
    pub(crate) fn in_words(&self, mask: &Mask, is_picture: bool) -> Option<String> {
        let [black, white] = self.range;
        match self.part.map {
            MapKind::Height if is_picture => {
                Some(format!("height {black:.3} is black, {white:.3} white"))
            }
            MapKind::Residual => {
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

    /// In grey, or normals in colours; what is no surface is flat or black.
    pub(crate) fn picture(self, args: &MapArgs, frame: &Frame) -> MadePicture<'static> {
        let form = Form::Shown {
            grey: self.planes.len() == 1,
            bits: args.bits(),
            dpi: args.work.flags.params.dpi(frame.pixel_aspect),
            transform: ViewTransform::None,
        };
        MadePicture::shown(Cow::Owned(self.colors(&frame.mask)), form)
    }

    /// Its values as 0..1.
    fn colors(self, mask: &Mask) -> ColorPlanes {
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
            plane.each_with(mask.plane(), |v, covered| {
                let grey = ((*v - black) * scale).clamp(0.0, 1.0);
                *v = if covered { grey } else { outside };
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
}

/// Curvature of a texture goes on across its sharpest edges, which are what it is made for.
const NO_CREASES: SoftThreshold = SoftThreshold {
    lo: 180.0,
    hi: 180.0,
};

impl FrameWork for MapArgs {
    fn args(&self) -> &WorkArgs {
        &self.work
    }

    fn args_mut(&mut self) -> &mut WorkArgs {
        &mut self.work
    }

    fn names(&mut self) -> Vec<Named<'_>> {
        let mut all = self.work.names();
        all.extend(self.detail.as_deref().map(Named::Shared));
        all
    }

    fn maps(&self) -> Option<&MapArgs> {
        Some(self)
    }

    /// Refuses several maps for one file, bits that it does not have, and weights that do not match the scales.
    fn check(&self) -> Result<()> {
        let (parts, sigmas) = (self.parts(), self.sigmas());
        let kind = self.work.output.kind()?;
        let output = &self.work.output;
        let named = output.output.is_none() || output.is_per_map();
        if parts.len() > 1 && !named && kind != OutputKind::Exr {
            let found = format!("is one file for {} maps", parts.len());
            return Err(bad(
                "-o",
                found,
                "put {map} into its name, or write an .exr",
            ));
        }
        match (kind, self.bits.as_deref()) {
            (OutputKind::Picture(_), Some("32")) => {
                let found = "is 32, which a picture does not hold".to_string();
                return Err(bad("--bits", found, "write a .tif, .npy or .exr"));
            }
            (OutputKind::Numbers(_), Some(bits @ ("8" | "16"))) => {
                let found = format!("is {bits}, and numbers are written as floats");
                return Err(bad(
                    "--bits",
                    found,
                    "leave it out, or write a .png or .tif",
                ));
            }
            _ => {}
        }
        let changes = [
            ("--detail", self.detail.is_some()),
            ("--flatten", self.flatten),
        ];
        let changes = changes.into_iter().find(|(_, is_given)| *is_given);
        if let Some((name, _)) = changes
            && !self.maps.contains(&MapKind::Normals)
        {
            let found = "is of normals, and they are not made".to_string();
            return Err(bad(name, found, "add --map normals"));
        }
        if let (Some(_), Some([name, found, remedy])) =
            (self.work.sequence.grid, self.of_one_picture(kind))
        {
            return Err(bad(name, found, remedy));
        }
        if !self.sum.is_empty() {
            weights_for(&self.sum, sigmas.len())?;
        }
        Ok(())
    }

    fn reading(&self, _: &Illumination) -> Result<(Inputs, Needs)> {
        let needs = Needs {
            projection: true,
            map: true,
            ..Needs::default()
        };
        Ok((self.work.inputs(), needs))
    }

    fn takes_whole(&self) -> bool {
        true
    }

    /// Reads the detail, and changes the normals as was asked for.
    fn begin(&self, inputs: &Inputs, frame: &Frame) -> Result<Results> {
        let mut made = Results::default();
        if self.flatten {
            let bend = Quadric::of(&frame.normal, &frame.mask).ok_or_else(|| {
                bad(
                    "--flatten",
                    "finds too few pixels that lean less than 30 degrees",
                    "leave it out",
                )
            })?;
            made.maps.normal = Some(bend.subtract(&frame.normal));
            made.notes.push(bend.in_words());
        }
        let Some(path) = &self.detail else {
            return Ok(made);
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
        if size != expected {
            return Err(Error::SizeMismatch {
                path: path.clone(),
                found: format!("{}x{}", size.0, size.1),
                expected: format!("the normals are {}x{}", expected.0, expected.1),
            });
        }
        let normal = made.maps.normal.as_ref().unwrap_or(&frame.normal);
        let laid = with_detail(normal, &detail.frame.normal, &detail.frame.mask);
        made.maps.normal = Some(laid);
        let warnings = detail.warnings.iter();
        made.warnings = warnings.map(|text| format!("--detail: {text}")).collect();
        Ok(made)
    }

    /// One for each scale, since each has a gain of its own; one for edges; and one for each radius of occlusion.
    fn plans(&self, seen: &mut FrameSeen) -> Result<Vec<Plan>> {
        let Params { shape, scaling, .. } = self.work.flags.params;
        let available = Available::in_frame(seen.frame);
        let plan = |products: &[Product], shape| {
            Plan::new(Goal::Products(products), available, shape, scaling)
        };
        let mut plans = Vec::new();
        if self.maps.iter().any(|map| map.has_scales()) {
            let more = self.work.flags.more_scales().iter();
            let scales = std::iter::once(shape.scale).chain(more.map(|&px| Scale::Sigma(px)));
            for scale in scales {
                let shape = ShapeParams {
                    scale,
                    crease: NO_CREASES,
                    ..shape
                };
                plans.push(plan(&[Product::MappedCurvature], shape)?);
            }
        }
        if self.maps.contains(&MapKind::Edges) {
            let products = [Product::Silhouette, Product::Crease, Product::Conductance];
            plans.push(plan(&products, shape)?);
        }
        let relief = [
            (MapKind::Height, Product::Height),
            (MapKind::Residual, Product::HeightResidual),
            (MapKind::Occlusion, Product::Sky),
        ];
        let relief = relief.iter().filter(|(map, _)| self.maps.contains(map));
        let products: Vec<_> = relief.map(|(_, product)| *product).collect();
        let radii = match self.maps.contains(&MapKind::Occlusion) {
            true => &self.work.flags.radii[..],
            false => &[shape.occlusion_radius],
        };
        for &occlusion_radius in radii.iter().filter(|_| !products.is_empty()) {
            let shape = ShapeParams {
                crease: NO_CREASES,
                occlusion_radius,
                ..shape
            };
            shape.validate()?;
            plans.push(plan(&products, shape)?);
        }
        Ok(plans)
    }

    fn take(&self, made: &mut Results, plan: &Plan, mut outcome: Outcome) -> Outcome {
        match (self.gains() > 1, outcome.gain.take()) {
            (true, Some(gain)) => {
                let sigma = plan.shape.scale_px();
                let note = format!("scale {sigma:.2}: curvature gain {gain:.3}");
                made.notes.push(note);
            }
            (_, gain) => made.outcome.gain = made.outcome.gain.or(gain),
        }
        add_timings(&mut made.outcome.timings, &outcome.timings);
        let (maps, shape) = (&mut made.maps, &mut outcome.shape);
        maps.kappa.extend(shape.kappa.take());
        if plan.wants(Product::Silhouette) {
            maps.edges = larger(shape.crease.take(), shape.silhouette.take());
        }
        maps.height = maps.height.take().or(shape.height.take());
        maps.residual = maps.residual.take().or(shape.height_residual.take());
        maps.sky.extend(shape.sky.take());
        outcome
    }

    fn picture<'a>(&self, _: &'a Frame, _: &'a Outcome) -> Option<MadePicture<'a>> {
        None
    }
}

impl MapArgs {
    /// The number of scales that get a gain of their own.
    fn gains(&self) -> usize {
        let is_open = self.work.flags.params.scaling.curvature_gain == Adaptive::Auto;
        match is_open && self.maps.iter().any(|map| map.has_scales()) {
            true => self.sigmas().len(),
            false => 0,
        }
    }

    /// A setting that is of a whole picture, and would differ from cell to cell of a sheet: its name, why, and what to do.
    fn of_one_picture(&self, kind: OutputKind) -> Option<[&'static str; 3]> {
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
        } else if matches!(kind, OutputKind::Picture(_)) && self.maps.contains(&MapKind::Height) {
            let found = "height runs from black to white in each picture, and --grid makes many";
            Some(["--map", found, "write an .npy, .tif or .exr"])
        } else {
            None
        }
    }

    /// The maps of a frame, one after another.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for normals in world space without a camera.
    pub(crate) fn made<'a>(
        &'a self,
        samples: &'a MapSamples,
        frame: &'a Frame,
    ) -> impl Iterator<Item = Result<MadeMap>> + 'a {
        let parts = self.parts().into_iter();
        parts.map(move |part| {
            let (planes, range) = self.planes(&part, samples, frame)?;
            Ok(MadeMap {
                part,
                planes,
                range,
            })
        })
    }

    /// The planes of a map, and the values shown in black and white.
    fn planes(
        &self,
        part: &MapPart,
        samples: &MapSamples,
        frame: &Frame,
    ) -> Result<(Vec<Plane>, [f32; 2])> {
        let one = |plane: Plane, range: [f32; 2]| (vec![plane], range);
        Ok(match part.map {
            MapKind::Curvature => one(self.kappa(part, samples), [-1.0, 1.0]),
            MapKind::Convex => {
                let kappa = self.kappa(part, samples);
                one(kappa.map(|kappa| kappa.max(0.0)), [0.0, 1.0])
            }
            MapKind::Concave => {
                let kappa = self.kappa(part, samples);
                one(kappa.map(|kappa| (-kappa).max(0.0)), [0.0, 1.0])
            }
            MapKind::Edges => {
                let edges = samples.edges.clone();
                one(edges.expect("a pass makes edges"), [0.0, 1.0])
            }
            MapKind::Height => {
                let height = samples.height.clone().expect("a pass makes the height");
                let range = range_of(&height, &frame.mask);
                one(height, range)
            }
            MapKind::Occlusion => one(samples.sky[part.scale.unwrap_or(0)].clone(), [0.0, 1.0]),
            MapKind::Residual => {
                let residual = samples.residual.clone();
                one(residual.expect("a pass makes the residual"), [0.0, 1.0])
            }
            MapKind::Normals => {
                let normal = samples.normal.as_ref().unwrap_or(&frame.normal);
                (self.axes.of_view(frame, normal)?, [-1.0, 1.0])
            }
        })
    }

    /// Mapped curvature at one scale, or the weighted mean over all.
    fn kappa(&self, part: &MapPart, samples: &MapSamples) -> Plane {
        let all = &samples.kappa;
        if self.sum.is_empty() {
            return all[part.scale.unwrap_or(0)].clone();
        }
        let weights = weights_for(&self.sum, all.len()).expect("they are checked");
        let total: f32 = weights.iter().map(|weight| weight.abs()).sum();
        let mut sum = Plane::filled(all[0].width(), all[0].height(), 0.0);
        for (plane, weight) in all.iter().zip(&weights) {
            sum.each_with(plane, |sum, kappa| *sum += weight / total * kappa);
        }
        sum
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
    one.each_with(&other, |one, other| *one = one.max(other));
    Some(one)
}
