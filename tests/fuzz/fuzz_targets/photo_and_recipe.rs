//! See `src/targets/photo_and_recipe.rs`.
#![no_main]

libfuzzer_sys::fuzz_target!(|data: &[u8]| relievo_fuzz::targets::run("photo_and_recipe", data));
