//! The buffers of each kernel, by the names that its WGSL gives them.

/// Buffers with the names of the variables they are bound to.
pub(crate) trait Bindings {
    fn named(&self) -> Vec<(&'static str, &wgpu::Buffer)>;
}

/// Defines a struct for each kernel.
macro_rules! bindings {
    ($($kernel:ident { $($buffer:ident),* })*) => {
        $(
            pub(super) struct $kernel<'b> {
                $(pub(super) $buffer: &'b wgpu::Buffer,)*
            }

            impl Bindings for $kernel<'_> {
                fn named(&self) -> Vec<(&'static str, &wgpu::Buffer)> {
                    vec![$((stringify!($buffer), self.$buffer)),*]
                }
            }
        )*

        /// The names of each, by kernel.
        #[cfg(test)]
        const NAMES: &[(&str, &[&str])] = &[$((stringify!($kernel), &[$(stringify!($buffer)),*])),*];
    };
}

bindings! {
    LogDepth { covered, depth, log_depth }
    Edges { covered, normal_x, normal_y, normal_z, silhouette_map, normal_length, conductance, gradient, weights }
    EdgeLists { weights, counts, candidates, creases }
    Cracks { covered, silhouette_map, normal_x, normal_y, normal_z, counts, candidates, cracks }
    Diffusion { last, earlier, conductance, term_weights, levels, covered, next_last, next_earlier, sums }
    Faces { conductance, faces }
    Sweep { last, faces, term_weights, levels, next, sums }
    Hessian { covered, conductance, gradient, trace, hessian_xx, hessian_xy, hessian_yy }
    Curvatures { covered, hessian_xx, hessian_xy, hessian_yy, chosen, curvature, direction }
    Count { covered, a, b, c, search, bins }
    Narrow { bins, search, chosen }
    ScalePicture { covered, trace, chosen, red, green, blue }
    ScaleByGradient { covered, conductance, gradient, chosen, red, green, blue }
    LobeLuminance { covered, direct, indirect, albedo, luminance }
    LobeSigma { covered, direct, indirect, albedo, trace, chosen, term_chosen, sigma }
    GroupSigma {
        covered, normal_x, normal_y, normal_z, curvature_xx, curvature_xy, curvature_yy, chosen, to_light, sigma
    }
    AddChange { sigma, direct, indirect, color, change, told }
    ChangePicture { covered, change, told, red, green, blue }
    Occlude { covered, trace, occlusion, chosen, red, green, blue }
    CurvatureDisplay { covered, conductance, trace, chosen, red, green, blue }
    NormalRays {
        covered, conductance, normal_x, normal_y, normal_z, depth, direction_x, direction_y, filled, marks, open,
        closed, counts
    }
    SpreadDirections {
        conductance, normal_x, normal_y, normal_z, list, next, counts, direction_x, direction_y, filled, marks
    }
    FindPatches { conductance, normal_x, normal_y, normal_z, depth, held, patches, depths, further }
    LinkPatches { held, patches, links }
    FindRuns { held, links, runs }
    SumRuns { held, links, values, sums }
    ChainMeans {
        held, further, patches, links, runs_across, runs_down, sums_across, sums_down, depths, chosen, values, means
    }
    PatchForms { held, further, patches, links, forms }
    PatchDirections { held, further, patches, forms, directions }
    SettlePatches { held, further, patches, links, own, around, settled }
    BetweenPatches {
        covered, held, patches, links, settled, direction_x, direction_y, filled, marks, lacking, counts
    }
    Density { covered, red, green, blue, alpha, chosen, density_table, densities }
    Strokes {
        covered, densities, direction_x, direction_y, thresholds, turned, texels, paper, place_x, place_y, depth,
        motion_x, motion_y, shares
    }
    LineCoverage { covered, tile_starts, tile_pieces, pieces, lines, covered_by_lines }
    Relight {
        covered, normal_x, normal_y, normal_z, hessian_xx, hessian_xy, hessian_yy, chosen, occlusion, alpha, depth,
        lights, texels, red, green, blue
    }
}

#[cfg(test)]
mod tests {
    use super::super::kernels::Kernel;
    use super::NAMES;

    #[test]
    fn every_kernel_has_the_buffers_of_its_wgsl() {
        for kernel in Kernel::ALL {
            // Both kinds of strokes take the same.
            let of = match kernel {
                Kernel::PictureStrokes => Kernel::Strokes,
                kernel => kernel,
            };
            let name = format!("{of:?}");
            let declared = NAMES.iter().find(|(declared, _)| *declared == name);
            let (_, declared) = declared.unwrap_or_else(|| panic!("{name} has no bindings"));
            let mut declared: Vec<String> = declared.iter().map(|&name| name.into()).collect();
            let mut bound = kernel.bindings();
            assert_eq!(
                bound.remove(0),
                "params",
                "{kernel:?} is given its uniform block first"
            );
            declared.sort();
            bound.sort();
            assert_eq!(declared, bound, "{kernel:?}");
        }
    }
}
