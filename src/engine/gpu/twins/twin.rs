//! A scalar function of WGSL and its namesake in Rust.

use super::super::kernels::Kernel;
use super::words::Namesake;

/// A function from words to words.
type FromWords = Box<dyn Fn(&[u32], &mut Vec<u32>) + Send + Sync>;

/// A scalar function of WGSL and its Rust namesake.
pub(super) struct Twin {
    pub(super) name: &'static str,
    /// A kernel that contains it.
    pub(super) kernel: &'static Kernel,
    /// The namesake, from words to words.
    pub(super) rust: FromWords,
    /// Fields of the uniform block and switches passed after the arguments.
    pub(super) with: &'static [&'static str],
    /// Maps inputs into the function's domain.
    pub(super) domain: fn(&mut [u32]),
    pub(super) tolerance: Tolerance,
}

/// Allowed difference between twins.
#[derive(Clone, Copy)]
pub(super) enum Tolerance {
    /// None: both do the same f32 operations in the same order.
    Exact,
    /// At most this many f32 steps.
    Ulps(u32),
    Absolute(f32),
}

impl Twin {
    pub(super) fn new<A>(
        name: &'static str,
        path: &str,
        kernel: &'static Kernel,
        rust: impl Namesake<A> + Send + Sync + 'static,
    ) -> Self {
        assert!(is_namesake(name, path), "{name} is no name for {path}");
        Self {
            name,
            kernel,
            rust: Box::new(move |words, out| rust.run(&mut words.iter().copied(), out)),
            with: &[],
            domain: |_| {},
            tolerance: Tolerance::Exact,
        }
    }

    /// Passes fields of the uniform block and switches to both functions.
    pub(super) fn with(mut self, names: &'static [&'static str]) -> Self {
        self.with = names;
        self
    }

    pub(super) fn on(mut self, domain: fn(&mut [u32])) -> Self {
        self.domain = domain;
        self
    }

    pub(super) fn within(mut self, tolerance: Tolerance) -> Self {
        self.tolerance = tolerance;
        self
    }
}

/// WGSL built-ins with implementation-defined precision: the twin's name ends in `_of`.
const BUILT_IN: [&str; 5] = ["exp", "tanh", "atan", "atan2", "mix"];

/// Whether a WGSL function has the name of the Rust function at a path.
fn is_namesake(wgsl: &str, path: &str) -> bool {
    // What may fuse multiply-adds is compared without.
    let path = path
        .replace(' ', "")
        .replace("::<false>", "")
        .replace("::<", "<");
    let mut parts = path.rsplit("::");
    let name = parts.next().unwrap_or_default();
    if let Some((name, _)) = name.split_once('<') {
        // Generic over coefficients, whose name is the suffix.
        return wgsl
            .strip_prefix(name)
            .is_some_and(|rest| rest.starts_with('_'));
    }
    if BUILT_IN.contains(&name) {
        return wgsl.strip_suffix("_of") == Some(name);
    }
    let mut with_type = String::new();
    for c in parts.next().unwrap_or_default().chars() {
        if c.is_uppercase() && !with_type.is_empty() {
            with_type.push('_');
        }
        with_type.extend(c.to_lowercase());
    }
    wgsl == name || wgsl == format!("{with_type}_{name}")
}
