//! Runs functions of a WGSL module on the CPU: naga's IR, as far as numeric functions need it.
//!
//! One memory of 32-bit words holds everything: global variables first, then a frame for each call with its result,
//! arguments, local variables and the values of all expressions. A pointer is the index of a word. Arithmetic is IEEE
//! with one rounding per operation, subnormal numbers are kept, and `min` and `max` of a number and a NaN return the
//! number.

use super::arithmetic::{binary, bits_of, cast, dot, math, unary};
use std::collections::HashMap;
use wgpu::naga::front::wgsl;
use wgpu::naga::valid::{
    Capabilities, FunctionInfo, GlobalUse, ModuleInfo, ValidationFlags, Validator,
};
use wgpu::naga::{
    AddressSpace, ArraySize, Block, Expression, Function, GlobalVariable, Handle, Literal,
    MathFunction, Module, Override, RelationalFunction, Scalar, ScalarKind, Statement, Type,
    TypeInner,
};

/// A module and the memory layout of its functions.
pub(super) struct Program {
    source: String,
    module: Module,
    info: ModuleInfo,
    layouts: HashMap<Handle<Function>, Layout>,
    globals: HashMap<Handle<GlobalVariable>, usize>,
    /// Words taken by global variables.
    globals_end: usize,
}

/// The frame of a function: word offsets from its start, where the result is stored.
struct Layout {
    arguments: Vec<usize>,
    locals: Vec<usize>,
    expressions: Vec<Slot>,
    words: usize,
}

/// Location, size in words and kind of an expression's value.
#[derive(Clone, Copy)]
struct Slot {
    at: usize,
    words: usize,
    kind: ScalarKind,
}

/// Memory of a machine in words.
const MEMORY: usize = 1 << 16;

impl Program {
    pub(super) fn new(source: String) -> Self {
        let module = wgsl::parse_str(&source)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
        let mut validator = Validator::new(ValidationFlags::all(), Capabilities::empty());
        let info = validator
            .validate(&module)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&source)));
        let mut globals = HashMap::new();
        let mut globals_end = 0;
        for (handle, variable) in module.global_variables.iter() {
            if matches!(
                variable.space,
                AddressSpace::Uniform | AddressSpace::Private
            ) {
                globals.insert(handle, globals_end);
                globals_end += words_of(&module, variable.ty);
            }
        }
        let mut program = Self {
            source,
            module,
            info,
            layouts: HashMap::new(),
            globals,
            globals_end,
        };
        let found = program.module.functions.iter();
        program.layouts = found
            .filter(|&(handle, _)| program.is_scalar(handle))
            .map(|(handle, function)| (handle, program.layout(handle, function)))
            .collect();
        program
    }

    /// Whether a function's result depends only on its arguments, the uniform block and switches.
    fn is_scalar(&self, handle: Handle<Function>) -> bool {
        let uses = &self.info[handle];
        let touches = |(variable, global): (_, &GlobalVariable)| {
            global.space != AddressSpace::Uniform && uses[variable] != GlobalUse::empty()
        };
        self.module.functions[handle].result.is_some()
            && !self.module.global_variables.iter().any(touches)
    }

    fn layout(&self, handle: Handle<Function>, function: &Function) -> Layout {
        let mut words = function
            .result
            .as_ref()
            .map_or(0, |result| words_of(&self.module, result.ty));
        let mut take = |ty| {
            let at = words;
            words += words_of(&self.module, ty);
            at
        };
        let arguments = function.arguments.iter().map(|a| take(a.ty)).collect();
        let locals = function
            .local_variables
            .iter()
            .map(|(_, l)| take(l.ty))
            .collect();
        let info = &self.info[handle];
        let slot = |(expression, _): (Handle<Expression>, &Expression)| {
            let inner = info[expression].ty.inner_with(&self.module.types);
            let slot = Slot {
                at: words,
                words: words_of_inner(&self.module, inner),
                kind: kind_of(inner),
            };
            words += slot.words;
            slot
        };
        let expressions = function.expressions.iter().map(slot).collect();
        Layout {
            arguments,
            locals,
            expressions,
            words,
        }
    }

    /// The scalar functions that take or return floats.
    pub(super) fn scalar_functions(&self) -> impl Iterator<Item = Signature<'_>> {
        let all = self.module.functions.iter();
        all.filter(|(handle, _)| self.layouts.contains_key(handle))
            .map(|(handle, function)| self.signature(handle, function))
    }

    fn signature<'a>(&'a self, handle: Handle<Function>, function: &'a Function) -> Signature<'a> {
        let mut arguments = Vec::new();
        for argument in &function.arguments {
            add_kinds(&self.module, argument.ty, &mut arguments);
        }
        let mut result = Vec::new();
        if let Some(found) = &function.result {
            add_kinds(&self.module, found.ty, &mut result);
        }
        let span = self.module.functions.get_span(handle);
        Signature {
            handle,
            name: function.name.as_deref().unwrap_or_default(),
            text: &self.source[span.to_range().unwrap_or_default()],
            arguments,
            result,
        }
    }

    /// All f32 that a function of the module compares or computes with, for testing inputs at and beside them.
    pub(super) fn numbers(&self, signature: &Signature) -> Vec<f32> {
        let mut numbers = Vec::new();
        for (_, expression) in self.module.functions[signature.handle].expressions.iter() {
            let found = match *expression {
                Expression::Literal(literal) => Some(literal),
                Expression::Constant(constant) => {
                    let init = self.module.constants[constant].init;
                    match self.module.global_expressions[init] {
                        Expression::Literal(literal) => Some(literal),
                        _ => None,
                    }
                }
                _ => None,
            };
            if let Some(Literal::F32(number)) = found {
                numbers.push(number);
            }
        }
        numbers
    }

    /// The fields of the uniform block, which comes first: one word each.
    pub(super) fn fields(&self) -> Vec<(String, ScalarKind)> {
        let mut variables = self.module.global_variables.iter();
        let params = variables.find(|(_, variable)| variable.space == AddressSpace::Uniform);
        let Some((handle, variable)) = params else {
            return Vec::new();
        };
        assert_eq!(self.globals[&handle], 0, "params is bound first");
        match &self.module.types[variable.ty].inner {
            TypeInner::Struct { members, .. } => members
                .iter()
                .map(|member| {
                    let kind = kind_of(&self.module.types[member.ty].inner);
                    (member.name.clone().unwrap_or_default(), kind)
                })
                .collect(),
            _ => panic!("params is a struct"),
        }
    }

    /// The switches that the module declares.
    pub(super) fn switches(&self) -> impl Iterator<Item = &str> {
        let all = self.module.overrides.iter();
        all.filter_map(|(_, declared)| declared.name.as_deref())
    }
}

/// A numeric function.
pub(super) struct Signature<'a> {
    handle: Handle<Function>,
    pub(super) name: &'a str,
    pub(super) text: &'a str,
    /// Kinds of the words it takes and returns.
    pub(super) arguments: Vec<ScalarKind>,
    pub(super) result: Vec<ScalarKind>,
}

fn words_of(module: &Module, ty: Handle<Type>) -> usize {
    words_of_inner(module, &module.types[ty].inner)
}

fn words_of_inner(module: &Module, inner: &TypeInner) -> usize {
    match inner {
        TypeInner::Vector { size, .. } => *size as usize,
        TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            ..
        } => count.get() as usize * words_of(module, *base),
        TypeInner::Struct { members, .. } => members.iter().map(|m| words_of(module, m.ty)).sum(),
        _ => 1,
    }
}

fn kind_of(inner: &TypeInner) -> ScalarKind {
    match inner {
        TypeInner::Scalar(scalar) | TypeInner::Vector { scalar, .. } => scalar.kind,
        _ => ScalarKind::Uint,
    }
}

fn add_kinds(module: &Module, ty: Handle<Type>, kinds: &mut Vec<ScalarKind>) {
    match &module.types[ty].inner {
        TypeInner::Struct { members, .. } => {
            members.iter().for_each(|m| add_kinds(module, m.ty, kinds));
        }
        TypeInner::Array {
            base,
            size: ArraySize::Constant(count),
            ..
        } => (0..count.get()).for_each(|_| add_kinds(module, *base, kinds)),
        inner => {
            let words = words_of_inner(module, inner);
            kinds.extend(std::iter::repeat_n(kind_of(inner), words));
        }
    }
}

/// A program with values for its uniform block and switches.
pub(super) struct Machine<'a> {
    program: &'a Program,
    memory: Vec<u32>,
    switches: HashMap<Handle<Override>, bool>,
}

/// How control leaves a statement.
#[derive(PartialEq)]
enum Flow {
    On,
    Break,
    Continue,
    Return,
}

impl<'a> Machine<'a> {
    pub(super) fn new(program: &'a Program) -> Self {
        Self {
            program,
            memory: vec![0; MEMORY],
            switches: HashMap::new(),
        }
    }

    /// The uniform block.
    pub(super) fn params(&mut self) -> &mut [u32] {
        &mut self.memory[..self.program.globals_end]
    }

    pub(super) fn set_switch(&mut self, name: &str, on: bool) {
        let mut all = self.program.module.overrides.iter();
        let found = all.find(|(_, declared)| declared.name.as_deref() == Some(name));
        let (handle, _) = found.unwrap_or_else(|| panic!("no switch {name}"));
        self.switches.insert(handle, on);
    }

    /// The result of a function for arguments, word by word.
    pub(super) fn call(&mut self, signature: &Signature, arguments: &[u32]) -> &[u32] {
        let frame = self.program.globals_end;
        let first = self.program.layouts[&signature.handle]
            .arguments
            .first()
            .copied()
            .unwrap_or_default();
        self.memory[frame + first..][..arguments.len()].copy_from_slice(arguments);
        self.enter(signature.handle, frame);
        &self.memory[frame..][..signature.result.len()]
    }

    /// Runs a function whose arguments are already in its frame.
    fn enter(&mut self, handle: Handle<Function>, frame: usize) {
        let program = self.program;
        let call = Call {
            function: &program.module.functions[handle],
            info: &program.info[handle],
            layout: &program.layouts[&handle],
            frame,
        };
        for (expression, kind) in call.function.expressions.iter() {
            if kind.needs_pre_emit() {
                self.evaluate(&call, expression);
            }
        }
        for (i, (_, local)) in call.function.local_variables.iter().enumerate() {
            let (at, words) = (
                frame + call.layout.locals[i],
                words_of(&program.module, local.ty),
            );
            match local.init {
                Some(value) => {
                    self.evaluate(&call, value);
                    self.copy(call.slot(value).at, at, words);
                }
                None => self.memory[at..at + words].fill(0),
            }
        }
        self.run(&call, &call.function.body);
    }

    fn copy(&mut self, from: usize, to: usize, words: usize) {
        self.memory.copy_within(from..from + words, to);
    }

    fn run(&mut self, call: &Call, block: &Block) -> Flow {
        for statement in block.iter() {
            let flow = self.step(call, statement);
            if flow != Flow::On {
                return flow;
            }
        }
        Flow::On
    }

    fn step(&mut self, call: &Call, statement: &Statement) -> Flow {
        match statement {
            Statement::Emit(range) => {
                for expression in range.clone() {
                    self.evaluate(call, expression);
                }
                Flow::On
            }
            Statement::Block(block) => self.run(call, block),
            Statement::If {
                condition,
                accept,
                reject,
            } => {
                let is_met = self.word(call, *condition) != 0;
                self.run(call, if is_met { accept } else { reject })
            }
            Statement::Loop {
                body,
                continuing,
                break_if,
            } => self.run_loop(call, body, continuing, *break_if),
            Statement::Break => Flow::Break,
            Statement::Continue => Flow::Continue,
            Statement::Return { value } => {
                if let Some(value) = value {
                    let slot = call.slot(*value);
                    self.copy(slot.at, call.frame, slot.words);
                }
                Flow::Return
            }
            Statement::Store { pointer, value } => {
                let (to, slot) = (self.word(call, *pointer) as usize, call.slot(*value));
                self.copy(slot.at, to, slot.words);
                Flow::On
            }
            Statement::Call {
                function,
                arguments,
                result,
            } => {
                let frame = call.frame + call.layout.words;
                let callee = &self.program.layouts[function];
                for (at, argument) in callee.arguments.iter().zip(arguments) {
                    let slot = call.slot(*argument);
                    self.copy(slot.at, frame + at, slot.words);
                }
                self.enter(*function, frame);
                if let Some(result) = result {
                    let slot = call.slot(*result);
                    self.copy(frame, slot.at, slot.words);
                }
                Flow::On
            }
            other => panic!("no statement of a scalar function: {other:?}"),
        }
    }

    fn run_loop(
        &mut self,
        call: &Call,
        body: &Block,
        continuing: &Block,
        break_if: Option<Handle<Expression>>,
    ) -> Flow {
        loop {
            match self.run(call, body) {
                Flow::Break => return Flow::On,
                Flow::Return => return Flow::Return,
                Flow::On | Flow::Continue => {}
            }
            self.run(call, continuing);
            if break_if.is_some_and(|condition| self.word(call, condition) != 0) {
                return Flow::On;
            }
        }
    }

    /// The first word of the value of an expression.
    fn word(&self, call: &Call, expression: Handle<Expression>) -> u32 {
        self.memory[call.slot(expression).at]
    }

    /// Sets each word of an expression to a function of words of other expressions; scalars are broadcast.
    fn each<const N: usize>(&mut self, out: Slot, of: [Slot; N], value: impl Fn([u32; N]) -> u32) {
        for i in 0..out.words {
            let word = |slot: Slot| self.memory[slot.at + if slot.words == 1 { 0 } else { i }];
            self.memory[out.at + i] = value(of.map(word));
        }
    }

    fn evaluate(&mut self, call: &Call, expression: Handle<Expression>) {
        let out = call.slot(expression);
        let module = &self.program.module;
        match &call.function.expressions[expression] {
            Expression::Literal(literal) => self.memory[out.at] = bits_of(*literal),
            Expression::Constant(constant) => {
                self.constant(module.constants[*constant].init, out.at);
            }
            Expression::Override(handle) => {
                let on = self.switches.get(handle);
                self.memory[out.at] = u32::from(*on.expect("a switch is set"));
            }
            Expression::ZeroValue(_) => self.memory[out.at..][..out.words].fill(0),
            Expression::Compose { components, .. } => {
                let mut at = out.at;
                for component in components {
                    let slot = call.slot(*component);
                    self.copy(slot.at, at, slot.words);
                    at += slot.words;
                }
            }
            Expression::Splat { value, .. } => self.each(out, [call.slot(*value)], |[v]| v),
            Expression::Swizzle {
                vector, pattern, ..
            } => {
                let from = call.slot(*vector).at;
                for (i, component) in pattern.iter().enumerate().take(out.words) {
                    self.memory[out.at + i] = self.memory[from + *component as usize];
                }
            }
            Expression::FunctionArgument(i) => {
                let from = call.frame + call.layout.arguments[*i as usize];
                self.copy(from, out.at, out.words);
            }
            Expression::GlobalVariable(handle) => {
                self.memory[out.at] = self.program.globals[handle] as u32;
            }
            Expression::LocalVariable(handle) => {
                let at = call.frame + call.layout.locals[handle.index()];
                self.memory[out.at] = at as u32;
            }
            Expression::Load { pointer } => {
                let from = self.word(call, *pointer) as usize;
                self.copy(from, out.at, out.words);
            }
            Expression::AccessIndex { base, index } => self.access(call, out, *base, *index),
            Expression::Access { base, index } => {
                let index = self.word(call, *index);
                self.access(call, out, *base, index);
            }
            // Written when the call returns.
            Expression::CallResult(_) => {}
            _ => self.compute(call, expression, out),
        }
    }

    /// Computes an operation on other values.
    fn compute(&mut self, call: &Call, expression: Handle<Expression>, out: Slot) {
        match &call.function.expressions[expression] {
            Expression::Unary { op, expr } => {
                let of = call.slot(*expr);
                self.each(out, [of], |[a]| unary(*op, of.kind, a));
            }
            Expression::Binary { op, left, right } => {
                let (left, right) = (call.slot(*left), call.slot(*right));
                self.each(out, [left, right], |[a, b]| binary(*op, left.kind, a, b));
            }
            Expression::Select {
                condition,
                accept,
                reject,
            } => {
                let of = [*condition, *accept, *reject].map(|e| call.slot(e));
                self.each(out, of, |[met, yes, no]| if met != 0 { yes } else { no });
            }
            Expression::Relational { fun, argument } => {
                let slot = call.slot(*argument);
                let mut words = self.memory[slot.at..][..slot.words].iter();
                self.memory[out.at] = u32::from(match fun {
                    RelationalFunction::All => words.all(|&word| word != 0),
                    RelationalFunction::Any => words.any(|&word| word != 0),
                    other => panic!("no {other:?} here"),
                });
            }
            Expression::Math {
                fun,
                arg,
                arg1,
                arg2,
                ..
            } => {
                let first = call.slot(*arg);
                let [second, third] = [arg1, arg2].map(|a| a.map_or(first, |a| call.slot(a)));
                self.math(*fun, out, [first, second, third]);
            }
            Expression::As {
                expr,
                kind,
                convert,
            } => {
                let of = call.slot(*expr);
                let is_cast = convert.is_some();
                self.each(
                    out,
                    [of],
                    |[a]| if is_cast { cast(of.kind, *kind, a) } else { a },
                );
            }
            other => panic!("no expression of a scalar function: {other:?}"),
        }
    }

    /// Writes the value of a constant expression.
    fn constant(&mut self, expression: Handle<Expression>, at: usize) -> usize {
        match &self.program.module.global_expressions[expression] {
            Expression::Literal(literal) => {
                self.memory[at] = bits_of(*literal);
                1
            }
            Expression::Constant(constant) => {
                self.constant(self.program.module.constants[*constant].init, at)
            }
            Expression::Compose { components, .. } => {
                let mut words = 0;
                for &component in components {
                    words += self.constant(component, at + words);
                }
                words
            }
            other => panic!("no constant: {other:?}"),
        }
    }

    /// A component, element or member of a value, or a pointer to it.
    fn access(&mut self, call: &Call, out: Slot, base: Handle<Expression>, index: u32) {
        let module = &self.program.module;
        let (inner, is_pointer) = match call.info[base].ty.inner_with(&module.types) {
            TypeInner::Pointer { base, .. } => (&module.types[*base].inner, true),
            TypeInner::ValuePointer { .. } => (&TypeInner::Scalar(Scalar::U32), true),
            inner => (inner, false),
        };
        let index = index as usize;
        let offset = match inner {
            TypeInner::Struct { members, .. } => members[..index]
                .iter()
                .map(|member| words_of(module, member.ty))
                .sum(),
            TypeInner::Array { base, .. } => index * words_of(module, *base),
            _ => index,
        };
        let from = call.slot(base).at;
        if is_pointer {
            self.memory[out.at] = self.memory[from] + offset as u32;
        } else {
            self.copy(from + offset, out.at, out.words);
        }
    }

    fn math(&mut self, fun: MathFunction, out: Slot, of: [Slot; 3]) {
        let floats = |slot: Slot| {
            let words = &self.memory[slot.at..][..slot.words];
            words
                .iter()
                .copied()
                .map(f32::from_bits)
                .collect::<Vec<_>>()
        };
        match fun {
            MathFunction::Dot => {
                self.memory[out.at] = dot(&floats(of[0]), &floats(of[1])).to_bits();
            }
            MathFunction::Length => {
                let v = floats(of[0]);
                self.memory[out.at] = dot(&v, &v).sqrt().to_bits();
            }
            MathFunction::Cross => {
                let (a, b) = (floats(of[0]), floats(of[1]));
                for i in 0..3 {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    self.memory[out.at + i] = (a[j] * b[k] - a[k] * b[j]).to_bits();
                }
            }
            _ => self.each(out, of, |[a, b, c]| math(fun, of[0].kind, a, b, c)),
        }
    }
}

/// A call in progress.
struct Call<'a> {
    function: &'a Function,
    info: &'a FunctionInfo,
    layout: &'a Layout,
    frame: usize,
}

impl Call<'_> {
    fn slot(&self, expression: Handle<Expression>) -> Slot {
        let slot = self.layout.expressions[expression.index()];
        Slot {
            at: self.frame + slot.at,
            ..slot
        }
    }
}
