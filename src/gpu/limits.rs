//! Device limits that the kernels need, and the largest picture they allow.

use crate::gpu::constants::{GROUP, REGION, REGION_GROUP_ROWS, SWEEPS_PER_PASS};

/// Maximum number of storage buffers of a kernel.
const STORAGE_BUFFERS: u32 = 16;

/// Largest size of a uniform block, in bytes.
const TOLD_BYTES: u32 = 272;

/// Bytes of the region held by a diffusion workgroup: vectors of two.
const REGION_BYTES: u32 = 8 * REGION[0] * REGION[1];

/// Kernels index pixels and samples in 32 bits.
const MOST_PLANE_BYTES: u64 = u32::MAX as u64;

/// Features to request, if the adapter has them: a clock. Kernels compute in `f32` and `u32` only.
pub(crate) fn wanted_features(available: wgpu::Features) -> wgpu::Features {
    available & wgpu::Features::TIMESTAMP_QUERY
}

/// A device limit and the value that the kernels need.
struct Need {
    what: &'static str,
    /// The device's value.
    has: fn(&wgpu::Limits) -> u64,
    needed: u64,
}

fn needs() -> [Need; 9] {
    let need = |what, needed: u32, has| Need {
        what,
        has,
        needed: needed.into(),
    };
    let group_rows = GROUP[1].max(REGION_GROUP_ROWS);
    let invocations = [GROUP[0] * GROUP[1], REGION[0] * REGION_GROUP_ROWS];
    [
        need("storage buffers at a time", STORAGE_BUFFERS, |l| {
            l.max_storage_buffers_per_shader_stage.into()
        }),
        need("uniform buffers at a time", 1, |l| {
            l.max_uniform_buffers_per_shader_stage.into()
        }),
        need("bindings of a group", STORAGE_BUFFERS + 1, |l| {
            l.max_bindings_per_bind_group.into()
        }),
        need("groups of bindings", 1, |l| l.max_bind_groups.into()),
        need("bytes of a uniform buffer", TOLD_BYTES, |l| {
            l.max_uniform_buffer_binding_size
        }),
        need("columns of a workgroup", GROUP[0].max(REGION[0]), |l| {
            l.max_compute_workgroup_size_x.into()
        }),
        need("rows of a workgroup", group_rows, |l| {
            l.max_compute_workgroup_size_y.into()
        }),
        need(
            "invocations of a workgroup",
            invocations[0].max(invocations[1]),
            |l| l.max_compute_invocations_per_workgroup.into(),
        ),
        need("bytes of workgroup memory", REGION_BYTES, |l| {
            l.max_compute_workgroup_storage_size.into()
        }),
    ]
}

/// The first requirement of the kernels that a device with these limits does not meet.
pub(crate) fn lacking(limits: &wgpu::Limits) -> Option<String> {
    needs().into_iter().find_map(|Need { what, has, needed }| {
        let has = has(limits);
        (has < needed).then(|| format!("takes {has} {what}, and {needed} are needed"))
    })
}

/// Maximum number of bytes of a plane.
pub(crate) fn plane_bytes(limits: &wgpu::Limits) -> u64 {
    limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size)
        .min(MOST_PLANE_BYTES)
}

/// Largest picture, in columns and rows, for this many workgroups per side.
pub(crate) fn most_pixels(groups: u32) -> [u64; 2] {
    // Among kernels that write pixels, diffusion workgroups cover the fewest columns.
    let columns = GROUP[0].min(REGION[0] - 2 * SWEEPS_PER_PASS as u32);
    let rows = GROUP[1].min(REGION[1] - 2 * SWEEPS_PER_PASS as u32);
    [columns, rows].map(|pixels| u64::from(pixels) * u64::from(groups))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stages::kernels::kernel_sources;
    use wgpu::Limits;
    use wgpu::naga::front::wgsl;
    use wgpu::naga::proc::Layouter;
    use wgpu::naga::{AddressSpace, Module};

    /// Exactly the limits that the kernels need.
    fn enough() -> Limits {
        Limits {
            max_storage_buffers_per_shader_stage: STORAGE_BUFFERS,
            ..Limits::default()
        }
    }

    #[test]
    fn the_limits_that_every_device_has_are_enough_but_for_the_number_of_buffers() {
        assert_eq!(lacking(&enough()), None);
    }

    #[test]
    fn what_a_device_lacks_is_named() {
        type Change = fn(&mut Limits);
        let table: [(&str, Change); 9] = [
            ("takes 8 storage buffers", |l| {
                l.max_storage_buffers_per_shader_stage = 8;
            }),
            ("takes 0 uniform buffers", |l| {
                l.max_uniform_buffers_per_shader_stage = 0;
            }),
            ("takes 10 bindings", |l| l.max_bindings_per_bind_group = 10),
            ("takes 0 groups of bindings", |l| l.max_bind_groups = 0),
            ("takes 64 bytes of a uniform", |l| {
                l.max_uniform_buffer_binding_size = 64;
            }),
            ("takes 32 columns", |l| l.max_compute_workgroup_size_x = 32),
            ("takes 2 rows", |l| l.max_compute_workgroup_size_y = 2),
            ("takes 128 invocations", |l| {
                l.max_compute_invocations_per_workgroup = 128;
            }),
            ("takes 16352 bytes of workgroup", |l| {
                l.max_compute_workgroup_storage_size = 16352;
            }),
        ];
        for (expected, change) in table {
            let mut limits = enough();
            change(&mut limits);
            let found = lacking(&limits).expect(expected);
            assert!(found.starts_with(expected), "{found}, not {expected}");
            assert!(found.contains("are needed"), "{found}");
        }
    }

    #[test]
    fn planes_are_as_large_as_bindings_buffers_and_indices_are() {
        let with = |binding, buffer| Limits {
            max_storage_buffer_binding_size: binding,
            max_buffer_size: buffer,
            ..Limits::default()
        };
        assert_eq!(plane_bytes(&with(128 << 20, 1 << 31)), 128 << 20);
        assert_eq!(plane_bytes(&with(1 << 31, 1 << 28)), 1 << 28);
        assert_eq!(plane_bytes(&with(1 << 40, 1 << 40)), MOST_PLANE_BYTES);
    }

    #[test]
    fn a_clock_is_all_that_is_asked_for() {
        assert_eq!(
            wanted_features(wgpu::Features::all()),
            wgpu::Features::TIMESTAMP_QUERY
        );
        let none = wgpu::Features::empty();
        assert_eq!(wanted_features(none), none);
    }

    #[test]
    fn pictures_end_where_workgroups_do() {
        // 64 - 2 * 6 columns and 4 rows per workgroup.
        assert_eq!(most_pixels(65_535), [52 * 65_535, 4 * 65_535]);
    }

    /// The requirements cover every kernel.
    #[test]
    fn no_kernel_takes_more_than_is_asked_for() {
        for (name, source) in kernel_sources() {
            let module = wgsl::parse_str(&source).unwrap();
            let globals = module.global_variables.iter();
            let buffers = globals.filter(|(_, g)| matches!(g.space, AddressSpace::Storage { .. }));
            let [columns, rows, layers] = module.entry_points[0].workgroup_size;
            assert_eq!(layers, 1, "{name}");
            let taken = [
                ("storage buffers", buffers.count() as u64),
                ("bytes of a uniform", bytes(&module, AddressSpace::Uniform)),
                ("columns", columns.into()),
                ("rows", rows.into()),
                ("invocations", (columns * rows).into()),
                (
                    "bytes of workgroup",
                    bytes(&module, AddressSpace::WorkGroup),
                ),
            ];
            for (what, takes) in taken {
                let all = needs();
                let need = all.iter().find(|need| need.what.starts_with(what));
                let needed = need.expect(what).needed;
                assert!(takes <= needed, "{name}: {takes} {what}, not {needed}");
            }
        }
    }

    /// Bytes of all globals of a module in this address space.
    fn bytes(module: &Module, space: AddressSpace) -> u64 {
        let mut layouter = Layouter::default();
        layouter.update(module.to_ctx()).unwrap();
        let globals = module.global_variables.iter();
        let globals = globals.filter(|(_, global)| global.space == space);
        globals.map(|(_, g)| u64::from(layouter[g.ty].size)).sum()
    }
}
