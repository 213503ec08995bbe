//! Conductance: how freely the gradient diffuses through a pixel and across its faces.

/// Conductance of a pixel, 0..1, from its silhouette and crease weights ([LW] section 4.4).
#[inline(always)]
pub fn conductance(silhouette: f32, crease: f32) -> f32 {
    1.0 - silhouette.max(crease)
}

/// [`conductance`] of a row; 0 where uncovered.
#[inline(always)]
pub(crate) fn conductance_row(
    out: &mut [f32],
    silhouette: &[f32],
    crease: &[f32],
    covered: &[bool],
) {
    let n = out.len();
    let (silhouette, crease, covered) = (&silhouette[..n], &crease[..n], &covered[..n]);
    for x in 0..n {
        let open = conductance(silhouette[x], crease[x]);
        out[x] = if covered[x] { open } else { 0.0 };
    }
}

/// Conductance of the face between two pixels: their harmonic mean, 0 where either is 0.
///
/// Nothing leaks through a closed ring of zeros, and it is second order in space. The minimum is only first order, the
/// product converges to a different equation, and the arithmetic mean leaks.
#[inline(always)]
pub(crate) fn face_conductance(a: f32, b: f32) -> f32 {
    let sum = a + b;
    if sum > 0.0 { 2.0 * a * b / sum } else { 0.0 }
}

/// Face conductances between the pixels of two rows or of one row and itself shifted by one.
#[inline(always)]
pub(crate) fn face_conductance_row(faces: &mut [f32], a: &[f32], b: &[f32]) {
    for ((face, &a), &b) in faces.iter_mut().zip(a).zip(b) {
        *face = face_conductance(a, b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_face_beside_a_barrier_is_closed() {
        assert_eq!(face_conductance(0.0, 1.0), 0.0);
        assert_eq!(face_conductance(0.0, 0.0), 0.0);
        assert_eq!(face_conductance(1.0, 1.0), 1.0);
        // Resistances in series: 1/(1/2 * (1/1 + 1/0.5)) = 2/3.
        assert!((face_conductance(1.0, 0.5) - 2.0 / 3.0).abs() < 1e-7);
    }
}
