//! GPU set-up on Linux: where no adapter is found, Mesa's software Vulkan driver is installed, offered or named.
//!
//! macOS and Windows bring Metal and DX12 along. What to do is decided by a pure function of a few facts; nothing here
//! is fatal, since the bench can go on without a GPU.

use std::io::{self, IsTerminal};
use std::path::Path;
use std::process::{Command, Stdio};

/// Exit code of `terrain-lod adapters` where there is none.
const NO_ADAPTER: i32 = 5;

/// How a platform installs the Vulkan loader and Mesa's software driver.
#[derive(Debug, PartialEq)]
struct PackageManager {
    program: &'static str,
    commands: &'static [&'static [&'static str]],
}

#[rustfmt::skip]
const PACKAGE_MANAGERS: [PackageManager; 5] = [
    PackageManager {
        program: "apt-get",
        commands: &[
            &["apt-get", "update"],
            &["apt-get", "install", "-y", "--no-install-recommends", "libvulkan1", "mesa-vulkan-drivers"],
        ],
    },
    PackageManager { program: "dnf", commands: &[&["dnf", "install", "-y", "vulkan-loader", "mesa-vulkan-drivers"]] },
    PackageManager { program: "pacman", commands: &[&["pacman", "-S", "--needed", "--noconfirm", "vulkan-icd-loader", "vulkan-swrast"]] },
    PackageManager { program: "zypper", commands: &[&["zypper", "--non-interactive", "install", "libvulkan1", "libvulkan_lvp"]] },
    PackageManager { program: "apk", commands: &[&["apk", "add", "vulkan-loader", "mesa-vulkan-swrast"]] },
];

/// A display without a screen, and the libraries that a window opens: for the viewer's tests.
const DISPLAY: PackageManager = PackageManager {
    program: "apt-get",
    commands: &[
        &["apt-get", "update"],
        &[
            "apt-get",
            "install",
            "-y",
            "--no-install-recommends",
            "xvfb",
            "libx11-xcb1",
            "libxcursor1",
            "libxi6",
            "libxkbcommon-x11-0",
            "libxrandr2",
        ],
    ],
};

impl PackageManager {
    /// One line to paste into a shell.
    fn command_line(&self, sudo: bool) -> String {
        let prefix = if sudo { "sudo " } else { "" };
        let commands: Vec<String> = self.commands.iter().map(|words| prefix.to_string() + &words.join(" ")).collect();
        commands.join(" && ")
    }
}

/// All that the decision depends on.
struct Facts {
    linux: bool,
    adapter: bool,
    root: bool,
    sudo: bool,
    /// Whether a person can be asked.
    terminal: bool,
    manager: Option<&'static PackageManager>,
}

#[derive(Debug, PartialEq)]
enum Action {
    Nothing,
    Install(&'static PackageManager),
    AskThenInstall(&'static PackageManager),
    /// Print the command; with `sudo` where the user is not root.
    Print {
        manager: &'static PackageManager,
        sudo: bool,
    },
    /// No package manager that we know.
    PrintInWords,
}

/// Only root with apt is served unasked: that is a container or CI. Everywhere else the system is somebody's own.
fn decide(facts: &Facts) -> Action {
    if !facts.linux || facts.adapter {
        return Action::Nothing;
    }
    match facts.manager {
        None => Action::PrintInWords,
        Some(manager) if facts.root && manager.program == "apt-get" => Action::Install(manager),
        Some(manager) if !facts.root && facts.sudo && facts.terminal => Action::AskThenInstall(manager),
        Some(manager) => Action::Print { manager, sudo: !facts.root },
    }
}

/// Sees to a GPU adapter, as far as that can be done here, and returns whether there is one.
pub fn ensure_adapter(program: &Path) -> bool {
    let facts = Facts::gather(program);
    match carry_out(decide(&facts)) {
        Outcome::Unchanged => facts.adapter,
        Outcome::Installed => has_adapter(program),
    }
}

/// Sees to a display for the viewer's tests where that can be done unasked; elsewhere they are skipped, and say so.
pub fn ensure_display() {
    let is_ours = cfg!(target_os = "linux") && is_root() && on_path(DISPLAY.program);
    if is_ours && !on_path("Xvfb") {
        eprintln!("xtask: no Xvfb: installing it: {}", DISPLAY.command_line(false));
        install(&DISPLAY, false);
    }
}

impl Facts {
    fn gather(program: &Path) -> Self {
        let linux = cfg!(target_os = "linux");
        let ci = std::env::var_os("CI").is_some();
        Self {
            linux,
            adapter: !linux || has_adapter(program),
            root: is_root(),
            sudo: on_path("sudo"),
            terminal: !ci && io::stdin().is_terminal() && io::stderr().is_terminal(),
            manager: PACKAGE_MANAGERS.iter().find(|manager| on_path(manager.program)),
        }
    }
}

/// False only where the program says so: where it fails in another way, no package will help, and its next run tells.
fn has_adapter(program: &Path) -> bool {
    let status = Command::new(program).arg("adapters").stdout(Stdio::null()).stderr(Stdio::null()).status();
    !matches!(status.map(|status| status.code()), Ok(Some(NO_ADAPTER)))
}

fn is_root() -> bool {
    Command::new("id").arg("-u").output().is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

fn on_path(program: &str) -> bool {
    let folders = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&folders).any(|folder| folder.join(program).is_file())
}

#[derive(Debug, PartialEq)]
enum Outcome {
    Unchanged,
    Installed,
}

fn carry_out(action: Action) -> Outcome {
    match action {
        Action::Nothing => Outcome::Unchanged,
        Action::Install(manager) => {
            eprintln!("xtask: no GPU adapter: installing a software one: {}", manager.command_line(false));
            install(manager, false)
        }
        Action::AskThenInstall(manager) => {
            eprint!("xtask: no GPU adapter. Install a software one with `{}`? [Y/n] ", manager.command_line(true));
            if user_agrees() { install(manager, true) } else { Outcome::Unchanged }
        }
        Action::Print { manager, sudo } => {
            eprintln!("xtask: no GPU adapter; this installs a software one: {}", manager.command_line(sudo));
            Outcome::Unchanged
        }
        Action::PrintInWords => {
            eprintln!("xtask: no GPU adapter; install the Vulkan loader and Mesa's software driver (lavapipe)");
            Outcome::Unchanged
        }
    }
}

fn user_agrees() -> bool {
    let mut answer = String::new();
    io::stdin().read_line(&mut answer).is_ok() && is_yes(&answer)
}

/// Return alone is yes; the end of input (no line at all) is no.
fn is_yes(answer: &str) -> bool {
    !answer.is_empty() && matches!(answer.trim().to_lowercase().as_str(), "" | "y" | "yes")
}

/// Every command is tried: one broken source makes `update` fail and leaves the packages within reach. What counts is
/// the last command, which installs.
fn install(manager: &PackageManager, sudo: bool) -> Outcome {
    let mut outcome = Outcome::Unchanged;
    for words in manager.commands {
        let words: Vec<&str> = sudo.then_some("sudo").into_iter().chain(words.iter().copied()).collect();
        outcome = match run_installer(&words) {
            Ok(()) => Outcome::Installed,
            Err(reason) => {
                eprintln!("xtask: failed: {}: {reason}", words.join(" "));
                Outcome::Unchanged
            }
        };
    }
    outcome
}

/// Runs one command of a package manager. Its output goes to stderr: stdout belongs to the bench's data.
fn run_installer(words: &[&str]) -> Result<(), String> {
    let status = Command::new(words[0])
        .args(&words[1..])
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null())
        .stdout(io::stderr())
        .status()
        .map_err(|error| error.to_string())?;
    if status.success() { Ok(()) } else { Err(status.to_string()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    const APT: &PackageManager = &PACKAGE_MANAGERS[0];
    const DNF: &PackageManager = &PACKAGE_MANAGERS[1];

    /// A user's Debian desktop without an adapter.
    fn desktop() -> Facts {
        Facts { linux: true, adapter: false, root: false, sudo: true, terminal: true, manager: Some(APT) }
    }

    #[test]
    fn nothing_is_done_where_there_is_an_adapter_or_no_linux() {
        assert_eq!(decide(&Facts { adapter: true, ..desktop() }), Action::Nothing);
        assert_eq!(decide(&Facts { linux: false, ..desktop() }), Action::Nothing);
        assert_eq!(decide(&Facts { adapter: true, root: true, ..desktop() }), Action::Nothing);
    }

    #[test]
    fn root_with_apt_installs_unasked() {
        let container = Facts { root: true, sudo: false, terminal: false, ..desktop() };
        assert_eq!(decide(&container), Action::Install(APT));
        assert_eq!(decide(&Facts { root: true, ..desktop() }), Action::Install(APT));
    }

    #[test]
    fn a_user_on_a_terminal_with_sudo_is_asked() {
        assert_eq!(decide(&desktop()), Action::AskThenInstall(APT));
        assert_eq!(decide(&Facts { manager: Some(DNF), ..desktop() }), Action::AskThenInstall(DNF));
    }

    #[test]
    fn everyone_else_gets_the_command() {
        let print = |manager, sudo| Action::Print { manager, sudo };
        assert_eq!(decide(&Facts { terminal: false, ..desktop() }), print(APT, true));
        assert_eq!(decide(&Facts { sudo: false, ..desktop() }), print(APT, true));
        assert_eq!(decide(&Facts { root: true, manager: Some(DNF), ..desktop() }), print(DNF, false));
        assert_eq!(decide(&Facts { manager: None, ..desktop() }), Action::PrintInWords);
        assert_eq!(decide(&Facts { root: true, manager: None, ..desktop() }), Action::PrintInWords);
    }

    #[test]
    fn the_command_is_one_line_to_paste() {
        let apt = "sudo apt-get update && \
                   sudo apt-get install -y --no-install-recommends libvulkan1 mesa-vulkan-drivers";
        assert_eq!(APT.command_line(true), apt);
        assert_eq!(DNF.command_line(false), "dnf install -y vulkan-loader mesa-vulkan-drivers");
    }

    #[test]
    fn answers() {
        assert!(is_yes("\n") && is_yes("y\n") && is_yes("YES\n"));
        assert!(!is_yes("") && !is_yes("n\n") && !is_yes("what\n"));
    }

    #[test]
    fn a_failing_installer_is_told_and_not_fatal() {
        const BROKEN: PackageManager = PackageManager { program: "none", commands: &[&["no-such-installer", "x"]] };
        assert_eq!(install(&BROKEN, false), Outcome::Unchanged);
    }

    #[cfg(unix)]
    #[test]
    fn a_failing_update_does_not_keep_from_installing() {
        const STALE: PackageManager = PackageManager { program: "none", commands: &[&["false"], &["true"]] };
        assert_eq!(install(&STALE, false), Outcome::Installed);
    }

    #[cfg(unix)]
    #[test]
    fn only_exit_code_5_means_no_adapter() {
        // `false adapters` ends with 1: a program that fails in its own way.
        assert!(has_adapter(Path::new("false")));
        assert!(has_adapter(Path::new("true")));
        assert!(has_adapter(Path::new("no-such-program")));
    }
}
