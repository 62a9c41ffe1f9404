//! What is kept from one start to the next: the methods, the look, which parts of the interface are there.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use terrain_lod::Run;
use terrain_renderer::Normals;

use crate::command::{Mode, Side};
use crate::run_text;
use crate::state::{Open, Shown, State};

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Kept {
    /// As `--left` and `--right`.
    pub left: Option<String>,
    pub right: Option<String>,
    pub mode: Mode,
    pub wireframe: bool,
    pub normals_per_vertex: bool,
    pub mark_stale: bool,
    pub boxes: bool,
    /// The side that is shown alone.
    pub alone: Option<Side>,
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
            normals_per_vertex: false,
            mark_stale: false,
            boxes: false,
            alone: None,
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

    pub fn of(state: &State, runs: [&Run; 2]) -> Self {
        let State { mode, wireframe, mark_stale, boxes, error_scale_px, sun_deg, divider, rig, open, .. } = state;
        let [left, right] = runs.map(|run| Some(run_text::of(run)));
        Self {
            left,
            right,
            mode: *mode,
            wireframe: *wireframe,
            normals_per_vertex: state.normals == Normals::PerVertex,
            mark_stale: *mark_stale,
            boxes: *boxes,
            alone: state.shown.alone(),
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
        (state.mark_stale, state.boxes) = (self.mark_stale, self.boxes);
        state.normals = if self.normals_per_vertex { Normals::PerVertex } else { Normals::PerPixel };
        state.shown = self.alone.map_or(Shown::Both, Shown::One);
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
    use terrain_core::Heightmap;

    use super::*;
    use crate::camera::Rig;

    /// All that keys switch over the terrain is there again at the next start.
    #[test]
    fn what_was_switched_on_stays_on() {
        let state = || State::new(Rig::over(&Heightmap::new(2, 2, [1.0; 2], vec![0.0; 4]).unwrap()));
        let run = run_text::parse("tin").unwrap();
        let mut before = state();
        (before.mark_stale, before.boxes, before.wireframe) = (true, true, true);
        (before.normals, before.shown, before.mode) = (Normals::PerVertex, Shown::One(Side::Right), Mode::Cell);
        (before.open.map, before.rig.above_ground) = (false, false);
        let kept = Kept::of(&before, [&run, &run]);
        let mut after = state();
        assert_ne!(Kept::of(&after, [&run, &run]), kept);
        kept.put(&mut after, true);
        assert_eq!(Kept::of(&after, [&run, &run]), kept);
        let text = toml::to_string(&kept).unwrap();
        assert_eq!(toml::from_str::<Kept>(&text).unwrap(), kept);
    }

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
