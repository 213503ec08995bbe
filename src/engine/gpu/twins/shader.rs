//! Shaders that call one function of a kernel on every element of a buffer.

use crate::gpu::device::Device;
use crate::gpu::kernels::Kernel;
use crate::gpu::wait::wait_for;
use wgpu::naga::front::wgsl;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};
use wgpu::naga::{AddressSpace, ArraySize, Function, Handle, Module, ScalarKind, Type, TypeInner};

/// A shader that calls one function.
pub(super) struct Shader {
    source: String,
    /// The kind of each word that it reads and writes per call.
    pub(super) inputs: Vec<ScalarKind>,
    pub(super) outputs: Vec<ScalarKind>,
}

impl Shader {
    /// Calls the function `name` of a kernel, after setting the fields of its uniform block and the switches `with`.
    pub(super) fn new(kernel: &Kernel, name: &str, with: &[&str]) -> Self {
        let source = kernel.source();
        let module = wgsl::parse_str(&source).expect("tests/backends validates it");
        let mut functions = module.functions.iter().map(|(_, function)| function);
        let function = functions.find(|function| function.name.as_deref() == Some(name));
        let function = function.unwrap_or_else(|| panic!("WGSL has no function {name}"));
        let (mut inputs, mut outputs) = (Vec::new(), Vec::new());
        let arguments = function.arguments.iter();
        let arguments = arguments.map(|argument| read(&module, argument.ty, &mut inputs));
        let arguments = arguments.collect::<Vec<_>>().join(", ");
        let set: String = with
            .iter()
            .map(|name| {
                let (place, ty) = variable(&module, name);
                format!("    {place} = {};\n", read(&module, ty, &mut inputs))
            })
            .collect();
        let result = function.result.as_ref().expect("it returns something");
        let mut written = String::new();
        write(
            &module,
            result.ty,
            "twin_result",
            &mut outputs,
            &mut written,
        );
        let (given, found) = (inputs.len(), outputs.len());
        let called = format!(
            "@group(0) @binding(100) var<storage, read> twin_given: array<u32>;
@group(0) @binding(101) var<storage, read_write> twin_found: array<u32>;
@compute @workgroup_size(64)
fn twin_main(@builtin(global_invocation_id) id: vec3<u32>) {{
    let at = id.x * {given}u;
    if at >= arrayLength(&twin_given) {{
        return;
    }}
    let out = id.x * {found}u;
{set}    let twin_result = {name}({arguments});
{written}}}
"
        );
        Self {
            source: with_variables(&source) + &called,
            inputs,
            outputs,
        }
    }

    /// The results for all of `given`, of which there are `count`.
    pub(super) fn run(&self, device: &Device, given: &[u32], count: usize) -> Vec<u32> {
        let gpu = &device.device;
        let module = gpu.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: None,
            source: wgpu::ShaderSource::Wgsl(self.source.as_str().into()),
        });
        let pipeline = gpu.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: None,
            layout: None,
            module: &module,
            entry_point: Some("twin_main"),
            compilation_options: Default::default(),
            cache: None,
        });
        let buffer = |words: usize, usage| {
            gpu.create_buffer(&wgpu::BufferDescriptor {
                label: None,
                size: 4 * words as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        let read = buffer(given.len(), Usage::STORAGE | Usage::COPY_DST);
        let words = count * self.outputs.len();
        let found = buffer(words, Usage::STORAGE | Usage::COPY_SRC);
        let mapped = buffer(words, Usage::MAP_READ | Usage::COPY_DST);
        device
            .queue
            .write_buffer(&read, 0, bytemuck::cast_slice(given));
        let entries = [(100, &read), (101, &found)].map(|(binding, buffer)| wgpu::BindGroupEntry {
            binding,
            resource: buffer.as_entire_binding(),
        });
        let group = gpu.create_bind_group(&wgpu::BindGroupDescriptor {
            label: None,
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = gpu.create_command_encoder(&Default::default());
        let mut pass = encoder.begin_compute_pass(&Default::default());
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(0, &group, &[]);
        pass.dispatch_workgroups(count.div_ceil(64) as u32, 1, 1);
        drop(pass);
        encoder.copy_buffer_to_buffer(&found, 0, &mapped, 0, None);
        device.queue.submit([encoder.finish()]);
        mapped
            .slice(..)
            .map_async(wgpu::MapMode::Read, |mapped| mapped.expect("it is mapped"));
        wait_for(gpu, None).expect("the device is there");
        let range = mapped.slice(..).get_mapped_range();
        bytemuck::cast_slice(&range.expect("it is mapped")).to_vec()
    }
}

/// The functions of a kernel that depend on their arguments, the uniform block and switches only, and take or return a
/// float.
pub(super) fn formulas(source: &str) -> Vec<String> {
    let module = wgsl::parse_str(source).expect("tests/backends validates it");
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
    let info = validator
        .validate(&module)
        .expect("tests/backends validates it");
    let is_formula = |(handle, function): &(Handle<Function>, &Function)| {
        let mut globals = module.global_variables.iter();
        let is_pure = globals.all(|(global, variable)| {
            variable.space == AddressSpace::Uniform || info[*handle][global].is_empty()
        });
        let mut kinds = Vec::new();
        let arguments = function.arguments.iter().map(|argument| argument.ty);
        for ty in arguments.chain(function.result.iter().map(|result| result.ty)) {
            read(&module, ty, &mut kinds);
        }
        let is_given = !function.arguments.is_empty() && function.result.is_some();
        is_pure && is_given && kinds.contains(&ScalarKind::Float)
    };
    let found = module.functions.iter().filter(is_formula);
    found
        .filter_map(|(_, function)| function.name.clone())
        .collect()
}

/// A kernel whose uniform block and switches are variables.
fn with_variables(source: &str) -> String {
    let lines = source
        .lines()
        .map(|line| match line.split_once("var<uniform>") {
            Some((_, params)) => format!("var<private>{params}\n"),
            None => line.replace("override ", "var<private> ") + "\n",
        });
    lines.collect()
}

/// A field of the uniform block or a switch, and its type.
fn variable(module: &Module, name: &str) -> (String, Handle<Type>) {
    let mut switches = module.overrides.iter().map(|(_, switch)| switch);
    if let Some(switch) = switches.find(|switch| switch.name.as_deref() == Some(name)) {
        return (name.into(), switch.ty);
    }
    let mut globals = module.global_variables.iter().map(|(_, global)| global);
    let params = globals.find(|global| global.space == AddressSpace::Uniform);
    let members = params.map(|params| &module.types[params.ty].inner);
    let Some(TypeInner::Struct { members, .. }) = members else {
        panic!("{name} is no switch, and there are no uniforms");
    };
    let field = members
        .iter()
        .find(|field| field.name.as_deref() == Some(name));
    (format!("params.{name}"), field.expect(name).ty)
}

/// An expression that reads a value from the next words of the input.
fn read(module: &Module, ty: Handle<Type>, words: &mut Vec<ScalarKind>) -> String {
    let mut scalar = |kind| {
        let word = format!("twin_given[at + {}u]", words.len());
        words.push(kind);
        match kind {
            ScalarKind::Float => format!("bitcast<f32>({word})"),
            ScalarKind::Sint => format!("bitcast<i32>({word})"),
            ScalarKind::Bool => format!("({word} != 0u)"),
            _ => word,
        }
    };
    let ty = &module.types[ty];
    match &ty.inner {
        TypeInner::Scalar(own) => scalar(own.kind),
        TypeInner::Vector { size, scalar: own } => {
            let parts: Vec<_> = (0..*size as u32).map(|_| scalar(own.kind)).collect();
            format!("vec{}({})", *size as u32, parts.join(", "))
        }
        TypeInner::Struct { members, .. } => {
            let parts = members.iter().map(|member| read(module, member.ty, words));
            let parts: Vec<_> = parts.collect();
            format!(
                "{}({})",
                ty.name.as_deref().expect("structs have names"),
                parts.join(", ")
            )
        }
        TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            ..
        } => {
            let parts = (0..count.get()).map(|_| read(module, *base, words));
            format!("array({})", parts.collect::<Vec<_>>().join(", "))
        }
        // Pointers: the function is no formula.
        _ => String::new(),
    }
}

/// Statements that write the value of an expression to the next words of the output.
fn write(
    module: &Module,
    ty: Handle<Type>,
    value: &str,
    words: &mut Vec<ScalarKind>,
    written: &mut String,
) {
    let mut scalar = |kind, value: &str| {
        let bits = match kind {
            ScalarKind::Bool => format!("u32({value})"),
            _ => format!("bitcast<u32>({value})"),
        };
        *written += &format!("    twin_found[out + {}u] = {bits};\n", words.len());
        words.push(kind);
    };
    match &module.types[ty].inner {
        TypeInner::Scalar(own) => scalar(own.kind, value),
        TypeInner::Vector { size, scalar: own } => {
            (0..*size as u32).for_each(|i| scalar(own.kind, &format!("{value}[{i}]")));
        }
        TypeInner::Struct { members, .. } => members.iter().for_each(|member| {
            let name = member.name.as_deref().expect("members have names");
            write(
                module,
                member.ty,
                &format!("{value}.{name}"),
                words,
                written,
            );
        }),
        TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            ..
        } => {
            (0..count.get())
                .for_each(|i| write(module, *base, &format!("{value}[{i}]"), words, written));
        }
        other => panic!("a result of {other:?}"),
    }
}
