//! `cargo xtask test`: everything that must pass.

use crate::program;
use crate::{Fault, setup};

/// One cargo command that must succeed.
struct Step {
    name: &'static str,
    args: &'static [&'static str],
    /// Environment variable and value.
    env: Option<(&'static str, &'static str)>,
    /// Whether a missing GPU adapter is set up first.
    draws: bool,
}

/// The quick ones first. None may change `Cargo.lock`.
#[rustfmt::skip]
const STEPS: [Step; 4] = [
    Step { name: "format", args: &["fmt", "--all", "--check"], env: None, draws: false },
    Step {
        name: "lints",
        args: &["clippy", "--locked", "--workspace", "--all-targets", "--", "-D", "warnings"],
        env: None,
        draws: false,
    },
    Step { name: "tests", args: &["test", "--locked", "--workspace"], env: None, draws: true },
    Step {
        name: "documentation",
        args: &["doc", "--locked", "--workspace", "--no-deps"],
        env: Some(("RUSTDOCFLAGS", "-D warnings")),
        draws: false,
    },
];

/// Runs all steps up to the first that fails.
pub fn run(gpu_set_up: bool) -> Result<(), Fault> {
    require_components()?;
    for step in &STEPS {
        if step.draws && gpu_set_up {
            set_up_gpu()?;
        }
        run_step(step)?;
    }
    eprintln!("xtask: all of {} passed", STEPS.map(|step| step.name).join(", "));
    Ok(())
}

/// A minimal toolchain has neither; cargo's own message names no remedy where rustup did not install it.
fn require_components() -> Result<(), Fault> {
    for component in ["fmt", "clippy"] {
        let output = program::cargo().args([component, "--version"]).output();
        if !output.is_ok_and(|output| output.status.success()) {
            let remedy = "add it with: rustup component add rustfmt clippy";
            return Err(Fault::failure(format!("`cargo {component}` is not installed; {remedy}")));
        }
    }
    Ok(())
}

/// An adapter for the renderer's tests, a display for the viewer's.
fn set_up_gpu() -> Result<(), Fault> {
    setup::ensure_display();
    if !setup::ensure_adapter(&program::build_tests()?) {
        eprintln!("xtask: no GPU adapter: the tests go on without");
    }
    Ok(())
}

fn run_step(step: &Step) -> Result<(), Fault> {
    eprintln!("xtask: {}: {}", step.name, step.command_line());
    let status = program::cargo().args(step.args).envs(step.env).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(_) => Err(Fault::failure(format!("{} failed: {}", step.name, step.command_line()))),
        Err(error) => Err(Fault::failure(format!("cannot start cargo: {error}"))),
    }
}

impl Step {
    /// As one would type it.
    fn command_line(&self) -> String {
        let env = self.env.map(|(name, value)| format!("{name}='{value}' ")).unwrap_or_default();
        format!("{env}cargo {}", self.args.join(" "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_shown_as_one_would_type_them() {
        let shown = STEPS.map(|step| step.command_line());
        assert_eq!(shown[0], "cargo fmt --all --check");
        assert_eq!(shown[3], "RUSTDOCFLAGS='-D warnings' cargo doc --locked --workspace --no-deps");
    }
}
