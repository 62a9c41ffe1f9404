//! The interface of one frame: it reads the state and says commands, and changes nothing itself.

use egui::Ui;
use terrain_core::View;
use terrain_renderer::AdapterFacts;

use crate::command::Command;
use crate::map::{self, Map};
use crate::memory::Memory;
use crate::pane::{Ground, Pane};
use crate::state::State;
use crate::times::Times;
use crate::{help, hud, overlay, panel};

/// What there is to show, and the commands that the user gives by it.
pub struct Interface<'a> {
    pub state: &'a State,
    pub panes: &'a [Pane; 2],
    pub ground: &'a Ground,
    pub times: &'a Times,
    pub memory: &'a Memory,
    pub map: &'a mut Map,
    pub adapter: &'a AdapterFacts,
    pub view: &'a View,
    pub commands: &'a mut Vec<Command>,
}

pub fn show(ui: &mut Ui, parts: &mut Interface) {
    let context = ui.ctx().clone();
    overlay::show(&context, parts);
    if parts.state.open.panel {
        panel::show(&context, parts);
    }
    if parts.state.open.hud {
        hud::show(&context, parts);
    }
    if parts.state.open.map {
        let Interface { map, state, panes, view, commands, .. } = parts;
        map.show(&context, &map::Shown { state, panes, view }, commands);
    }
    if parts.state.open.help {
        help::show(&context);
    }
}
