//! The command line.

use std::path::PathBuf;

use clap::Parser;
use terrain_lod::{AdapterArgs, ReadArgs, SubmissionName, parse_size};

/// Fly through a DEM with two methods side by side.
#[derive(Clone, Debug, Parser)]
#[command(name = "terrain-viewer", bin_name = "cargo xtask view", version, after_help = EXAMPLES)]
pub struct Cli {
    /// An elevation file, a built-in DEM (jacksboro), or synthetic:COLUMNSxROWS:SEED
    #[arg(value_name = "DEM", default_value = "jacksboro")]
    pub dem: String,
    #[command(flatten)]
    pub read: ReadArgs,
    /// The method on the left, with its settings by the names of suites [default: as last time, or else tin]
    #[arg(long, value_name = "METHOD KEY=VALUE ...")]
    pub left: Option<String>,
    /// The method on the right [default: as last time, or else htp-instanced]
    #[arg(long, value_name = "METHOD KEY=VALUE ...")]
    pub right: Option<String>,
    /// A flight in data/flights, or a TOML file: P plays it
    #[arg(long, value_name = "FILE")]
    pub flight: Option<String>,
    /// Where to start, as L copies it and F12 says it
    #[arg(long, value_name = "X,Y,Z,HEADING,PITCH,FOV", allow_hyphen_values = true)]
    pub camera: Option<String>,
    /// Size of the window, or of the pictures of a script
    #[arg(long, value_name = "WxH", value_parser = parse_size, default_value = "1280x720")]
    pub size: [u32; 2],
    /// How the draws are sent [default: direct]
    #[arg(long)]
    pub submission: Option<SubmissionName>,
    #[command(flatten)]
    pub adapter: AdapterArgs,
    /// Do what a file says, without a window: keys, waits, screenshots
    #[arg(long, value_name = "FILE")]
    pub headless_script: Option<PathBuf>,
    /// Where the flights and screenshots go that have no name
    #[arg(long, value_name = "DIR", default_value = ".")]
    pub out: PathBuf,
    /// Close the window after so many frames, and say when the first one was there
    #[arg(long, value_name = "N")]
    pub exit_after: Option<u32>,
    /// Neither read nor write the settings of the last time
    #[arg(long)]
    pub no_settings: bool,
}

const EXAMPLES: &str = "\
Examples:
  cargo xtask view
  cargo xtask view my.tif --flight my.toml
  cargo xtask view synthetic:1025x1025:7 --left 'tin selector=algorithm1 tolerance_px=0.5' --right full-grid
  cargo xtask view --headless-script data/scripts/readme.txt

H in the window lists all keys.";

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_well_formed() {
        Cli::command().debug_assert();
    }
}
