//! Runs the viewer by a script in a folder of its own.

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use image::RgbaImage;
use tempfile::TempDir;

/// Exit code of the viewer where no adapter can be used.
const NO_ADAPTER: i32 = 5;
pub const SIZE: [u32; 2] = [480, 270];

pub struct Stage {
    pub folder: TempDir,
}

impl Stage {
    /// Does a script; `None` with a message where there is no adapter.
    pub fn run(script: &str, args: &[&str]) -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let output = viewer(folder.path(), script, args);
        let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
        if output.status.code() == Some(NO_ADAPTER) && stderr.contains("adapter") {
            // Not `eprintln!`, which the test harness captures.
            let mut terminal = std::io::stderr();
            writeln!(terminal, "skipped: {stderr}").unwrap();
            return None;
        }
        assert!(output.status.success(), "{stderr}");
        Some(Self { folder })
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub fn picture(&self, name: &str) -> RgbaImage {
        image::open(self.path(name)).unwrap().to_rgba8()
    }

    pub fn numbers(&self, name: &str) -> toml::Table {
        toml::from_str(&std::fs::read_to_string(self.path(name)).unwrap()).unwrap()
    }
}

pub fn viewer(folder: &Path, script: &str, args: &[&str]) -> Output {
    std::fs::write(folder.join("script.txt"), script).unwrap();
    Command::new(env!("CARGO_BIN_EXE_terrain-viewer"))
        .current_dir(folder)
        .args(["--headless-script", "script.txt", "--size", &format!("{}x{}", SIZE[0], SIZE[1])])
        .args(args)
        .output()
        .unwrap()
}
