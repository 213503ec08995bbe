//! The `relievo` command.
fn main() {}
