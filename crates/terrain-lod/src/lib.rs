//! The program `terrain-lod`, and what other programs share with it: the list of methods with their settings, the opening
//! of DEMs and flights, and the error pass's judge. The viewer measures what it shows by that code.

mod attempt;
mod begun;
mod bench;
mod benches;
mod cells;
mod cells_dem;
mod cells_file;
mod choices;
mod cli;
mod cmp;
mod cmp_args;
mod compare;
mod convert;
mod cut;
mod dem;
mod dem_args;
mod dry_run;
mod equal_error;
mod error_pass;
mod fault;
mod figures;
mod fine;
mod flight_curves;
mod flip;
mod frame_times;
mod heat;
mod interrupt;
mod interval;
mod layout;
mod lettering;
mod live_pass;
mod machine;
mod maps;
mod mesh;
mod methods;
mod output;
mod parse;
mod parts;
mod passes;
mod pictures;
mod pivot;
mod popping_bins;
mod prepared;
mod progress;
mod read_failures;
mod record;
mod render_args;
mod repeats;
mod report;
mod results;
mod shade;
mod shots;
mod sidecar_file;
mod speed_pass;
mod suite;
mod summary;
mod summary_file;
mod synth;
mod table;
mod tables;
mod void_cut;

use std::ffi::OsString;
use std::process::ExitCode;

use clap::Parser;
use clap::error::ErrorKind;
use terrain_renderer::{AdapterFacts, ListedAdapter};

pub use crate::choices::{
    BatchingName, EdgePolicyName, IndexStoreName, LoadingName, MetricName, ScheduleName, SelectorName,
    TriangulatorName, name_of,
};
pub use crate::dem::open as open_dem;
pub use crate::dem_args::ReadArgs;
pub use crate::error_pass::{Change, ErrorFrame, Judge};
pub use crate::fault::{Cause, Fault};
pub use crate::frame_times::{percentile, sorted};
pub use crate::methods::{MethodName, Run, Settings};
pub use crate::parse::parse_size;
pub use crate::prepared::Prepared;
pub use crate::render_args::{AdapterArgs, SubmissionName};
pub use crate::suite::{check_suite, open_flight};

use crate::cli::{Cli, Command};
use crate::output::print;

/// Does what a command line asks for; its first argument is the program's name.
pub fn main_with(args: impl IntoIterator<Item = OsString>) -> ExitCode {
    let cli = match Cli::try_parse_from(args) {
        Ok(cli) => cli,
        Err(error) => return refuse(&error),
    };
    let result = match &cli.command {
        Command::Bench(args) => bench::run(args),
        Command::Mesh(args) => mesh::run(args),
        Command::Cmp(args) => cmp::run(args),
        Command::Report(args) => report::run(args),
        Command::Dem(args) => dem::run(args),
        Command::Adapters(args) => list_adapters(args),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(fault) => {
            eprintln!("error: {fault}");
            ExitCode::from(fault.cause as u8)
        }
    }
}

/// Help and version as clap prints them; an error as its first line, which says what was found and expected.
fn refuse(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        return match print(&error.to_string()) {
            Ok(()) => ExitCode::SUCCESS,
            Err(fault) => ExitCode::from(fault.cause as u8),
        };
    }
    if error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        eprintln!("error: no command; expected bench, report, cmp, mesh, adapters or dem; --help has examples");
        return ExitCode::from(Cause::Usage as u8);
    }
    let text = error.to_string();
    let lines: Vec<&str> = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:")).collect();
    let said: Vec<&str> = lines.into_iter().filter(|line| !line.is_empty() && !line.starts_with("For more")).collect();
    eprintln!("{}; --help has examples", said.join(" "));
    ExitCode::from(Cause::Usage as u8)
}

/// Lists all adapters with a mark at the one that the bench takes; xtask goes by the exit code.
fn list_adapters(args: &AdapterArgs) -> Result<(), Fault> {
    let describe = |adapter: &ListedAdapter| {
        let AdapterFacts { name, adapter_type, backend, driver, .. } = &adapter.facts;
        let mark = if adapter.chosen { "*" } else { " " };
        format!("{mark} {name} ({adapter_type}, {backend}), {driver}\n")
    };
    let adapters = args.choice().list()?;
    print(&adapters.iter().map(describe).collect::<String>())?;
    match adapters.iter().any(|adapter| adapter.chosen) {
        true => Ok(()),
        false => {
            Err(Fault::new(Cause::Gpu, "none of these would be chosen; install a Vulkan driver, or name one of them"))
        }
    }
}
