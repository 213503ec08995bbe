//! Every formula in WGSL has a Rust twin of the same name, and both give the same bits.
//!
//! A *scalar function* depends on its arguments, the uniform block and switches only, and takes or returns a float. It
//! has a twin in [`table`]: the Rust function of the same name; a method `Type::name` is `type_name` in WGSL. Functions
//! that access storage, workgroup or private memory are orchestration, and those of integers only are addressing: they
//! differ between backends, and `tests/backends` compares their pictures.
//!
//! Both twins get the same values: random ones, hostile ones, and the thresholds of the function with their neighbours.
//! The results must be equal, with all NaNs identified and both zeros identified, unless an entry of the table states
//! why not.
//!
//! This runs only with the feature `gpu`, which brings the kernels and naga, the parser of WGSL.

mod arithmetic;
mod domains;
mod interpreter;
mod table;
mod twin;
mod values;
mod words;

use super::all_kernels;
use interpreter::{Machine, Program, Signature};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use table::twins;
use twin::{Tolerance, Twin};
use values::Values;
use wgpu::naga::ScalarKind;
use words::UNSPECIFIED;

/// Values tested per pair.
const SAMPLES: u32 = 100_000;

#[test]
fn every_scalar_function_has_its_twin() {
    let lacking = lacking(&twins());
    assert!(lacking.is_empty(), "WGSL without a namesake: {lacking:#?}");
}

#[test]
fn twins_agree_on_random_and_hostile_values() {
    let failures: Vec<String> = twins().par_iter().filter_map(first_difference).collect();
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}

#[test]
fn a_missing_twin_and_a_wrong_one_are_found() {
    let mut all = twins();
    let place = all.iter().position(|twin| twin.name == "scale_factor");
    let mut wrong = all.swap_remove(place.expect("it has a twin"));
    assert_eq!(lacking(&all), BTreeSet::from(["scale_factor".to_owned()]));
    let right = std::mem::replace(&mut wrong.rust, Box::new(|_, _| {}));
    // The sign of zero makes no difference; the next number is one ulp apart.
    wrong.rust = Box::new(move |words, out| {
        right(words, out);
        out[0] += u32::from(f32::from_bits(words[0]) == f32::MIN_POSITIVE);
    });
    assert!(first_difference(&wrong).is_some());
}

/// The scalar functions of WGSL without a twin in `twins`.
fn lacking(twins: &[Twin]) -> BTreeSet<String> {
    let known: BTreeMap<&str, String> = twins
        .iter()
        .map(|twin| {
            let program = Program::new(twin.kernel.source());
            (twin.name, find(&program, twin.name).text.into())
        })
        .collect();
    let mut lacking = BTreeSet::new();
    for kernel in all_kernels::ALL {
        for function in Program::new(kernel.source()).scalar_functions() {
            let is_known = known.get(function.name).map(String::as_str) == Some(function.text);
            if is_formula(&function) && !is_known {
                lacking.insert(function.name.to_owned());
            }
        }
    }
    lacking
}

fn find<'a>(program: &'a Program, name: &str) -> Signature<'a> {
    let found = program.scalar_functions().find(|f| f.name == name);
    found.unwrap_or_else(|| panic!("WGSL has no scalar function {name}"))
}

/// Whether it takes arguments, and floats occur in its arguments or result.
fn is_formula(function: &Signature) -> bool {
    let mut kinds = function.arguments.iter().chain(&function.result);
    !function.arguments.is_empty() && kinds.any(|&kind| kind == ScalarKind::Float)
}

/// The first values on which twins differ by more than their tolerance.
fn first_difference(twin: &Twin) -> Option<String> {
    let program = Program::new(twin.kernel.source());
    let function = find(&program, twin.name);
    let mut machine = Machine::new(&program);
    let mut values = Values::new(twin.name, program.numbers(&function));
    let fields = program.fields();
    let switches: Vec<&str> = program.switches().collect();
    let more: Vec<Source> = twin
        .with
        .iter()
        .map(|name| match fields.iter().position(|(f, _)| f == name) {
            Some(place) => Source::Uniform(place, fields[place].1),
            None => Source::Switch(name),
        })
        .collect();
    let kinds: Vec<ScalarKind> = function
        .arguments
        .iter()
        .copied()
        .chain(more.iter().map(Source::kind))
        .collect();
    let (mut words, mut own) = (Vec::new(), Vec::new());
    for _ in 0..SAMPLES {
        for (word, (_, kind)) in machine.params().iter_mut().zip(&fields) {
            *word = values.next(*kind);
        }
        for name in &switches {
            machine.set_switch(name, values.next(ScalarKind::Bool) != 0);
        }
        values.fill(&mut words, &kinds);
        (twin.domain)(&mut words);
        let (arguments, rest) = words.split_at(function.arguments.len());
        for (source, &word) in more.iter().zip(rest) {
            match source {
                Source::Uniform(place, _) => machine.params()[*place] = word,
                Source::Switch(name) => machine.set_switch(name, word != 0),
            }
        }
        own.clear();
        (twin.rust)(&words, &mut own);
        let found = machine.call(&function, arguments);
        assert_eq!(own.len(), found.len(), "the result of {}", twin.name);
        let mut pairs = own.iter().zip(found).zip(&function.result);
        if !pairs.all(|((&a, &b), &kind)| twin.tolerance.allows(kind, a, b)) {
            let shown = |words: &[u32], kinds: &[ScalarKind]| {
                let all = words.iter().zip(kinds);
                let all = all.map(|(&word, &kind)| shown(kind, word));
                all.collect::<Vec<_>>().join(", ")
            };
            return Some(format!(
                "{} of {}\n  Rust gives {}\n  WGSL gives {}",
                twin.name,
                shown(&words, &kinds),
                shown(&own, &function.result),
                shown(found, &function.result),
            ));
        }
    }
    None
}

/// Source of an input that is not an argument.
enum Source<'a> {
    Uniform(usize, ScalarKind),
    Switch(&'a str),
}

impl Source<'_> {
    fn kind(&self) -> ScalarKind {
        match self {
            Self::Uniform(_, kind) => *kind,
            Self::Switch(_) => ScalarKind::Bool,
        }
    }
}

impl Tolerance {
    fn allows(&self, kind: ScalarKind, a: u32, b: u32) -> bool {
        if kind != ScalarKind::Float {
            return a == b;
        }
        let (x, y) = (f32::from_bits(a), f32::from_bits(b));
        if x.is_nan() && y.is_nan() || x == y || a == UNSPECIFIED.to_bits() {
            return true;
        }
        match *self {
            Self::Exact => false,
            Self::Ulps(most) => ulps_between(x, y) <= most,
            Self::Absolute(most) => (x - y).abs() <= most,
        }
    }
}

/// Number of f32 steps between two numbers; both zeros are equal.
fn ulps_between(x: f32, y: f32) -> u32 {
    if x.is_nan() || y.is_nan() {
        return u32::MAX;
    }
    let place = |v: f32| {
        let size = i64::from(v.to_bits() & 0x7fff_ffff);
        if v.is_sign_negative() { -size } else { size }
    };
    place(x).abs_diff(place(y)) as u32
}

fn shown(kind: ScalarKind, word: u32) -> String {
    match kind {
        ScalarKind::Float => format!("{:?}", f32::from_bits(word)),
        ScalarKind::Sint => (word as i32).to_string(),
        ScalarKind::Bool => (word != 0).to_string(),
        _ => word.to_string(),
    }
}
