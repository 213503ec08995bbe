//! See `src/targets/exr_to_frame.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| relievo_fuzz::targets::run("exr_to_frame", data));
