//! Row kernels compiled for wider vectors than the baseline has, chosen at run time.
//!
//! The kernels are the ones of [`crate::shape`]: the compiler makes wider code of the same loops. It
//! neither reorders nor contracts floating-point operations, so every level gives the same bits.
#![allow(
    unsafe_code,
    reason = "calling a function compiled for features that were just detected"
)]

use super::light::{Scaler, scale_row};
use crate::params::{ShapeParams, SoftThreshold};
use crate::shape::Rows;
use crate::shape::conductance::{conductance_row, face_conductance_row};
use crate::shape::crease::{NormalRows, least_cosine_row};
use crate::shape::diffusion::{
    Faces, LEVELS, Stencil, Update, add_terms_by_level_row, add_terms_row, sweep_row,
};
use crate::shape::gradient::depth_gradient_row;
use crate::shape::hessian::{hessian_row, trace_row};
use crate::shape::silhouette::{border_row, log_depth_row, silhouette_row};
use std::ops::Range;

/// Vectors that this machine has. Only [`Simd::available`] makes one, of features it has found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Simd(Level);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    /// What every machine of the target has.
    Baseline,
    /// 256 bits.
    #[cfg(target_arch = "x86_64")]
    Avx2,
    /// 512 bits.
    #[cfg(target_arch = "x86_64")]
    Avx512,
}

impl Simd {
    /// All that this machine has, the widest last.
    pub(super) fn available() -> Vec<Self> {
        let mut levels = vec![Self(Level::Baseline)];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") {
                levels.push(Self(Level::Avx2));
            }
            if is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("avx512bw")
                && is_x86_feature_detected!("avx512dq")
            {
                levels.push(Self(Level::Avx512));
            }
        }
        levels
    }

    /// The widest that this machine has.
    pub(super) fn widest() -> Self {
        *Self::available()
            .last()
            .expect("the baseline is always there")
    }
}

/// Methods of [`Simd`] that call a kernel as compiled for its level.
macro_rules! widened {
    ($(fn $name:ident($($arg:ident: $type:ty),* $(,)?);)*) => {
        impl Simd {$(
            #[inline]
            pub(super) fn $name(self, $($arg: $type),*) {
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx2")]
                fn avx2($($arg: $type),*) {
                    $name($($arg),*)
                }
                #[cfg(target_arch = "x86_64")]
                #[target_feature(enable = "avx512f,avx512vl,avx512bw,avx512dq")]
                fn avx512($($arg: $type),*) {
                    $name($($arg),*)
                }
                match self.0 {
                    Level::Baseline => $name($($arg),*),
                    // SAFETY: only `available` makes this level, where it found the features.
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx2 => unsafe { avx2($($arg),*) },
                    // SAFETY: as above.
                    #[cfg(target_arch = "x86_64")]
                    Level::Avx512 => unsafe { avx512($($arg),*) },
                }
            }
        )*}
    };
}

widened! {
    fn sweep_row(out: [&mut [f32]; 2], g: [Stencil; 2], faces: Faces, update: Update);
    fn add_terms_row(sum: &mut [f32], terms: [&[f32]; 2], weights: [f32; 2]);
    fn add_terms_by_level_row(
        sum: [&mut [f32]; 2],
        terms: [[&[f32]; 2]; 2],
        levels: &[u16],
        weights: [&[f32; LEVELS]; 2],
    );
    fn face_conductance_row(faces: &mut [f32], a: &[f32], b: &[f32]);
    fn log_depth_row(out: &mut [f32], depth: &[f32], covered: &[bool]);
    fn silhouette_row(
        weight: &mut [f32],
        map: &Rows,
        covered: &Rows<bool>,
        columns: Range<usize>,
        threshold: SoftThreshold,
    );
    fn border_row(weight: &mut [f32], covered: &Rows<bool>, columns: Range<usize>);
    fn least_cosine_row(
        out: &mut [f32],
        normals: &NormalRows,
        covered: &Rows<bool>,
        columns: Range<usize>,
    );
    fn conductance_row(out: &mut [f32], silhouette: &[f32], crease: &[f32], covered: &[bool]);
    fn depth_gradient_row(
        out: [&mut [f32]; 2],
        normal: [&[f32]; 3],
        covered: &[bool],
        to_eye: (&[f32], f32),
        params: &ShapeParams,
    );
    fn hessian_row(
        out: [&mut [f32]; 3],
        gx: &Rows,
        gy: &Rows,
        conductance: &Rows,
        columns: Range<usize>,
    );
    fn trace_row(
        trace: &mut [f32],
        gx: &Rows,
        gy: &Rows,
        conductance: &Rows,
        columns: Range<usize>,
    );
    fn scale_row(
        scaler: &Scaler,
        out: [&mut [f32]; 3],
        from: [&[f32]; 3],
        trace: &[f32],
        covered: &[bool],
    );
}
