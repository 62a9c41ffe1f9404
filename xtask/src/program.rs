//! Builds the programs and runs them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use serde_json::Value;

use crate::Fault;

/// Builds `terrain-lod` in release and returns where it is.
pub fn build() -> Result<PathBuf, Fault> {
    build_with("terrain-lod", &["build", "--release", "--package", "terrain-lod"])
}

/// Builds all that the tests need and returns where `terrain-lod` is among it. Building it alone would give its
/// dependencies other features than the tests do, and compile them twice.
pub fn build_tests() -> Result<PathBuf, Fault> {
    build_with("terrain-lod", &["test", "--locked", "--workspace", "--no-run"])
}

/// Builds `terrain-viewer` in release and returns where it is.
pub fn build_viewer() -> Result<PathBuf, Fault> {
    build_with("terrain-viewer", &["build", "--release", "--package", "terrain-viewer"])
}

/// Builds a program, cargo's progress on stderr.
///
/// Asking cargo for the path holds for every target folder and target triple. `cargo run` would find it too, but mixes
/// the exit codes of cargo with the program's.
fn build_with(name: &str, args: &[&str]) -> Result<PathBuf, Fault> {
    let output = cargo()
        .args(args)
        .arg("--message-format=json-render-diagnostics")
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| Fault::failure(format!("cannot start cargo: {error}")))?;
    if !output.status.success() {
        return Err(Fault::failure(format!("{name} does not build")));
    }
    executable_in(&String::from_utf8_lossy(&output.stdout), name)
        .ok_or_else(|| Fault::failure(format!("cargo built {name} but did not say where")))
}

/// The cargo that runs us, at the top of the workspace.
pub fn cargo() -> Command {
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.current_dir(workspace_root());
    cargo
}

/// Cargo says at run time where the sources are; what was true at compile time may have moved.
pub fn workspace_root() -> PathBuf {
    let xtask = std::env::var_os("CARGO_MANIFEST_DIR").unwrap_or_else(|| env!("CARGO_MANIFEST_DIR").into());
    Path::new(&xtask).parent().expect("xtask is a folder of the workspace").to_path_buf()
}

/// The path of a program in cargo's messages; its unit tests are an executable of the same name.
fn executable_in(messages: &str, name: &str) -> Option<PathBuf> {
    let messages = messages.lines().filter_map(|line| serde_json::from_str::<Value>(line).ok());
    let is_program = |message: &Value| message["target"]["name"] == name && message["profile"]["test"] == false;
    messages.filter(is_program).find_map(|message| Some(message["executable"].as_str()?.into()))
}

/// Replaces xtask by the program: signals, Ctrl-C and exit code are then the program's own, with nobody in between who
/// could end before it has marked its results as incomplete. Returns only where it could not start.
#[cfg(unix)]
pub fn become_program(program: &Path, args: &[OsString]) -> Fault {
    use std::os::unix::process::CommandExt;
    cannot_start(program, &command(program, args).exec())
}

/// Runs the program and ends with its exit code. Returns only where it could not start.
#[cfg(not(unix))]
pub fn become_program(program: &Path, args: &[OsString]) -> Fault {
    match command(program, args).status() {
        Ok(status) => std::process::exit(exit_code(status)),
        Err(error) => cannot_start(program, &error),
    }
}

/// Without a desktop, Mesa's device-select layer asks Wayland which GPU draws the screen, and prints an error that
/// there is no Wayland. The program chooses its adapter itself, so the layer is switched off.
pub fn command(program: &Path, args: &[OsString]) -> Command {
    let mut command = Command::new(program);
    command.args(args);
    if std::env::var_os("WAYLAND_DISPLAY").is_none() {
        command.env("NODEVICE_SELECT", "1");
    }
    command
}

pub fn cannot_start(program: &Path, error: &std::io::Error) -> Fault {
    Fault::failure(format!("cannot start {}: {error}", program.display()))
}

/// The exit code as a shell gives it: 128 + n for a program that signal n ended.
pub fn exit_code(status: ExitStatus) -> i32 {
    #[cfg(unix)]
    if let Some(signal) = std::os::unix::process::ExitStatusExt::signal(&status) {
        return 128 + signal;
    }
    status.code().unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_program_is_found_among_cargos_messages() {
        let messages = concat!(
            r#"{"reason":"compiler-artifact","target":{"name":"csv"},"profile":{"test":false},"executable":null}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"terrain_lod"},"profile":{"test":false},"executable":null}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"terrain-lod"},"profile":{"test":true},"executable":"/a/t-1"}"#,
            "\n",
            r#"{"reason":"compiler-artifact","target":{"name":"terrain-lod"},"profile":{"test":false},"executable":"C:\\a \"b\"\\t"}"#,
            "\n",
            r#"{"reason":"build-finished","success":true}"#,
        );
        assert_eq!(executable_in(messages, "terrain-lod"), Some(r#"C:\a "b"\t"#.into()));
        assert_eq!(executable_in(r#"{"reason":"build-finished","success":true}"#, "terrain-lod"), None);
    }

    #[cfg(unix)]
    #[test]
    fn exit_codes_as_a_shell_gives_them() {
        let status = |script: &str| Command::new("sh").args(["-c", script]).status().unwrap();
        assert_eq!(exit_code(status("exit 5")), 5);
        assert_eq!(exit_code(status("kill -9 $$")), 137);
    }
}
