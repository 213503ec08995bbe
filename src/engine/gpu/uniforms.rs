//! Uniform blocks shared by Rust and WGSL.

/// A struct of numbers of 32 bits, in the order in which WGSL lays them out.
pub(crate) trait Uniforms {
    /// The definition in WGSL.
    const WGSL: &'static str;

    /// The numbers, one after the other.
    fn bytes(&self) -> Vec<u8>;
}

/// Defines structs for both languages. Their fields are `f32`, `u32` or `i32`.
macro_rules! uniforms {
    ($($(#[$doc:meta])* $name:ident { $($(#[$field_doc:meta])* $field:ident: $kind:ident,)* })*) => {
        $(
            $(#[$doc])*
            #[derive(Debug, Clone, Copy)]
            pub(crate) struct $name {
                $($(#[$field_doc])* pub(crate) $field: $kind,)*
            }

            impl Uniforms for $name {
                const WGSL: &'static str = concat!(
                    "struct ", stringify!($name), " {\n",
                    $("    ", stringify!($field), ": ", stringify!($kind), ",\n",)*
                    "}\n",
                );

                fn bytes(&self) -> Vec<u8> {
                    let mut bytes = Vec::new();
                    $(bytes.extend(self.$field.to_ne_bytes());)*
                    bytes
                }
            }
        )*
    };
}

uniforms! {
    /// Of kernels that are told nothing but the size of the picture.
    SizeParams {
        width: u32,
        height: u32,
    }

    /// Of `edges.wgsl`.
    EdgeParams {
        width: u32,
        height: u32,
        silhouette_lo: f32,
        silhouette_hi: f32,
        /// Angles in radians.
        crease_lo: f32,
        crease_hi: f32,
        /// Above this length a filtered normal surely hides no crease.
        flat_length: f32,
        foreshortening: f32,
        min_nz: f32,
        /// The direction to the eye, scaled to z = 1: at the first column and row, and what each further one adds.
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
    }

    /// Of `cracks.wgsl`.
    CrackParams {
        width: u32,
        height: u32,
        /// Jumps up to this are none.
        least_jump: f32,
        /// The direction to the eye, scaled to z = 1: at the first column and row, and what each further one adds.
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
        /// What each further column and row adds to where parallel sight lines begin.
        start_x_step: f32,
        start_y_step: f32,
    }

    /// Of `diffusion.wgsl` and `sweep.wgsl`.
    DiffusionParams {
        width: u32,
        height: u32,
        /// Sweeps of this pass.
        sweeps: u32,
        /// Number of the term it starts from.
        first_term: u32,
        /// 1 where no pass follows.
        is_final: u32,
        /// Levels of importance that have weights of their own.
        level_count: u32,
        /// Length of an explicit step.
        time_step: f32,
    }

    /// Of `hessian.wgsl`.
    HessianParams {
        width: u32,
        height: u32,
        /// Pixels that stand for one of the reference.
        resolution_factor: f32,
    }

    /// Of `count.wgsl`.
    CountParams {
        width: u32,
        height: u32,
        rows_start: u32,
        rows_end: u32,
        /// Mask of the bits found so far, and where the next ones begin.
        known_bits: u32,
        shift: u32,
        /// Traces up to this have no say.
        least: f32,
        /// Weights of luminance.
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
    }

    /// Of `narrow.wgsl`.
    NarrowParams {
        is_first: u32,
        shift: u32,
        /// The percentile as a fraction.
        share: u32,
        share_of: u32,
        /// What the gain times the percentile of curvature is to be.
        target_times: f32,
    }

    /// Of `relight.wgsl`.
    LightParams {
        width: u32,
        height: u32,
        /// Lights that stand for an environment, even directions it is looked up in, lights from one direction, and
        /// lights at a point.
        around_count: u32,
        even_count: u32,
        direction_count: u32,
        point_count: u32,
        /// Intensity that radiance of 1 has from each even direction.
        even_share: f32,
        /// The direction to the eye, scaled to z = 1: at the first column and row, and what each further one adds.
        to_eye_x: f32,
        to_eye_x_step: f32,
        to_eye_y: f32,
        to_eye_y_step: f32,
        /// Where parallel sight lines begin, likewise.
        start_x: f32,
        start_x_step: f32,
        start_y: f32,
        start_y_step: f32,
        /// Whether depth counts along sight lines, and not along the view axis.
        depth_along_ray: u32,
        ambient: f32,
        diffuse_gain: f32,
        specular_gain: f32,
        /// The power of the lobe, where it is whole, else 0; and where it is not.
        whole_power: u32,
        power: f32,
        coat_along: f32,
        coat_across: f32,
        coat_normalisation: f32,
        reflectance: f32,
        /// The direction of the grain in the picture.
        grain_x: f32,
        grain_y: f32,
        ior: f32,
        is_thin: u32,
        /// Strength of the warp, before the gain.
        warp: f32,
        contrast: f32,
        invariant_point: f32,
        anisotropy: f32,
        ambient_magnitude: f32,
        diffuse_magnitude: f32,
        specular_magnitude: f32,
        /// Weights of luminance.
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
        tone_levels: f32,
        tone_softness: f32,
        environment_gain: f32,
        /// The factor of a map that was prefiltered by a highlight.
        map_lobe: f32,
        /// What is looked up: size, rotation in turns, the luminance that counts as intensity 1.
        map_width: u32,
        map_height: u32,
        map_turn: f32,
        map_largest: f32,
        second_width: u32,
        second_height: u32,
        second_turn: f32,
        second_largest: f32,
        /// A NaN, which no kernel may spell.
        nan_bits: u32,
    }

    /// Of `scale_picture.wgsl` and `scale_by_gradient.wgsl`.
    ScaleParams {
        width: u32,
        height: u32,
        /// Pixels that stand for one of the reference.
        resolution_factor: f32,
        scaling: f32,
        invariant_point: f32,
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
        /// A NaN, which no kernel may spell.
        nan_bits: u32,
    }

    /// Of the kernels that scale a term of the light.
    TermParams {
        width: u32,
        height: u32,
        /// Magnitude gamma, and the invariant point alpha.
        magnitude: f32,
        invariant_point: f32,
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
        anisotropy: f32,
        /// Directions of a light group.
        light_count: u32,
    }

    /// Of `density.wgsl`.
    DensityParams {
        width: u32,
        height: u32,
        weight_r: f32,
        weight_g: f32,
        weight_b: f32,
    }

    /// Of `normal_rays.wgsl`.
    RayParams {
        width: u32,
        height: u32,
        /// The direction of sight lines, scaled to z = -1: at the first column and row, and what each further one adds.
        line_x: f32,
        line_x_step: f32,
        line_y: f32,
        line_y_step: f32,
        /// How far apart the starts of sight lines are that are a pixel apart, and points at a depth of 1 on them.
        start_x_step: f32,
        start_y_step: f32,
        apart_x_step: f32,
        apart_y_step: f32,
        /// Height of a pixel over its width.
        pixel_shape: f32,
        /// Deviations of a component of a normal, and of a point as a share of its depth.
        normal_noise: f32,
        offset_noise: f32,
        /// The least and the greatest step, in pixels.
        first_step: i32,
        most_step: i32,
    }

    /// Of `spread_directions.wgsl`.
    SpreadParams {
        width: u32,
        height: u32,
        /// The direction of sight lines, scaled to z = -1: at the first column and row, and what each further one adds.
        line_x: f32,
        line_x_step: f32,
        line_y: f32,
        line_y_step: f32,
        /// Height of a pixel over its width.
        pixel_shape: f32,
        /// Number of the wave, from 1 on.
        wave: u32,
        /// Where the length of its list stands, and that of the next one's.
        list_count: u32,
        next_count: u32,
        /// How far directions turn to the fallback, 0..1: on planes, and elsewhere.
        flat_share: f32,
        share: f32,
        /// Which fallback, as in the field of stroke directions.
        order: u32,
        is_fixed: u32,
        fixed_x: f32,
        fixed_y: f32,
    }

    /// Of the kernels of the field of stroke directions.
    DirectionParams {
        width: u32,
        height: u32,
        /// Pixels along the side of a cell, and how many of the first one lie before the picture.
        cell_px: u32,
        cut_x: u32,
        cut_y: u32,
        columns: u32,
        rows: u32,
        /// Room for patches after the first one of each cell.
        room: u32,
        /// Of kernels that go along one axis: 0 across, 1 down.
        axis: u32,
        /// How far a mean reaches, in cells.
        reach: f32,
        /// The direction of sight lines, scaled to z = -1: at the first column and row, and what each further one adds.
        line_x: f32,
        line_x_step: f32,
        line_y: f32,
        line_y_step: f32,
        /// How far apart points at a depth of 1 are that are a pixel apart.
        apart_x_step: f32,
        apart_y_step: f32,
        /// Height of a pixel over its width.
        pixel_shape: f32,
        /// From curvature per unit of length to that per pixel.
        per_pixel: f32,
        /// Turn of normals per pixel that counts half.
        doubt: f32,
        /// 0 for the curvature larger in size, 1 for the other.
        family: u32,
        /// Number of the field, in the order in which they are made.
        order: u32,
        is_fixed: u32,
        fixed_x: f32,
        fixed_y: f32,
    }

    /// Of `hatching.wgsl`.
    StrokeParams {
        width: u32,
        height: u32,
        /// Where the middle of the first pixel lies in a texture that lies still.
        first_x: f32,
        first_y: f32,
        levels: u32,
        levels_per_radian: f32,
        sets: u32,
        /// 1 over the sets.
        share_of_set: f32,
        /// Number of the family, and how many there are.
        family: u32,
        families: u32,
        texture_width: u32,
        texture_height: u32,
        /// Slices of a texture of pictures.
        slices: u32,
    }

    /// Of `line_coverage.wgsl`.
    LineCoverageParams {
        width: u32,
        height: u32,
        /// Coordinates of the first pixel.
        x0: i32,
        y0: i32,
        /// How many rows of the picture come before.
        top: u32,
        /// Of the grain, where there is any.
        seed_low: u32,
        seed_high: u32,
    }
}
