//! See `src/targets/pictures.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| relievo_fuzz::targets::run("pictures", data));
