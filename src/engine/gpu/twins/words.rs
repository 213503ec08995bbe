//! Rust values as the words of their WGSL counterparts.

/// Marks results that WGSL leaves open: a NaN that no arithmetic produces.
pub(super) const UNSPECIFIED: f32 = f32::from_bits(0x7fc0_dead);

/// A value composed of words.
pub(super) trait Words {
    /// Number of words.
    const COUNT: usize;

    fn read(words: &mut dyn Iterator<Item = u32>) -> Self;
    fn write(self, out: &mut Vec<u32>);
}

macro_rules! words {
    ($($kind:ty: $read:expr, $write:expr;)*) => {
        $(impl Words for $kind {
            const COUNT: usize = 1;

            fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
                $read(words.next().expect("as many inputs as the closure takes"))
            }

            fn write(self, out: &mut Vec<u32>) {
                out.push($write(self));
            }
        })*
    };
}

words! {
    f32: f32::from_bits, f32::to_bits;
    u32: std::convert::identity, std::convert::identity;
    i32: |word| word as i32, |number| number as u32;
    bool: |word| word != 0, u32::from;
}

impl<T: Words, const N: usize> Words for [T; N] {
    const COUNT: usize = N * T::COUNT;

    fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
        std::array::from_fn(|_| T::read(words))
    }

    fn write(self, out: &mut Vec<u32>) {
        self.into_iter().for_each(|part| part.write(out));
    }
}

/// A struct whose last member says whether the others are valid.
impl<T: Words> Words for Option<T> {
    const COUNT: usize = T::COUNT + 1;

    fn read(words: &mut dyn Iterator<Item = u32>) -> Self {
        let value = T::read(words);
        bool::read(words).then_some(value)
    }

    fn write(self, out: &mut Vec<u32>) {
        let is_there = self.is_some();
        match self {
            Some(value) => value.write(out),
            None => out.extend(std::iter::repeat_n(UNSPECIFIED.to_bits(), T::COUNT)),
        }
        is_there.write(out);
    }
}

/// A closure over values composed of words.
pub(super) trait Namesake<A> {
    fn run(&self, words: &mut dyn Iterator<Item = u32>, out: &mut Vec<u32>);
}

macro_rules! namesakes {
    ($($($part:ident)+;)*) => {
        $(
            impl<$($part: Words),+> Words for ($($part,)+) {
                const COUNT: usize = 0 $(+ $part::COUNT)+;

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
                    assert!(words.next().is_none(), "as many inputs as the closure takes");
                }
            }
        )*
    };
}

namesakes! {
    A; A B; A B C; A B C D; A B C D E; A B C D E G; A B C D E G H; A B C D E G H I;
}
