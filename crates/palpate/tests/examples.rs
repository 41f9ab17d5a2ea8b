//! The examples run and do not fail.
#![allow(clippy::print_stdout, reason = "the examples print")]

#[path = "../examples/information_for_planning.rs"]
mod information_for_planning;
#[path = "../examples/monte_carlo.rs"]
mod monte_carlo;
#[path = "../examples/own_sensor.rs"]
mod own_sensor;
#[path = "../examples/own_start.rs"]
mod own_start;
#[path = "../examples/reconstruct_a_log.rs"]
mod reconstruct_a_log;

#[test]
fn a_log_is_reconstructed() {
    reconstruct_a_log::main().expect("no error");
}

#[test]
fn a_start_is_given() {
    own_start::main().expect("no error");
}

#[test]
fn a_sensor_is_brought_along() {
    own_sensor::main().expect("no error");
}

#[test]
fn a_study_is_made() {
    monte_carlo::main().expect("no error");
}

#[test]
fn a_motion_is_chosen_by_what_it_tells() {
    information_for_planning::main().expect("no error");
}
