//! The Python package, built and installed as a user does, and then tried from Python.

mod environment;

use environment::pytest;

#[test]
fn what_python_computes_is_what_the_program_prints() {
    pytest("test_same_as_program.py");
}

#[test]
fn simulations_step() {
    pytest("test_simulations.py");
}

#[test]
fn errors_are_exceptions_with_the_programs_words() {
    pytest("test_errors.py");
}

#[test]
fn types_are_as_the_stubs_say() {
    pytest("test_types.py");
}

#[test]
fn notebooks_run() {
    pytest("test_notebooks.py");
}

#[test]
fn environments_are_what_their_checkers_ask_for() {
    pytest("test_environments.py");
}
