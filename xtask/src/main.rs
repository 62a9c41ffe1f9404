//! `cargo xtask <command>`: builds, runs and checks the workspace.
//!
//! It spawns cargo and the programs `terrain-lod` and `terrain-viewer` and links none of the other crates, so that it builds in seconds and
//! works while they do not.

mod bench_check;
mod checks;
mod program;
mod readme;
mod setup;

use std::ffi::{OsStr, OsString};
use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

/// A command of `terrain-lod` that `cargo xtask` builds and runs in release.
struct Forwarded {
    name: &'static str,
    summary: &'static str,
    /// Whether a missing GPU adapter is set up first, and `--no-gpu` added where there is still none.
    draws: bool,
}

/// One table instead of forwarding whatever comes: a typing error must not cost a release build.
const FORWARDED: [Forwarded; 6] = [
    Forwarded { name: "bench", summary: "fly a DEM with every method, print the comparison", draws: true },
    Forwarded { name: "cmp", summary: "compare two result folders: what is better, worse or the same", draws: false },
    Forwarded { name: "report", summary: "make one HTML file of a result folder", draws: false },
    Forwarded { name: "mesh", summary: "write the mesh of one frame as PLY", draws: false },
    Forwarded {
        name: "dem",
        summary: "look at elevation files (dem info, shade), convert them, cut them into cells, make them (dem synth)",
        draws: false,
    },
    Forwarded { name: "adapters", summary: "list the graphics adapters", draws: false },
];

/// Arguments of `bench` that make the GPU, and so its set-up, pointless.
const NEEDS_NO_GPU: [&str; 4] = ["--no-gpu", "--dry-run", "--help", "-h"];

/// Who names an adapter wants that one: another must not be installed in its place, nor the GPU be left out.
const ADAPTER_FLAGS: [&str; 2] = ["--backend", "--adapter"];
const ADAPTER_VARIABLES: [&str; 2] = ["WGPU_BACKEND", "WGPU_ADAPTER_NAME"];

/// What ends xtask early: one line for the user, and an exit code for the script.
#[derive(Debug)]
struct Fault {
    code: u8,
    message: String,
}

impl Fault {
    fn failure(message: impl Into<String>) -> Self {
        Self { code: 1, message: message.into() }
    }

    fn usage(message: impl Into<String>) -> Self {
        Self { code: 2, message: message.into() }
    }
}

fn main() -> ExitCode {
    let mut args = std::env::args_os().skip(1);
    let command = args.next().unwrap_or_default();
    match run(&command.to_string_lossy(), args.collect()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("xtask: {}", fault.message);
            ExitCode::from(fault.code)
        }
    }
}

fn run(command: &str, args: Vec<OsString>) -> Result<(), Fault> {
    if let Some(forwarded) = FORWARDED.iter().find(|forwarded| forwarded.name == command) {
        return Err(forward(forwarded, args));
    }
    match command {
        "" | "help" | "--help" | "-h" => print_usage(),
        "view" => return Err(view(&args)),
        "test" | "check-bench" | "check-readme" | "record" if has_any(&args, &["--help", "-h"]) => print_usage(),
        "test" => {
            refuse_all_but(&args, &["--no-gpu"])?;
            checks::run(!has_any(&args, &["--no-gpu"]))?;
        }
        "check-bench" => {
            refuse_all_but(&args, &["--no-gpu"])?;
            bench_check::run(!has_any(&args, &["--no-gpu"]))?;
        }
        "check-readme" => {
            refuse_all_but(&args, &["--write"])?;
            readme::check(has_any(&args, &["--write"]))?;
        }
        "record" => match &args[..] {
            [folder] => readme::record(Path::new(folder))?,
            _ => return Err(Fault::usage("record: expected one result folder")),
        },
        _ => return Err(Fault::usage(format!("unknown command '{command}'; `cargo xtask --help` lists them"))),
    }
    Ok(())
}

/// Builds the program and becomes it; comes back only where that failed.
fn forward(command: &Forwarded, mut args: Vec<OsString>) -> Fault {
    let program = match program::build() {
        Ok(program) => program,
        Err(fault) => return fault,
    };
    if command.draws {
        set_up_gpu(&program, &mut args);
    }
    args.insert(0, command.name.into());
    program::become_program(&program, &args)
}

/// Builds the viewer and becomes it. The other program knows the adapters.
fn view(args: &[OsString]) -> Fault {
    if !has_any(args, &["--help", "-h"]) && !names_an_adapter(args) {
        match program::build() {
            Ok(program) => drop(setup::ensure_adapter(&program)),
            Err(fault) => return fault,
        }
    }
    match program::build_viewer() {
        Ok(program) => program::become_program(&program, args),
        Err(fault) => fault,
    }
}

/// Sees to a GPU adapter, and asks the bench to go on without where there is none.
fn set_up_gpu(program: &Path, args: &mut Vec<OsString>) {
    let set_up = !has_any(args, &NEEDS_NO_GPU) && !names_an_adapter(args);
    if set_up && !setup::ensure_adapter(program) {
        eprintln!("xtask: no GPU adapter: the bench goes on without the GPU columns (--no-gpu)");
        args.push("--no-gpu".into());
    }
}

fn names_an_adapter(args: &[OsString]) -> bool {
    let is_flag = |arg: &OsString| ADAPTER_FLAGS.iter().any(|flag| arg.to_string_lossy().starts_with(flag));
    let is_set = |name: &&str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    args.iter().any(is_flag) || ADAPTER_VARIABLES.iter().any(is_set)
}

fn has_any(args: &[OsString], flags: &[&str]) -> bool {
    args.iter().any(|arg| flags.iter().any(|flag| arg == OsStr::new(flag)))
}

fn refuse_all_but(args: &[OsString], known: &[&str]) -> Result<(), Fault> {
    match args.iter().find(|arg| !known.iter().any(|known| *arg == OsStr::new(known))) {
        Some(arg) => {
            let arg = arg.to_string_lossy();
            Err(Fault::usage(format!("unexpected argument '{arg}'; `cargo xtask --help` shows what there is")))
        }
        None => Ok(()),
    }
}

fn print_usage() {
    let command = |command: &Forwarded| format!("  {:<12} {}\n", command.name, command.summary);
    let commands: String = FORWARDED.iter().map(command).collect();
    // A reader that has seen enough (`| head`) is no failure.
    let _ = std::io::stdout().write_all(format!("{USAGE}\n{commands}{CHECKS_AND_EXAMPLES}").as_bytes());
}

const USAGE: &str = "\
Usage: cargo xtask <COMMAND> [ARGS]

Commands of terrain-lod, built in release; --help after one shows its arguments:";

const CHECKS_AND_EXAMPLES: &str = "  view         fly through a DEM in a window, two methods side by side

Checks:
  test         everything that must pass: format, lints, tests, documentation (--no-gpu: no GPU set-up)
  check-bench  fly the quick suite and check its table: every method, no error, no crack (--no-gpu: without a GPU)
  check-readme whether the README shows the recorded runs (--write: make it so); a test of `test` too
  record       take a result folder over into bench-results/recorded, and show it in the README

Examples:
  cargo xtask bench
  cargo xtask bench --tolerance 0.5,1 --methods tin,full-grid --no-gpu
  cargo xtask view my.tif
  cargo xtask cmp results/before results/after --fail-on 5%
  cargo xtask test

On Linux without a GPU adapter, bench and test install Mesa's software driver (as root with apt), offer to (on a
terminal with sudo), or print the command.
";

#[cfg(test)]
mod tests {
    use super::*;

    fn code_of(command: &str, args: &[&str]) -> u8 {
        run(command, args.iter().map(OsString::from).collect()).map_or_else(|fault| fault.code, |()| 0)
    }

    #[test]
    fn usage_errors_have_exit_code_2() {
        assert_eq!(code_of("benhc", &[]), 2);
        assert_eq!(code_of("test", &["--fast"]), 2);
        assert_eq!(code_of("check-bench", &["--fast"]), 2);
        assert_eq!(code_of("check-readme", &["--fast"]), 2);
        assert_eq!(code_of("record", &[]), 2);
        assert_eq!(code_of("--help", &[]), 0);
        assert_eq!(code_of("test", &["--help"]), 0);
    }

    #[test]
    fn set_up_is_left_out_where_nothing_draws() {
        for flag in NEEDS_NO_GPU {
            assert!(has_any(&["--frames".into(), "3".into(), flag.into()], &NEEDS_NO_GPU));
        }
        assert!(!has_any(&["--methods".into(), "tin".into()], &NEEDS_NO_GPU));
    }

    #[test]
    fn a_named_adapter_is_not_replaced_by_another() {
        assert!(names_an_adapter(&["--backend".into(), "gl".into()]));
        assert!(names_an_adapter(&["--adapter=nvidia".into()]));
        assert!(
            ADAPTER_VARIABLES.iter().any(|name| std::env::var_os(name).is_some())
                || !names_an_adapter(&["--frames".into()])
        );
    }
}
