//! See `src/targets/camera_and_light.rs`.
#![no_main]

use libfuzzer_sys::{fuzz_mutator, fuzz_target};
use relievo_fuzz::mutate::{Flags, words};
use relievo_fuzz::targets;

fuzz_target!(|data: &[u8]| targets::run("camera_and_light", data));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    words(&mut data[..max_size], size, seed, Flags::Light)
});
