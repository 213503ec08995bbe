//! The `relievo` command.

#[cfg(target_os = "linux")]
mod large_blocks;

fn main() {
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    large_blocks::keep_small_blocks();
    std::process::exit(relievo::cli::run());
}
