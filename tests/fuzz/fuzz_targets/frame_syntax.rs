//! See `src/targets/frame_syntax.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| relievo_fuzz::targets::run("frame_syntax", data));
