//! The `relievo` command.

fn main() {
    std::process::exit(relievo::cli::run());
}
