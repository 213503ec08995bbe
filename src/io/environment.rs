//! Reading what lights a surface: environments and lit spheres.

use super::exr::Limits;
use super::roles::Role;
use super::sources::{Opened, RolePlanes, RoleSource, read_all};
use crate::error::{Error, Result};
use crate::frame::{ColorPlanes, Plane, Window};
use crate::light::environment::Environment;
use crate::light::environment_layout::Layout;
use crate::light::lit_sphere::LitSphere;
use std::path::Path;
use std::rc::Rc;

/// Layers of a lit sphere that keeps its highlights apart.
const LIT_SPHERE_LAYERS: [&str; 2] = ["diffuse", "specular"];

/// The environment in the picture at `path`, EXR, HDR, PNG, JPEG or TIFF. How it holds directions is
/// told from its proportions: [`Layout::of_size`].
pub fn read_environment(path: &Path) -> Result<Environment> {
    let color = read_color(path)?;
    let (width, height) = (color.r.width(), color.r.height());
    let layout = Layout::of_size(width, height).ok_or_else(|| Error::Unsupported {
        path: path.to_path_buf(),
        found: format!("is {width}x{height}, the proportions of no layout of an environment"),
        remedy:
            "give a latitude-longitude map (2:1), a mirror ball (1:1) or a cross of cube faces \
                 (3:4 or 4:3)"
                .into(),
    })?;
    Ok(Environment::of_layout(color, layout))
}

/// The environment in the picture at `path`, which holds directions as `layout` says.
pub fn read_environment_as(path: &Path, layout: Layout) -> Result<Environment> {
    Ok(Environment::of_layout(read_color(path)?, layout))
}

/// The lit sphere in the picture at `path`: EXR, HDR, PNG, JPEG or TIFF. Layers called `diffuse` and
/// `specular` are added up.
pub fn read_lit_sphere(path: &Path) -> Result<LitSphere> {
    Ok(LitSphere::new(read_color(path)?))
}

/// The colour of a file over its display window, multiplied by its alpha and linear.
pub(super) fn read_color(path: &Path) -> Result<ColorPlanes> {
    let file = Opened::open(path)?;
    let sources = color_sources(&file).ok_or_else(|| {
        let layers = file.layer_names().join(", ");
        Error::Unsupported {
            path: path.to_path_buf(),
            found: format!("has no colour to light with (found {layers})"),
            remedy: "give a picture with channels R, G and B".into(),
        }
    })?;
    let shown = match file.as_ref() {
        Opened::Exr { file, .. } => file.display_window,
        Opened::Photo { photo, .. } => Window::from_size(photo.width, photo.height),
    };
    check_size(path, shown)?;
    let mut layers = read_all(&sources)?
        .into_iter()
        .zip(&sources)
        .map(|(planes, source)| color_of(planes, source.window(), shown));
    let first = layers.next().expect("there is a source of colour");
    Ok(layers.fold(first, sum))
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

/// Where a file's colour is: one layer, or two to be added up.
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

/// Three planes over `shown` of one or three over `window`; black where nothing was stored.
fn color_of(read: RolePlanes, window: Window, shown: Window) -> ColorPlanes {
    let mut planes = read.planes.into_iter().map(|plane| match window == shown {
        true => plane,
        false => placed(&plane, window, shown),
    });
    let r = planes.next().expect("colour has at least one plane");
    let g = planes.next().unwrap_or_else(|| r.clone());
    let b = planes.next().unwrap_or_else(|| r.clone());
    ColorPlanes { r, g, b }
}

fn placed(plane: &Plane, window: Window, shown: Window) -> Plane {
    Plane::from_fn(shown.width(), shown.height(), |x, y| {
        let (x, y) = (shown.x0 + x as i32, shown.y0 + y as i32);
        match window.contains(x, y) {
            true => plane.at((x - window.x0) as usize, (y - window.y0) as usize),
            false => 0.0,
        }
    })
}

fn sum(a: ColorPlanes, b: ColorPlanes) -> ColorPlanes {
    let add = |mut a: Plane, b: Plane| {
        let samples = a.samples_mut().iter_mut().zip(b.samples());
        samples.for_each(|(a, b)| *a += b);
        a
    };
    ColorPlanes {
        r: add(a.r, b.r),
        g: add(a.g, b.g),
        b: add(a.b, b.b),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_is_placed_in_what_is_shown() {
        let plane = Plane::from_fn(2, 2, |x, y| (1 + x + 2 * y) as f32);
        let placed = placed(&plane, Window::at(-1, 1, 2, 2), Window::at(0, 0, 2, 3));
        assert_eq!(placed.samples(), [0.0, 0.0, 2.0, 0.0, 4.0, 0.0]);
    }
}
