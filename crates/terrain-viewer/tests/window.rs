//! The window itself, under Xvfb. Skipped where there is no such thing, or no graphics adapter.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, Command, Output, Stdio};

/// An X server without a screen; ended with the test.
struct Display {
    server: Child,
    name: String,
}

impl Display {
    fn open() -> Option<Self> {
        let server = Command::new("Xvfb")
            .args(["-displayfd", "1", "-screen", "0", "1280x800x24", "-nolisten", "tcp"])
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn();
        let Ok(mut server) = server else {
            skip("there is no Xvfb (apt install xvfb)");
            return None;
        };
        let mut line = String::new();
        let output = server.stdout.take().expect("piped");
        BufReader::new(output).read_line(&mut line).unwrap();
        let display = Self { server, name: format!(":{}", line.trim()) };
        if line.trim().is_empty() {
            skip("Xvfb does not start");
            return None;
        }
        Some(display)
    }
}

/// Not by `eprintln!`, which the test harness captures.
fn skip(why: &str) {
    let mut stderr = std::io::stderr();
    writeln!(stderr, "skipped: {why}").unwrap();
}

impl Drop for Display {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

/// Opens the viewer for a few frames; `None` with a message where it cannot be opened here.
fn view(args: &[&str], settings: &std::path::Path) -> Option<Output> {
    let display = Display::open()?;
    let output = Command::new(env!("CARGO_BIN_EXE_terrain-viewer"))
        .args(["--exit-after", "5", "--size", "640x360"])
        .args(args)
        .env("DISPLAY", &display.name)
        .env_remove("WAYLAND_DISPLAY")
        .env("NODEVICE_SELECT", "1")
        .env("XDG_CONFIG_HOME", settings)
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(5) && (stderr.contains("adapter") || stderr.contains("window")) {
        skip(&stderr);
        return None;
    }
    assert!(output.status.success(), "{stderr}");
    Some(output)
}

#[test]
fn a_window_opens_draws_and_keeps_its_settings() {
    let settings = tempfile::tempdir().unwrap();
    let Some(output) = view(&["--left", "tin patch=16"], settings.path()) else { return };
    assert!(String::from_utf8_lossy(&output.stdout).starts_with("first frame after "));
    let kept = std::fs::read_to_string(settings.path().join("terrain-viewer/settings.toml"));
    if cfg!(target_os = "linux") {
        assert!(kept.unwrap().contains("left = \"tin patch=16\""));
    }
}

#[test]
fn without_a_display_it_says_so() {
    if !cfg!(target_os = "linux") {
        return;
    }
    let output = Command::new(env!("CARGO_BIN_EXE_terrain-viewer"))
        .args(["--exit-after", "1", "--no-settings"])
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY")
        .env_remove("WAYLAND_SOCKET")
        .output()
        .unwrap();
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{stderr}");
    assert!(stderr.starts_with("error: cannot open a window: ") && stderr.contains("--headless-script"), "{stderr}");
}
