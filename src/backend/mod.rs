//! Running a plan.

pub mod cpu;
