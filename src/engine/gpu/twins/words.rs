//! Rust values as the words of their WGSL counterparts.

use glam::{DVec2, DVec3, Vec2, Vec3};

/// A value composed of words.
pub(super) trait Words {
    fn read(words: &mut dyn Iterator<Item = u32>) -> Self;
    fn write(self, out: &mut Vec<u32>);
}

macro_rules! words {
    ($($kind:ty: $read:expr, $write:expr;)*) => {
        $(impl Words for $kind {
            fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
                $read(Words::read(words))
            }

            fn write(self, out: &mut Vec<u32>) {
                $write(self).write(out);
            }
        })*
    };
}

words! {
    f32: f32::from_bits, f32::to_bits;
    f64: |v: f32| f64::from(v), |v| v as f32;
    i32: |word: u32| word as i32, |v| v as u32;
    usize: |word: u32| word as usize, |v| v as u32;
    bool: |word: u32| word != 0, u32::from;
    Vec2: Vec2::from_array, |v: Vec2| v.to_array();
    Vec3: Vec3::from_array, |v: Vec3| v.to_array();
    DVec2: DVec2::from_array, |v: DVec2| v.to_array();
    DVec3: DVec3::from_array, |v: DVec3| v.to_array();
}

impl Words for u32 {
    fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
        words.next().expect("as many inputs as Rust takes")
    }

    fn write(self, out: &mut Vec<u32>) {
        out.push(self);
    }
}

impl<T: Words, const N: usize> Words for [T; N] {
    fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
        std::array::from_fn(|_| T::read(words))
    }

    fn write(self, out: &mut Vec<u32>) {
        self.into_iter().for_each(|part| part.write(out));
    }
}

/// A struct whose last member says whether the others, floats, mean something.
impl<T: Words> Words for Option<T> {
    fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
        let value = T::read(words);
        bool::read(words).then_some(value)
    }

    fn write(self, out: &mut Vec<u32>) {
        let is_there = self.is_some();
        // Results that are not finite are not compared.
        let nothing = || T::read(&mut std::iter::repeat(f32::NAN.to_bits()));
        self.unwrap_or_else(nothing).write(out);
        is_there.write(out);
    }
}

/// A function of values composed of words.
pub(super) trait Namesake<A> {
    fn run(&self, words: &mut dyn Iterator<Item = u32>, out: &mut Vec<u32>);
}

macro_rules! namesakes {
    ($($($part:ident)+;)*) => {
        $(
            impl<$($part: Words),+> Words for ($($part,)+) {
                fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
                    ($($part::read(words),)+)
                }

                #[allow(non_snake_case, reason = "the parts are named after their types")]
                fn write(self, out: &mut Vec<u32>) {
                    let ($($part,)+) = self;
                    $($part.write(out);)+
                }
            }

            impl<F: Fn($($part),+) -> R, R: Words, $($part: Words),+> Namesake<($($part,)+)> for F {
                fn run(&self, words: &mut dyn Iterator<Item = u32>, out: &mut Vec<u32>) {
                    self($($part::read(words)),+).write(out);
                    assert!(words.next().is_none(), "as many inputs as Rust takes");
                }
            }
        )*
    };
}

namesakes! {
    A; A B; A B C; A B C D; A B C D E; A B C D E G; A B C D E G H; A B C D E G H I;
}
