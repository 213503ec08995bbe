//! Reading environments and lit spheres.

use super::opened::{Holding, Opened};
use super::role_planes::RolePlanes;
use super::sources::{RoleSource, read_all, read_rows};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane, Window};
use crate::io::exr::Limits;
use crate::io::photo::CodeMeaning;
use crate::io::roles::Role;
use crate::light::environment::Environment;
use crate::light::environment_layout::Layout;
use crate::light::lit_sphere::LitSphere;
use crate::light::sane;
use std::path::Path;
use std::rc::Rc;

/// Layers of a lit sphere that keeps its highlights apart.
const LIT_SPHERE_LAYERS: [&str; 2] = ["diffuse", "specular"];

/// Bytes for each pixel of a latitude-longitude map or a lit sphere, while it is read and used: its planes, its colours
/// side by side, and a copy of them that is filtered.
const MAP_PER_PIXEL: u64 = 48;

/// The same of pictures that are made a latitude-longitude map, which has twice their pixels.
const LAYOUT_PER_PIXEL: u64 = 80;

/// The environment in the picture at `path`, EXR, HDR, PNG, JPEG or TIFF. How it holds directions is
/// recognised by its proportions: [`Layout::of_size`].
///
/// # Errors
/// Any [`Error`] of reading; [`Error::Unsupported`] for proportions of no layout, and without colour.
pub fn read_environment(path: &Path) -> Result<Environment> {
    read_environment_within(path, u64::MAX)
}

/// [`read_environment`] within about `most_bytes`: a larger picture is reduced while it is read, by averaging squares
/// of pixels.
///
/// # Errors
/// As [`read_environment`]; [`Error::Unsupported`] for a picture that is too large and can only be decoded whole.
pub(crate) fn read_environment_within(path: &Path, most_bytes: u64) -> Result<Environment> {
    let lights = LightsFile::open(path, most_bytes)?;
    let (width, height) = (lights.shown.width(), lights.shown.height());
    let layout = Layout::of_size(width, height).ok_or_else(|| Error::Unsupported {
        path: path.to_path_buf(),
        found: format!("is {width}x{height}, the proportions of no layout of an environment"),
        remedy:
            "give a latitude-longitude map (2:1), a mirror ball (1:1) or a cross of cube faces \
                 (3:4 or 4:3)"
                .into(),
    })?;
    let per_pixel = match layout {
        Layout::LatLong => MAP_PER_PIXEL,
        _ => LAYOUT_PER_PIXEL,
    };
    let picture = lights.read(per_pixel)?;
    if !layout.suits(&picture) {
        return Err(Error::Unsupported {
            path: path.to_path_buf(),
            found: format!(
                "is {width}x{height} as a cross of cube faces is, and is none: it shows something beside them"
            ),
            remedy: "give a latitude-longitude map (2:1) or a mirror ball (1:1)".into(),
        });
    }
    Ok(Environment::of_layout(picture, layout))
}

/// The lit sphere in the picture at `path`: EXR, HDR, PNG, JPEG or TIFF. Layers called `diffuse` and
/// `specular` are added up. Those of EXR and HDR have no upper limit: [`LitSphere::scene_linear`].
///
/// # Errors
/// Any [`Error`] of reading; [`Error::Unsupported`] without colour.
pub fn read_lit_sphere(path: &Path) -> Result<LitSphere> {
    read_lit_sphere_within(path, u64::MAX)
}

/// [`read_lit_sphere`] within about `most_bytes`: a larger picture is reduced, as for environments.
///
/// # Errors
/// As [`read_lit_sphere`]; [`Error::Unsupported`] for a picture that is too large and can only be decoded whole.
pub(crate) fn read_lit_sphere_within(path: &Path, most_bytes: u64) -> Result<LitSphere> {
    let lights = LightsFile::open(path, most_bytes)?;
    let (width, height) = (lights.shown.width(), lights.shown.height());
    if width >= 2 * height {
        return Err(Error::Unsupported {
            path: path.to_path_buf(),
            found: format!(
                "is {width}x{height}, an environment rather than the square picture of a ball"
            ),
            remedy: "give it with --environment".into(),
        });
    }
    let sphere = LitSphere::new(lights.read(MAP_PER_PIXEL)?);
    let photo = lights.file.photo();
    Ok(match photo.is_none_or(|photo| photo.header.is_float) {
        true => sphere.scene_linear(),
        false => sphere,
    })
}

/// The colour of a file over its display window, multiplied by its alpha and linear.
pub(crate) fn read_color(path: &Path) -> Result<ColorPlanes> {
    LightsFile::open(path, u64::MAX)?.read(0)
}

/// Columns and rows that the colour of a file has, by its header.
pub(crate) fn color_size(path: &Path) -> Result<[usize; 2]> {
    let shown = LightsFile::open(path, u64::MAX)?.shown;
    Ok([shown.width(), shown.height()])
}

/// A file with colours to use as light; only its header has been read.
struct LightsFile {
    file: Rc<Opened>,
    sources: Vec<RoleSource>,
    shown: Window,
    most_bytes: u64,
}

impl LightsFile {
    fn open(path: &Path, most_bytes: u64) -> Result<Self> {
        let holding = Holding::within(most_bytes);
        let file = Opened::open_held(path, [None; 2], holding)?;
        let sources = color_sources(&file).ok_or_else(|| {
            let layers = file.found("nothing");
            Error::Unsupported {
                path: path.to_path_buf(),
                found: format!("has no colour to light with (found {layers})"),
                remedy: "give a picture with channels R, G and B".into(),
            }
        })?;
        let shown = file.display();
        check_size(path, shown)?;
        Ok(Self {
            file,
            sources,
            shown,
            most_bytes,
        })
    }

    /// The colours in the display window, reduced if they would exceed the limit at `per_pixel` bytes each.
    fn read(&self, per_pixel: u64) -> Result<ColorPlanes> {
        let pixels = self.shown.width() as u64 * self.shown.height() as u64;
        let photo = self.file.photo();
        let stored = photo.map_or(0, |photo| photo.header.bytes());
        let bytes = pixels.saturating_mul(per_pixel).saturating_add(stored);
        if bytes <= self.most_bytes {
            return self.sum(read_all(&self.sources)?, self.shown);
        }
        let most = (self.most_bytes / per_pixel.max(1)).max(1);
        let factor = (1..).find(|f: &u64| pixels / (f * f) <= most);
        let factor = factor.expect("some square is large enough") as usize;
        let mut reduced = Reduced::new([self.shown.width(), self.shown.height()], factor);
        match photo {
            Some(photo) => {
                let rows = 0..photo.header.height;
                let row = Window::from_size(photo.header.width, 1);
                photo.each_row(rows, CodeMeaning::Linear, &mut |_, planes| {
                    let mut read = RolePlanes::of_photo(photo, planes, row);
                    read.premultiply();
                    reduced.add(&read.into_color());
                })?;
            }
            None => self.add_strips(&mut reduced)?,
        }
        Ok(reduced.done())
    }

    /// Adds an EXR's colour, a few rows at a time.
    fn add_strips(&self, reduced: &mut Reduced) -> Result<()> {
        for y0 in (self.shown.y0..self.shown.y1).step_by(ROWS_AT_A_TIME) {
            let y1 = (y0 + ROWS_AT_A_TIME as i32).min(self.shown.y1);
            let strip = Window {
                y0,
                y1,
                ..self.shown
            };
            let read = read_rows(&self.sources, Some(y0..y1), None)?;
            reduced.add(&self.sum(read, strip)?);
        }
        Ok(())
    }

    /// The sum of all layers over `shown`.
    fn sum(&self, read: Vec<RolePlanes>, shown: Window) -> Result<ColorPlanes> {
        let mut layers = read.into_iter().map(|mut read| {
            read.fit_to(Role::Color, shown);
            read.into_color()
        });
        let first = layers.next().expect("there is a source of colour");
        Ok(layers.fold(first, sum))
    }
}

/// Rows of an EXR that are read at a time to be reduced.
const ROWS_AT_A_TIME: usize = 64;

/// A picture reduced row by row, each pixel the mean of the source pixels in it.
struct Reduced {
    from: [usize; 2],
    planes: [Plane; 3],
    /// Sums for the current row.
    sums: [Vec<f64>; 3],
    /// Number of source rows read, and number of rows completed.
    rows: usize,
    made: usize,
}

/// Sides are a multiple of this unless shorter, so that all faces of a cross have the same size.
const SIDE_MULTIPLE: usize = 12;

impl Reduced {
    /// Reduces a picture of the size `from` by about `factor` in both directions.
    fn new(from: [usize; 2], factor: usize) -> Self {
        let [width, height] = from.map(|side| {
            let side = (side / factor).max(1);
            match side / SIDE_MULTIPLE {
                0 => side,
                multiple => multiple * SIDE_MULTIPLE,
            }
        });
        Self {
            from,
            planes: std::array::from_fn(|_| Plane::filled(width, height, 0.0)),
            sums: std::array::from_fn(|_| vec![0.0; width]),
            rows: 0,
            made: 0,
        }
    }

    fn size(&self) -> [usize; 2] {
        [self.planes[0].width(), self.planes[0].height()]
    }

    /// Adds the rows that come next.
    fn add(&mut self, color: &ColorPlanes) {
        for y in 0..color.r.height() {
            self.add_row([&color.r, &color.g, &color.b].map(|plane| plane.row(y)));
        }
    }

    fn add_row(&mut self, channels: [&[f32]; 3]) {
        let ([width, height], [from_width, from_height]) = (self.size(), self.from);
        for (sums, samples) in self.sums.iter_mut().zip(channels) {
            for (x, sum) in sums.iter_mut().enumerate() {
                let covered = &samples[x * from_width / width..(x + 1) * from_width / width];
                let total: f64 = covered.iter().map(|&v| f64::from(sane(v))).sum();
                *sum += total / covered.len() as f64;
            }
        }
        self.rows += 1;
        let y = self.made;
        // The current row ends where the next one begins.
        if self.rows == (y + 1) * from_height / height {
            let count = self.rows - y * from_height / height;
            for (sums, plane) in self.sums.iter_mut().zip(&mut self.planes) {
                for (sum, v) in sums.iter_mut().zip(plane.row_mut(y)) {
                    *v = (*sum / count as f64) as f32;
                    *sum = 0.0;
                }
            }
            self.made += 1;
        }
    }

    fn done(self) -> ColorPlanes {
        let [r, g, b] = self.planes;
        ColorPlanes { r, g, b }
    }
}

/// Refuses a window that the file merely claims to show.
fn check_size(path: &Path, shown: Window) -> Result<()> {
    let (width, height) = (shown.width(), shown.height());
    match (width as u64).saturating_mul(height as u64) <= Limits::default().max_pixels {
        true => Ok(()),
        false => Err(Error::Unsupported {
            path: path.to_path_buf(),
            found: format!("shows {width}x{height} pixels, too many"),
            remedy: "make it smaller".into(),
        }),
    }
}

/// The layers of a file's colour: one, or two to be summed.
fn color_sources(file: &Rc<Opened>) -> Option<Vec<RoleSource>> {
    let layers = file.layer_names();
    if LIT_SPHERE_LAYERS
        .iter()
        .all(|&name| layers.iter().any(|l| l == name))
    {
        let named =
            LIT_SPHERE_LAYERS.map(|name| RoleSource::resolve(Role::Color, Some(name), file));
        if let [Ok(Some(diffuse)), Ok(Some(specular))] = named {
            return Some(vec![diffuse, specular]);
        }
    }
    RoleSource::in_file(Role::Color, file).map(|source| vec![source])
}

fn sum(mut a: ColorPlanes, b: ColorPlanes) -> ColorPlanes {
    for (a, b) in [(&mut a.r, b.r), (&mut a.g, b.g), (&mut a.b, b.b)] {
        a.each_with(&b, |a, b| *a += b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_is_reduced_to_means_of_what_falls_on_each_pixel() {
        // 5 columns on 2: the first two, and the last three; 4 rows on 2. Of x + 10 y the mean of a box is that of its
        // middle: x 0.5 and 3, y 0.5 and 2.5.
        let plane = |scale: f32| Plane::from_fn(5, 4, |x, y| scale * (x as f32 + 10.0 * y as f32));
        let color = ColorPlanes {
            r: plane(1.0),
            g: plane(2.0),
            b: plane(4.0),
        };
        let mut reduced = Reduced::new([5, 4], 2);
        reduced.add(&color);
        let done = reduced.done();
        assert_eq!(done.r.samples(), [5.5, 8.0, 25.5, 28.0]);
        assert_eq!(done.b.samples(), [22.0, 32.0, 102.0, 112.0]);
    }
}
