//! Flies terrain level-of-detail methods over elevation data and compares them; all of it is in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    terrain_lod::main_with(std::env::args_os())
}
