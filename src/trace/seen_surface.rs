//! A frame as a surface for ray hits: the part seen by its camera.

use super::bounds::{Bounds, of_planes};
use super::search::{Bounded, Crossing, first_crossing, steps_for};
use super::texels::{
    BeyondSides, Reached, TangentPlane, TexelShare, agreed, around, heaviest, mean_at,
};
use crate::frame::{
    ColorPlanes, DepthKind, Frame, Plane, Projection, Ray, SightLines, Vector2Planes,
};
use crate::params::SearchParams;
use glam::{DVec2, DVec3};

/// The pixels of a frame as points of its visible surface.
#[derive(Debug, Clone, Copy)]
pub(crate) struct VisibleSurface<'a> {
    frame: &'a Frame,
    depth: &'a Plane,
    sight: SightLines,
}

impl<'a> VisibleSurface<'a> {
    /// The surface of `frame` along `sight` lines. `None` if its depth is missing or no distance.
    pub(crate) fn new(frame: &'a Frame, sight: SightLines) -> Option<Self> {
        let depth = frame.depth.as_ref()?;
        let is_distance = frame.source.depth_kind != DepthKind::Relative;
        is_distance.then_some(Self {
            frame,
            depth,
            sight,
        })
    }

    /// Position of a pixel centre in the picture, relative to the display window.
    #[inline]
    pub(crate) fn middle(&self, x: usize, y: usize) -> DVec2 {
        self.frame.data_window.middle(x, y)
    }

    /// The view-space point shown by a pixel.
    #[inline]
    pub(crate) fn point(&self, x: usize, y: usize) -> DVec3 {
        let at = self.middle(x, y);
        self.sight
            .point(at.x, at.y, self.depth(x, y), DepthKind::Planar)
    }

    /// The normal of a pixel.
    #[inline]
    pub(crate) fn normal(&self, x: usize, y: usize) -> DVec3 {
        self.frame.normal.at(x, y)
    }

    /// Depth along the view axis of a covered pixel.
    #[inline]
    fn depth(&self, x: usize, y: usize) -> f64 {
        let depth = f64::from(self.depth.at(x, y));
        match self.frame.source.depth_kind {
            DepthKind::Ray => {
                let at = self.middle(x, y);
                depth / self.sight.line(at.x, at.y).1.length()
            }
            DepthKind::Planar | DepthKind::Relative => depth,
        }
    }

    fn corner(&self) -> DVec2 {
        let window = self.frame.data_window;
        DVec2::new(window.x0.into(), window.y0.into())
    }
}

/// The visible surface of a frame, for ray hits.
#[derive(Debug, Clone)]
pub(crate) struct SeenSurface<'a> {
    visible: VisibleSurface<'a>,
    /// Tangent planes in view space, row-major.
    planes: Vec<TangentPlane>,
    /// Bounds of depth by blocks of pixels.
    bounds: Bounds,
    /// Smallest and largest depth along the view axis.
    depths: [f64; 2],
}

/// Side of a block of bounds, in pixels.
const BLOCK: usize = 16;

/// Rays are traced slightly beyond the nearest and the farthest depth.
const BEYOND: f64 = 1.001;

impl<'a> SeenSurface<'a> {
    /// The surface of `frame` along `sight` lines. `None` if its depth is missing or no distance, or if it shows
    /// nothing.
    pub(crate) fn new(frame: &'a Frame, sight: SightLines) -> Option<Self> {
        let visible = VisibleSurface::new(frame, sight)?;
        let width = frame.mask.width();
        let mut planes = vec![TangentPlane::NONE; width * frame.mask.height()];
        let mut depths = [f64::INFINITY, 0.0_f64];
        for (y, planes) in planes.chunks_mut(width).enumerate() {
            for x in frame.mask.runs(y).flatten() {
                let depth = visible.depth(x, y);
                depths = [depths[0].min(depth), depths[1].max(depth)];
                planes[x] = TangentPlane::new(visible.point(x, y), visible.normal(x, y), depth);
            }
        }
        (depths[0] <= depths[1]).then(|| Self {
            visible,
            bounds: bounds(&planes, width),
            planes,
            depths,
        })
    }

    /// The frame.
    pub(crate) fn frame(&self) -> &'a Frame {
        self.visible.frame
    }

    /// Where a ray first passes through the surface from the viewer's side, and the position in the picture that shows
    /// it. `None` if it is never in front of the surface.
    pub(crate) fn reached(&self, ray: &Ray, search: &SearchParams) -> Option<Reached<DVec2>> {
        let way = self.way(ray)?;
        let [from, to] = way.places;
        let steps = steps_for(search, from.distance(to) / self.span());
        let crossing = first_crossing(
            steps,
            search.refinements,
            |s| self.bounded(way.place(s)),
            |s| {
                let (at, depth) = way.place(s);
                let (surface, ..) = self.depth_at(at)?;
                Some(1.0 - depth / surface)
            },
            |s| {
                let crossed = || {
                    let (.., texels) = self.depth_at(way.place(s).0)?;
                    let plane = self.plane(&heaviest(&texels));
                    let along = plane.crossed(ray.start, ray.direction);
                    let point = ray.start + along * ray.direction;
                    self.visible.sight.projection().pixel_of(point)
                };
                let seen = crossed().unwrap_or(from);
                (seen - from).dot(to - from) / (to - from).length_squared()
            },
        );
        let point_at = |s: f64| {
            let (at, depth) = way.place(s);
            let sight = &self.visible.sight;
            (sight.point(at.x, at.y, depth, DepthKind::Planar), at)
        };
        match crossing {
            Crossing::Hit(s) => {
                let (point, at) = point_at(s);
                Some(Reached::Seen(point, at))
            }
            Crossing::Unseen(s) => {
                let (seen, at) = point_at(s);
                let (.., texels) = self.depth_at(at)?;
                let texel = heaviest(&texels);
                let point = self.plane(&texel).continued(ray, seen)?;
                Some(Reached::Beyond(
                    point,
                    self.visible.middle(texel.x, texel.y),
                ))
            }
            Crossing::Nothing => None,
        }
    }

    fn plane(&self, texel: &TexelShare) -> &TangentPlane {
        &self.planes[texel.y * self.frame().mask.width() + texel.x]
    }

    /// Bounds at a depth at a position in the picture.
    #[inline]
    fn bounded(&self, (at, depth): (DVec2, f64)) -> Bounded {
        let mask = &self.frame().mask;
        let inside = at - self.visible.corner();
        // A cast of less than 0 is 0, and beyond the picture there is nothing.
        let block = |at: f64, size: usize| (at as usize).min(size - 1) / BLOCK;
        let row = block(inside.y, mask.height());
        let cell = row * mask.width().div_ceil(BLOCK) + block(inside.x, mask.width());
        self.bounds.compared(cell, depth, 1.0)
    }

    /// Depth along the view axis at a position in the picture; `None` without a surface.
    #[inline]
    pub(crate) fn depth_at_place(&self, at: DVec2) -> Option<f64> {
        self.depth_at(at).map(|(depth, ..)| depth)
    }

    /// The point of the surface at a position in the picture.
    #[inline]
    pub(crate) fn point_at(&self, at: DVec2) -> Option<DVec3> {
        let depth = self.depth_at_place(at)?;
        Some(
            self.visible
                .sight
                .point(at.x, at.y, depth, DepthKind::Planar),
        )
    }

    /// The unit normal at a position in the picture, where the surface has the depth of `point`.
    #[inline]
    pub(crate) fn normal_at(&self, at: DVec2, point: DVec3) -> Option<DVec3> {
        let (_, distances, texels) = self.depth_at(at)?;
        mean_at(-point.z, distances, &texels, |t| {
            self.visible.normal(t.x, t.y)
        })?
        .try_normalize()
    }

    /// The colour at a position in the picture.
    #[inline]
    pub(crate) fn color_at(
        &self,
        color: &ColorPlanes,
        at: DVec2,
        point: DVec3,
    ) -> Option<[f32; 3]> {
        let (_, distances, texels) = self.depth_at(at)?;
        let own = |t: &TexelShare| {
            let [r, g, b] = [&color.r, &color.g, &color.b].map(|p| f64::from(p.at(t.x, t.y)));
            DVec3::new(r, g, b)
        };
        Some(
            mean_at(-point.z, distances, &texels, own)?
                .as_vec3()
                .to_array(),
        )
    }

    /// The unit direction at a position in the picture, from a field of directions, opposites being equal.
    #[inline]
    pub(crate) fn direction_at(
        &self,
        field: &Vector2Planes,
        at: DVec2,
        point: DVec3,
    ) -> Option<DVec2> {
        let (_, distances, texels) = self.depth_at(at)?;
        let doubled = |t: &TexelShare| {
            let [x, y] = [&field.x, &field.y].map(|p| f64::from(p.at(t.x, t.y)));
            DVec3::new(x * x - y * y, 2.0 * x * y, 0.0)
        };
        let mean = mean_at(-point.z, distances, &texels, doubled)?;
        let half = 0.5 * mean.y.atan2(mean.x);
        (mean.length_squared() > 0.0).then(|| DVec2::from_angle(half))
    }

    /// Sum of the picture's width and height, in pixels.
    fn span(&self) -> f64 {
        let window = self.frame().data_window;
        (window.width() + window.height()) as f64
    }

    /// Depth along the view axis at a position in the picture, and the distance by each texel around it.
    #[inline]
    fn depth_at(&self, at: DVec2) -> Option<(f64, [Option<f64>; 4], [TexelShare; 4])> {
        let mask = &self.frame().mask;
        let size = [mask.width(), mask.height()];
        let inside = at - self.visible.corner();
        let is_inside = inside.x >= 0.0
            && inside.y >= 0.0
            && inside.x <= size[0] as f64
            && inside.y <= size[1] as f64;
        if !is_inside {
            return None;
        }
        let texels = around(inside, size, BeyondSides::Ends);
        let (start, line) = self.visible.sight.line(at.x, at.y);
        // Mapping the array is not inlined.
        let mut distances = [None; 4];
        for (distance, t) in distances.iter_mut().zip(&texels) {
            *distance = self.planes[t.y * size[0] + t.x].along(start, line);
        }
        Some((agreed(distances, &texels)?, distances, texels))
    }

    /// The path of a ray through the picture, as far as it can hit the surface; `None` if it cannot.
    fn way(&self, ray: &Ray) -> Option<StraightPath> {
        let projection = self.visible.sight.projection();
        let inverse = matches!(projection, Projection::Perspective { .. });
        let [nearest, farthest] = self.depths;
        let (start, falls) = (-ray.start.z, ray.direction.z);
        let [near, far] = [nearest / BEYOND, farthest * BEYOND];
        if inverse && start <= 0.0 {
            return None;
        }
        // Beyond the depths of the surface there is nothing to hit; rays of constant depth end outside the picture.
        let window = self.frame().data_window;
        let across = ray.direction.truncate().length();
        let reach = self.units_of(self.span(), start.max(near)) / across;
        let to_depth = match falls < 0.0 {
            true => (far - start) / -falls,
            false => (start - near) / falls,
        };
        let length = to_depth.min(reach);
        let goes_on = length > 0.0 && length.is_finite();
        if !goes_on {
            return None;
        }
        let end = ray.start + length * ray.direction;
        let (from, to) = (projection.pixel_of(ray.start)?, projection.pixel_of(end)?);
        let way = StraightPath {
            places: [from, to],
            depths: [start, -end.z],
            inverse,
        };
        let [first, last] = inside(
            way.places,
            self.visible.corner(),
            window.width(),
            window.height(),
        )?;
        Some(way.part(first, last))
    }

    /// Length of this many pixels at a depth.
    fn units_of(&self, pixels: f64, depth: f64) -> f64 {
        match self.visible.sight.projection() {
            Projection::Perspective { fx, fy, .. } => 2.0 * pixels * depth / fx.abs().min(fy.abs()),
            Projection::Orthographic { sx, sy, .. } => 2.0 * pixels / sx.abs().min(sy.abs()),
        }
    }
}

/// The bounds of a picture with these tangent planes, block by block.
fn bounds(planes: &[TangentPlane], width: usize) -> Bounds {
    let height = planes.len() / width;
    // Bilinearly a pixel counts up to half a pixel beyond the next one's border.
    let counting = |block: usize, size: usize| {
        (block * BLOCK).saturating_sub(2)..((block + 1) * BLOCK + 2).min(size)
    };
    let columns = width.div_ceil(BLOCK);
    let mut bounds = Bounds::new(columns * height.div_ceil(BLOCK));
    for cell in 0..bounds.count() {
        let rows = counting(cell / columns, height);
        let own = rows.flat_map(|y| &planes[y * width..][counting(cell % columns, width)]);
        bounds.widen(cell, of_planes(own));
    }
    bounds
}

/// A straight path through the picture, even in pixels: along it 1/depth is linear in perspective, else depth is.
#[derive(Debug, Clone, Copy)]
struct StraightPath {
    places: [DVec2; 2],
    depths: [f64; 2],
    inverse: bool,
}

impl StraightPath {
    #[inline]
    fn place(&self, s: f64) -> (DVec2, f64) {
        let [from, to] = self.places;
        let [near, far] = self.depths;
        let depth = match self.inverse {
            true => 1.0 / ((1.0 - s) / near + s / far),
            false => near + s * (far - near),
        };
        (from + s * (to - from), depth)
    }

    fn part(&self, first: f64, last: f64) -> Self {
        let ends = [self.place(first), self.place(last)];
        Self {
            places: ends.map(|end| end.0),
            depths: ends.map(|end| end.1),
            ..*self
        }
    }
}

/// The part of a line, as shares of it, inside a rectangle.
fn inside([from, to]: [DVec2; 2], corner: DVec2, width: usize, height: usize) -> Option<[f64; 2]> {
    let (start, step) = (from - corner, to - from);
    let [mut first, mut last] = [0.0_f64, 1.0_f64];
    for (start, step, size) in [
        (start.x, step.x, width as f64),
        (start.y, step.y, height as f64),
    ] {
        let (a, b) = (-start / step, (size - start) / step);
        if step == 0.0 {
            if !(0.0..=size).contains(&start) {
                return None;
            }
            continue;
        }
        first = first.max(a.min(b));
        last = last.min(a.max(b));
    }
    (first < last).then_some([first, last])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::{Mask, Vector3Planes, Window};
    use crate::trace::bounds::vectors;

    #[test]
    fn bounds_change_no_hit() {
        // Surfaces at random, and holes between them: rays pass behind edges everywhere.
        let mut vector = vectors();
        for [width, height] in [[1, 1], [5, 1], [15, 17], [70, 50]] {
            let middle = [0.5 * width as f64 - 3.0, 0.5 * height as f64 + 7.0];
            let [cx, cy] = middle;
            let [sx, sy] = [0.3 * width as f64; 2];
            let [fx, fy] = [3.0 * sx; 2];
            let parallel = Projection::Orthographic { sx, sy, cx, cy };
            for projection in [Projection::Perspective { fx, fy, cx, cy }, parallel] {
                let normals = Vector3Planes::from_fn(width, height, |_, _| vector().normalize());
                let covered = Plane::from_fn(width, height, |_, _| vector().x > -0.8);
                let mut frame = Frame::of_normals(normals, Mask::new(covered));
                frame.data_window = Window::at(-3, 7, width, height);
                frame.depth = Some(Plane::from_fn(width, height, |_, _| {
                    3.0 + 0.4 * vector().x as f32
                }));
                frame.source.depth_kind = DepthKind::Planar;
                let Some(surface) = SeenSurface::new(&frame, SightLines::new(projection)) else {
                    continue;
                };
                let open = SeenSurface {
                    bounds: Bounds::open(width * height),
                    ..surface.clone()
                };
                let mut seen = 0;
                for _ in 0..2_000 {
                    let ray = Ray {
                        start: 2.0 * vector() - 3.0 * DVec3::Z,
                        direction: vector().normalize(),
                    };
                    let search = SearchParams::default();
                    let found = surface.reached(&ray, &search);
                    assert_eq!(found, open.reached(&ray, &search), "{width}: {ray:?}");
                    seen += usize::from(matches!(found, Some(Reached::Seen(..))));
                }
                assert!(width < 15 || seen > 100, "{width}: {seen}");
            }
        }
    }
}
