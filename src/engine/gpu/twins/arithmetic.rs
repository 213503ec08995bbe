//! The operators of WGSL on words of 32 bits.

use wgpu::naga::{BinaryOperator, Literal, MathFunction, ScalarKind, UnaryOperator};

/// The dot product, summed from the first component on.
pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    let products = a.iter().zip(b).map(|(a, b)| a * b);
    products.reduce(|sum, product| sum + product).unwrap_or(0.0)
}

pub(super) fn bits_of(literal: Literal) -> u32 {
    match literal {
        Literal::F32(v) => v.to_bits(),
        Literal::U32(v) => v,
        Literal::I32(v) => v as u32,
        Literal::Bool(v) => v.into(),
        other => panic!("no literal of 32 bits: {other:?}"),
    }
}

pub(super) fn unary(op: UnaryOperator, kind: ScalarKind, a: u32) -> u32 {
    match (op, kind) {
        (UnaryOperator::Negate, ScalarKind::Float) => (-f32::from_bits(a)).to_bits(),
        (UnaryOperator::Negate, _) => a.wrapping_neg(),
        (UnaryOperator::LogicalNot, _) => u32::from(a == 0),
        (UnaryOperator::BitwiseNot, _) => !a,
    }
}

pub(super) fn binary(op: BinaryOperator, kind: ScalarKind, a: u32, b: u32) -> u32 {
    match kind {
        ScalarKind::Float => of_floats(op, f32::from_bits(a), f32::from_bits(b)),
        ScalarKind::Sint => of_integers(op, i64::from(a as i32), i64::from(b as i32)),
        _ => of_integers(op, a.into(), b.into()),
    }
}

fn of_floats(op: BinaryOperator, a: f32, b: f32) -> u32 {
    use BinaryOperator as Op;
    let number = match op {
        Op::Add => a + b,
        Op::Subtract => a - b,
        Op::Multiply => a * b,
        Op::Divide => a / b,
        Op::Equal => return u32::from(a == b),
        Op::NotEqual => return u32::from(a != b),
        Op::Less => return u32::from(a < b),
        Op::LessEqual => return u32::from(a <= b),
        Op::Greater => return u32::from(a > b),
        Op::GreaterEqual => return u32::from(a >= b),
        other => panic!("no {other:?} of floats"),
    };
    number.to_bits()
}

/// Integers of either sign, in a type where no operation overflows; the result wraps.
fn of_integers(op: BinaryOperator, a: i64, b: i64) -> u32 {
    use BinaryOperator as Op;
    let number = match op {
        Op::Add => a + b,
        Op::Subtract => a - b,
        Op::Multiply => a.wrapping_mul(b),
        Op::Divide => a.checked_div(b).unwrap_or(a),
        Op::Modulo => a.checked_rem(b).unwrap_or(0),
        Op::And | Op::LogicalAnd => a & b,
        Op::ExclusiveOr => a ^ b,
        Op::InclusiveOr | Op::LogicalOr => a | b,
        Op::ShiftLeft => a << (b & 31),
        Op::ShiftRight => a >> (b & 31),
        Op::Equal => i64::from(a == b),
        Op::NotEqual => i64::from(a != b),
        Op::Less => i64::from(a < b),
        Op::LessEqual => i64::from(a <= b),
        Op::Greater => i64::from(a > b),
        Op::GreaterEqual => i64::from(a >= b),
    };
    number as u32
}

pub(super) fn math(fun: MathFunction, kind: ScalarKind, a: u32, b: u32, c: u32) -> u32 {
    match kind {
        ScalarKind::Float => {
            let [a, b, c] = [a, b, c].map(f32::from_bits);
            let number = match fun {
                MathFunction::Abs => a.abs(),
                MathFunction::Min => a.min(b),
                MathFunction::Max => a.max(b),
                MathFunction::Clamp => a.max(b).min(c),
                MathFunction::Floor => a.floor(),
                MathFunction::Ceil => a.ceil(),
                MathFunction::Round => a.round_ties_even(),
                MathFunction::Sqrt => a.sqrt(),
                other => panic!("no {other:?} of floats"),
            };
            number.to_bits()
        }
        ScalarKind::Sint => {
            let [a, b, c] = [a, b, c].map(|word| word as i32);
            let number = match fun {
                MathFunction::Abs => a.wrapping_abs(),
                MathFunction::Min => a.min(b),
                MathFunction::Max => a.max(b),
                MathFunction::Clamp => a.max(b).min(c),
                other => panic!("no {other:?} of signed integers"),
            };
            number as u32
        }
        _ => match fun {
            MathFunction::Min => a.min(b),
            MathFunction::Max => a.max(b),
            MathFunction::Clamp => a.max(b).min(c),
            MathFunction::CountOneBits => a.count_ones(),
            MathFunction::FirstTrailingBit => {
                if a == 0 {
                    u32::MAX
                } else {
                    a.trailing_zeros()
                }
            }
            MathFunction::FirstLeadingBit => 31_u32.wrapping_sub(a.leading_zeros()),
            other => panic!("no {other:?} of unsigned integers"),
        },
    }
}

/// Converts a number to the nearest of another kind; values out of range saturate.
pub(super) fn cast(from: ScalarKind, to: ScalarKind, a: u32) -> u32 {
    let as_float = f32::from_bits(a);
    match (from, to) {
        (ScalarKind::Float, ScalarKind::Uint) => as_float as u32,
        (ScalarKind::Float, ScalarKind::Sint) => as_float as i32 as u32,
        (ScalarKind::Uint, ScalarKind::Float) => (a as f32).to_bits(),
        (ScalarKind::Sint, ScalarKind::Float) => (a as i32 as f32).to_bits(),
        (ScalarKind::Bool, ScalarKind::Float) => (a as f32).to_bits(),
        (ScalarKind::Float, ScalarKind::Bool) => u32::from(as_float != 0.0),
        (_, ScalarKind::Bool) => u32::from(a != 0),
        _ => a,
    }
}
