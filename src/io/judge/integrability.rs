//! Whether y of a normal map points up (OpenGL) or down (DirectX), judged from the map itself.
//!
//! Slopes p = -n_x / n_z and q = -n_y / n_z of a height, x right and y up, have no curl: dp/dy = dq/dx. With y turned,
//! dp/dy = -dq/dx instead. The sum of (dp/dy - dq/dx)^2 is the curl as the map is, that of (dp/dy + dq/dx)^2 the
//! curl with y turned, and the smaller one is that of a surface. Noise adds as much to both.
//!
//! Limits: a height and its negative are both surfaces, so x reversed is equivalent to y reversed, and both reversed to
//! neither. Of each pair the usual one is assumed: as stored, or y reversed. Surfaces that bend only along x or only
//! along y give no evidence.

use crate::frame::sampling::one_in;
use crate::frame::{Mask, Vector3Planes};
use glam::DVec3;

/// Blocks that the normals are averaged to, at most: rounding and noise fall as blocks grow.
const BLOCKS: usize = 250_000;
/// Pixels that are looked at, about, in cells of two by two blocks.
const PIXELS: usize = 500_000;
/// Unit normals below this z are at silhouettes or on slopes too steep to count.
const LEAST_NZ: f64 = 0.3;
/// Cosine between neighbouring normals below which there is an edge between them.
const SMOOTH: f64 = 0.7;
/// One curl is this many times the other, or neither is believed.
const DECIDES: f64 = 2.0;
/// The curl is this many times that with x and y exchanged, or they are not.
const EXCHANGED: f64 = 8.0;
/// Least share of the curl as it is that the greater one of x and y exchanged has.
const PLAIN: f64 = 0.25;
/// Fewer cells of four blocks than this decide nothing.
const FEWEST_CELLS: usize = 16;
/// Mean square change of slope from block to block below which a map is flat.
const FLAT: f64 = 1e-8;

/// The curl of a normal map, read both ways: mean squares of the change of slope from block to block.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Curl {
    as_is: f64,
    y_turned: f64,
    cells: usize,
}

impl Curl {
    /// Measures unit normals of view space; either sign of z will do. Where edges and noise of single pixels hide which way y
    /// points, larger blocks are looked at.
    pub(crate) fn of(normal: &Vector3Planes, mask: &Mask) -> Self {
        let side = least_side(mask);
        let finest = Self::finest(normal, mask);
        let shows = |curl: &Self| curl.is_flat() || curl.y_points_down().is_some();
        let mut coarser = [2, 4]
            .into_iter()
            .map(|factor| Self::of_blocks(normal, mask, factor * side));
        match shows(&finest) {
            true => finest,
            false => coarser
                .find(|curl| curl.y_points_down().is_some())
                .unwrap_or(finest),
        }
    }

    /// The same by the smallest blocks alone.
    pub(crate) fn finest(normal: &Vector3Planes, mask: &Mask) -> Self {
        Self::of_blocks(normal, mask, least_side(mask))
    }

    /// Whether x and y are exchanged: the other way round there is far less curl, whichever y is turned.
    pub(crate) fn shows_exchange(normal: &Vector3Planes, mask: &Mask) -> bool {
        let turned = Vector3Planes {
            x: normal.y.clone(),
            y: normal.x.clone(),
            z: normal.z.clone(),
        };
        [1, 2, 4].into_iter().any(|factor| {
            let curl = |normal| Self::of_blocks(normal, mask, factor * least_side(mask));
            let (own, other) = (curl(normal), curl(&turned));
            let least = |curl: &Self| curl.as_is.min(curl.y_turned);
            // A saddle has no curl either way, but for rounding. With y turned other surfaces have as much as exchanged.
            let is_plain = PLAIN * least(&own) < other.as_is.max(other.y_turned);
            is_plain && !own.is_flat() && least(&own) > EXCHANGED * least(&other)
        })
    }

    fn of_blocks(normal: &Vector3Planes, mask: &Mask, side: usize) -> Self {
        let [columns, rows] = [mask.width(), mask.height()].map(|length| length / side);
        let [across, down] = [columns, rows].map(|blocks| blocks.saturating_sub(1));
        let wanted = (PIXELS / (4 * side * side)).max(1);
        let mut curl = Self::default();
        for (x, y) in one_in((across * down) as f64 / wanted as f64, 0..across, 0..down) {
            let places = [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
            curl.add(places.map(|(x, y)| block(normal, mask, side, x, y)));
        }
        let cells = curl.cells.max(1) as f64;
        curl.as_is /= cells;
        curl.y_turned /= cells;
        curl
    }

    /// Adds a cell of four blocks, the upper two first.
    fn add(&mut self, cell: [Option<DVec3>; 4]) {
        let [Some(a), Some(b), Some(c), Some(d)] = cell else {
            return;
        };
        let is_smooth = [(a, b), (c, d), (a, c), (b, d)]
            .iter()
            .all(|(one, other)| one.dot(*other) > SMOOTH);
        if !is_smooth {
            return;
        }
        let [a, b, c, d] = [a, b, c, d].map(|n| -n.truncate() / n.z);
        let p_along_y = 0.5 * (a + b - c - d).x;
        let q_along_x = 0.5 * (b + d - a - c).y;
        self.as_is += (p_along_y - q_along_x).powi(2);
        self.y_turned += (p_along_y + q_along_x).powi(2);
        self.cells += 1;
    }

    /// Whether the map is too flat to judge, in which case the choice matters little.
    pub(crate) fn is_flat(&self) -> bool {
        self.cells < FEWEST_CELLS || self.as_is.max(self.y_turned) <= FLAT
    }

    /// Whether y points down; `None` if the map gives no evidence.
    pub(crate) fn y_points_down(&self) -> Option<bool> {
        let (least, most) = (self.as_is.min(self.y_turned), self.as_is.max(self.y_turned));
        let shows = !self.is_flat() && most >= DECIDES * least;
        shows.then_some(self.y_turned < self.as_is)
    }

    /// Whether x and y can be reversed so: the curl shows whether exactly one of them is, where it shows anything.
    pub(crate) fn allows(&self, [x, y]: [bool; 2]) -> bool {
        self.y_points_down().is_none_or(|one| one == (x != y))
    }

    /// The ratio of the two, as the tail of a sentence.
    pub(crate) fn reason(&self) -> String {
        if self.is_flat() {
            return "too little slope to tell whether y points up".into();
        }
        let ratio = self.as_is / self.y_turned.max(f64::MIN_POSITIVE);
        let verdict = match self.y_points_down() {
            Some(true) => "y points down (DirectX)",
            Some(false) => "y points up (OpenGL)",
            None => "whether y points up is unclear",
        };
        format!("{verdict}: the curl of its slopes is {ratio:.3} times that with y turned")
    }
}

/// Side of the smallest blocks.
fn least_side(mask: &Mask) -> usize {
    let pixels = mask.width() * mask.height();
    (pixels as f64 / BLOCKS as f64).sqrt().ceil().max(1.0) as usize
}

/// The mean normal of a block, z toward the viewer; `None` if it is not all covered or too steep.
fn block(
    normal: &Vector3Planes,
    mask: &Mask,
    side: usize,
    column: usize,
    row: usize,
) -> Option<DVec3> {
    let mut sum = DVec3::ZERO;
    for y in row * side..(row + 1) * side {
        for x in column * side..(column + 1) * side {
            if !mask.at(x, y) {
                return None;
            }
            let n = normal.at(x, y);
            // With z away from the viewer both slopes change sign, and the curl keeps its magnitude.
            sum += n.truncate().extend(n.z.abs());
        }
    }
    sum.try_normalize().filter(|n| n.z >= LEAST_NZ)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Normals of slopes p, q at pixels, y up from the bottom row.
    fn map(slopes: impl Fn(f64, f64) -> [f64; 2]) -> Curl {
        let normal = Vector3Planes::from_fn(64, 64, |x, y| {
            let [p, q] = slopes(x as f64, 63.0 - y as f64);
            DVec3::new(-p, -q, 1.0).normalize()
        });
        Curl::of(&normal, &Mask::full(64, 64))
    }

    /// A saddle h = k x y has p = k y, q = k x: dp/dy = dq/dx = k = 1/64, so its curl is 0, and with y
    /// turned (q = -k x) dp/dy - dq/dx = 2 k, whose square is 4 / 4096.
    #[test]
    fn a_surface_has_no_curl_and_has_it_with_y_turned() {
        let k = 1.0 / 64.0;
        let (up, down) = (map(|x, y| [k * y, k * x]), map(|x, y| [k * y, -k * x]));
        for (curl, as_is, y_turned) in [(up, 0.0, 4.0 * k * k), (down, 4.0 * k * k, 0.0)] {
            assert!((curl.as_is - as_is).abs() < 1e-9, "{curl:?}");
            assert!((curl.y_turned - y_turned).abs() < 1e-9, "{curl:?}");
        }
        assert_eq!(up.y_points_down(), Some(false));
        assert_eq!(down.y_points_down(), Some(true));
    }

    /// Flat maps, single pixels, random slopes, and surfaces that bend along x alone give no evidence.
    #[test]
    fn what_shows_nothing_decides_nothing() {
        let mut state = 1_u64;
        let noise: Vec<f64> = (0..2 * 64 * 64)
            .map(|_| {
                state = state
                    .wrapping_mul(6_364_136_223_846_793_005)
                    .wrapping_add(1);
                (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
            })
            .collect();
        let at = |x: f64, y: f64| 2 * (64 * y as usize + x as usize);
        let pixel = Vector3Planes::from_fn(1, 1, |_, _| DVec3::Z);
        for curl in [
            map(|_, _| [0.0, 0.0]),
            map(|x, _| [0.01 * x, 0.0]),
            map(|x, y| [noise[at(x, y)], noise[at(x, y) + 1]].map(|v| 0.2 * v)),
            Curl::of(&pixel, &Mask::full(1, 1)),
        ] {
            assert_eq!(curl.y_points_down(), None, "{curl:?}");
        }
    }
}
