//! What becomes of an outcome once its stages have run: it is cropped, mixed with what was there before, and completed for files.

use crate::frame::{Frame, Window};
use crate::light::mixing::mix;
use crate::line::fading::{faded, largest_around};
use crate::line::page::Page;
use crate::params::Params;
use crate::plan::Plan;
use crate::plan::drawing::{Contour, Drawing, Streamline};
use crate::plan::outcome::{FileSheet, Outcome, Shows};
use glam::Vec2;

impl Drawing {
    /// Crops the target coverage, which is no product, and lines and dots from the window `from` to the window `to`.
    fn crop(&mut self, from: Window, to: Window) {
        if let Some(asked) = &mut self.asked {
            *asked = asked.crop(from, to);
        }
        let corner = Vec2::new((to.x0 - from.x0) as f32, (to.y0 - from.y0) as f32);
        let page = Page {
            first: corner,
            last: corner + Vec2::new(to.width() as f32, to.height() as f32),
        };
        let strokes = self.lines.iter().flat_map(|line| {
            let parts = page.parts_of(&line.points, &line.widths);
            parts.map(|(points, widths)| Streamline {
                points,
                widths,
                ..*line
            })
        });
        self.lines = strokes.collect();
        for lines in [&mut self.contour_lines, &mut self.interior_lines] {
            let contours = lines.iter().flat_map(|line| {
                let parts = page.parts_of(&line.points, &line.widths);
                parts.map(|(points, widths)| Contour {
                    points,
                    widths,
                    ..*line
                })
            });
            *lines = contours.collect();
        }
        self.dots.retain(|dot| page.distance(dot.at) < dot.radius);
        self.dots.iter_mut().for_each(|dot| dot.at -= corner);
    }
}

impl Outcome {
    /// Crops results of the window `from` to the window `to`.
    pub(crate) fn crop(&mut self, from: Window, to: Window) {
        self.for_each_plane(|plane| *plane = plane.crop(from, to));
        if let Some(drawing) = &mut self.drawing {
            drawing.crop(from, to);
        }
    }

    /// Mixes what was made of a `frame` that was enlarged so many times with the frame's own: the requested share,
    /// overall and per pixel, of light or of ink. Where the mask selects lines along edges, they are kept whole as far as
    /// they reach.
    pub(crate) fn mix(&mut self, frame: &Frame, times: f64, params: &Params) {
        let (share, strength) = (params.mix, frame.strength.as_ref());
        if let Some(drawing) = &mut self.drawing {
            let width_px = params.line.contours.map_or(0.0, |lines| lines.width_px);
            let reach = (0.5 * f64::from(width_px) * times).ceil() as usize + 1;
            let around = strength.map(|strength| largest_around(strength, reach));
            faded(&mut drawing.hatching, strength, share);
            let within = drawing.interior.iter_mut().chain(&mut drawing.asked);
            within.for_each(|ink| faded(ink, strength, share));
            let along_edges = drawing.contours.iter_mut();
            along_edges.for_each(|ink| faded(ink, around.as_ref(), share));
        } else if let Some(made) = &mut self.color {
            let before = frame.color.as_ref();
            mix(made, before, strength, share);
            if let Some(confidence) = &frame.confidence {
                let kept = confidence.map(|confidence| 1.0 - params.blur_fade * (1.0 - confidence));
                mix(made, before, Some(&kept), 1.0);
            }
        }
    }

    /// Ends the run of a request by `plan` on a `frame` that was enlarged so many times: mixes, and remembers how its
    /// files are written.
    pub(crate) fn complete(&mut self, plan: &Plan, frame: &Frame, times: f64, params: &Params) {
        let shows = match plan {
            _ if plan.display => Shows::Curvature,
            _ if plan.drawing.is_some() => Shows::Drawing,
            _ if plan.relighting().is_some() => Shows::Relit,
            _ if plan.enhancement().is_some() => Shows::Enhanced,
            _ => Shows::Layers,
        };
        if shows != Shows::Curvature {
            self.mix(frame, times, params);
        }
        self.sheet = Some(Box::new(FileSheet {
            params: *params,
            shows,
            extent: frame.into(),
        }));
    }
}
