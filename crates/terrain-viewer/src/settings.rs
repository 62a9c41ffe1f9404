//! What is kept from one start to the next: the methods, the look, which parts of the interface are there.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::command::Mode;
use crate::run_text;
use crate::state::{Open, State};
use crate::viewer::Viewer;

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Kept {
    /// As `--left` and `--right`.
    pub left: Option<String>,
    pub right: Option<String>,
    pub mode: Mode,
    pub wireframe: bool,
    pub error_scale_px: f64,
    pub sun_deg: [f64; 2],
    pub divider: f64,
    pub above_ground: bool,
    pub open: Open,
}

impl Default for Kept {
    fn default() -> Self {
        Self {
            left: None,
            right: None,
            mode: Mode::Shaded,
            wireframe: false,
            error_scale_px: 2.0,
            sun_deg: [310.0, 35.0],
            divider: 0.5,
            above_ground: true,
            open: Open::default(),
        }
    }
}

impl Kept {
    /// The settings of the last time. What cannot be read is as good as none: they are a convenience.
    pub fn read(path: &Path) -> Self {
        fs::read_to_string(path).ok().and_then(|text| toml::from_str(&text).ok()).unwrap_or_default()
    }

    pub fn write(&self, path: &Path) -> std::io::Result<()> {
        path.parent().map_or(Ok(()), fs::create_dir_all)?;
        fs::write(path, toml::to_string(self).expect("settings become TOML"))
    }

    pub fn of(viewer: &Viewer) -> Self {
        let State { mode, wireframe, error_scale_px, sun_deg, divider, rig, open, .. } = &viewer.state;
        let [left, right] = viewer.panes.each_ref().map(|pane| Some(run_text::of(&pane.wanted)));
        Self {
            left,
            right,
            mode: *mode,
            wireframe: *wireframe,
            error_scale_px: *error_scale_px,
            sun_deg: *sun_deg,
            divider: *divider,
            above_ground: rig.above_ground,
            open: *open,
        }
    }

    /// Sets all but the methods; numbers that make no sense stay as they were.
    pub fn put(&self, state: &mut State, can_wireframe: bool) {
        (state.mode, state.open) = (self.mode, self.open);
        (state.wireframe, state.rig.above_ground) = (self.wireframe && can_wireframe, self.above_ground);
        if (0.1..=32.0).contains(&self.error_scale_px) {
            state.error_scale_px = self.error_scale_px;
        }
        if self.sun_deg.iter().all(|angle| (0.0..=360.0).contains(angle)) {
            state.sun_deg = self.sun_deg;
        }
        if (0.02..=0.98).contains(&self.divider) {
            state.divider = self.divider;
        }
    }
}

/// Where the system keeps the settings of programs; `None` where it does not say.
pub fn usual_path() -> Option<PathBuf> {
    let set = |name: &str| std::env::var_os(name).filter(|value| !value.is_empty()).map(PathBuf::from);
    let folder = match std::env::consts::OS {
        "windows" => set("APPDATA"),
        "macos" => set("HOME").map(|home| home.join("Library/Application Support")),
        _ => set("XDG_CONFIG_HOME").or_else(|| set("HOME").map(|home| home.join(".config"))),
    };
    folder.map(|folder| folder.join("terrain-viewer/settings.toml"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_come_back_and_broken_ones_are_none() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/settings.toml");
        assert_eq!(Kept::read(&path), Kept::default());
        let kept = Kept { left: Some("tin patch=16".into()), mode: Mode::Error, divider: 0.3, ..Kept::default() };
        kept.write(&path).unwrap();
        assert_eq!(Kept::read(&path), kept);
        fs::write(&path, "mode = 'sideways'").unwrap();
        assert_eq!(Kept::read(&path), Kept::default());
    }
}
