//! The panel: methods with their settings, the look, the flight.

use clap::ValueEnum;
use egui::{Align2, ComboBox, Context, DragValue, RichText, ScrollArea, Slider, Ui, Window};
use terrain_lod::{EdgePolicyName, MethodName, MetricName, Run, SelectorName, Settings, TriangulatorName, name_of};
use terrain_renderer::{Normals, Submission};

use crate::command::{Command, Mode, Side};
use crate::gui::{ACCENTS, FAINT};
use crate::interface::Interface;
use crate::state::State;

pub fn show(context: &Context, parts: &mut Interface) {
    let most_height = context.content_rect().height() - 250.0;
    Window::new("terrain-viewer").anchor(Align2::LEFT_TOP, [12.0, 12.0]).resizable(false).default_width(270.0).show(
        context,
        |ui| {
            ScrollArea::vertical().max_height(most_height.max(120.0)).show(ui, |ui| contents(ui, parts));
        },
    );
}

fn contents(ui: &mut Ui, parts: &mut Interface) {
    let Interface { state, panes, ground, commands, .. } = parts;
    let map = &ground.dem.heightmap;
    let facts = format!("{}   {} x {} samples", ground.spec, map.columns(), map.rows());
    ui.label(RichText::new(facts).small().color(FAINT));
    for ((side, id), (pane, accent)) in
        [(Side::Left, "left"), (Side::Right, "right")].into_iter().zip(panes.iter().zip(ACCENTS))
    {
        ui.separator();
        ui.push_id(id, |ui| {
            let mut run = pane.wanted;
            method_choice(ui, id, accent, &mut run);
            settings(ui, &mut run);
            if run != pane.wanted {
                commands.push(Command::Method(side, Box::new(run)));
            }
        });
    }
    ui.separator();
    look(ui, state, commands);
    ui.separator();
    flight(ui, state, commands);
}

fn method_choice(ui: &mut Ui, side: &str, accent: egui::Color32, run: &mut Run) {
    ui.horizontal(|ui| {
        ui.label(RichText::new(side).strong().color(accent));
        ComboBox::from_id_salt("method").width(150.0).selected_text(run.method.as_str()).show_ui(ui, |ui| {
            for method in MethodName::value_variants() {
                ui.selectable_value(&mut run.method, *method, method.as_str());
            }
        });
    });
}

/// What the method takes.
fn settings(ui: &mut Ui, run: &mut Run) {
    if run.takes_tolerance() {
        pixels(ui, "tolerance", &mut run.settings.tolerance_px, 0.1..=16.0);
    }
    match run.method {
        MethodName::Tin => tin(ui, &mut run.settings),
        MethodName::Htp | MethodName::HtpInstanced => htp(ui, run),
        MethodName::Decimated => {
            ui.add(Slider::new(&mut run.settings.step, 1..=32).text("step"));
        }
        MethodName::Greedy => distance(ui, &mut run.settings.distance_m),
        MethodName::FullGrid | MethodName::Rqt | MethodName::Geomipmap => {}
    }
}

fn tin(ui: &mut Ui, settings: &mut Settings) {
    choice(ui, "selector", &mut settings.selector);
    row(ui, "patch", |ui| {
        for side in [8, 16, 32, 64] {
            ui.selectable_value(&mut settings.patch, side, side.to_string());
        }
    });
    optional_number(ui, "largest spacing", &mut settings.max_spacing, settings.patch / 2, 1..=settings.patch);
    optional_number(ui, "largest group", &mut settings.group, 1, 1..=64 / settings.patch.min(64));
    if settings.selector == SelectorName::Algorithm1 {
        choice(ui, "triangulator", &mut settings.triangulator);
        choice(ui, "edges", &mut settings.edge_policy);
        optional_number(ui, "jitter, seed", &mut settings.jitter, 1, 0..=9999);
        ui.checkbox(&mut settings.smoothing, "smooth heights");
    } else {
        // The bounded selector knows these alone.
        (settings.triangulator, settings.edge_policy) = (TriangulatorName::Grid, EdgePolicyName::Matched);
        (settings.jitter, settings.smoothing) = (None, false);
        ui.checkbox(&mut settings.blocks, "blocks near the eye");
    }
    choice(ui, "schedule", &mut settings.schedule);
    choice(ui, "index store", &mut settings.index_store);
    ui.add(Slider::new(&mut settings.threads, 1..=8).text("threads"));
}

fn htp(ui: &mut Ui, run: &mut Run) {
    if !run.takes_tolerance() {
        pixels(ui, "leg", &mut run.settings.leg_px, 2.0..=64.0);
    }
    let settings = &mut run.settings;
    optional_choice(ui, "metric", &mut settings.metric);
    if run.method == MethodName::Htp {
        optional_choice(ui, "batching", &mut settings.batching);
    } else {
        settings.batching = None;
    }
    ui.add(Slider::new(&mut settings.k, 2..=8).text("k"));
    optional_number(ui, "layers", &mut settings.layers, 4, 1..=6);
    optional_number(ui, "window, MiB", &mut settings.window_mib, 64, 1..=1024);
    if settings.window_mib.is_some() {
        choice(ui, "loading", &mut settings.loading);
    }
    if settings.metric == Some(MetricName::Distance) {
        ui.checkbox(&mut settings.geomorph, "geomorph");
    } else {
        settings.geomorph = false;
    }
}

/// From the camera to where the tolerance counts.
fn distance(ui: &mut Ui, metres: &mut Option<f64>) {
    ui.horizontal(|ui| {
        let mut is_set = metres.is_some();
        ui.checkbox(&mut is_set, "at a distance of");
        *metres = is_set.then(|| metres.unwrap_or(1000.0));
        if let Some(metres) = metres {
            ui.add(DragValue::new(metres).range(1.0..=1e6).speed(10.0).suffix(" m"));
        }
    });
}

fn row(ui: &mut Ui, name: &str, add: impl FnOnce(&mut Ui)) {
    ui.horizontal(|ui| {
        ui.add_sized([78.0, 18.0], egui::Label::new(name).halign(egui::Align::Min));
        add(ui);
    });
}

fn choice<T: ValueEnum + Copy + PartialEq>(ui: &mut Ui, name: &str, chosen: &mut T) {
    row(ui, name, |ui| {
        ComboBox::from_id_salt(name).width(130.0).selected_text(name_of(*chosen)).show_ui(ui, |ui| {
            for value in T::value_variants() {
                ui.selectable_value(chosen, *value, name_of(*value));
            }
        });
    });
}

/// The same with a default that the other settings decide.
fn optional_choice<T: ValueEnum + Copy + PartialEq>(ui: &mut Ui, name: &str, chosen: &mut Option<T>) {
    let text = |value: Option<T>| value.map_or_else(|| "by the method".to_owned(), name_of);
    row(ui, name, |ui| {
        ComboBox::from_id_salt(name).width(130.0).selected_text(text(*chosen)).show_ui(ui, |ui| {
            ui.selectable_value(chosen, None, text(None));
            for value in T::value_variants() {
                ui.selectable_value(chosen, Some(*value), name_of(*value));
            }
        });
    });
}

fn optional_number(
    ui: &mut Ui,
    name: &str,
    number: &mut Option<u32>,
    usual: u32,
    range: std::ops::RangeInclusive<u32>,
) {
    ui.horizontal(|ui| {
        let mut is_set = number.is_some();
        ui.checkbox(&mut is_set, name);
        *number = is_set.then(|| number.unwrap_or(usual));
        if let Some(number) = number {
            ui.add(DragValue::new(number).range(range));
        }
    });
}

fn pixels(ui: &mut Ui, name: &str, px: &mut f64, range: std::ops::RangeInclusive<f64>) {
    ui.add(Slider::new(px, range).logarithmic(true).max_decimals(2).suffix(" px").text(name));
}

fn look(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    ui.horizontal_wrapped(|ui| {
        for mode in Mode::ALL {
            if ui.selectable_label(state.mode == mode, mode.name()).clicked() {
                commands.push(Command::Mode(mode));
            }
        }
    });
    if state.mode == Mode::Error {
        let mut scale_px = state.error_scale_px;
        ui.add(Slider::new(&mut scale_px, 0.1..=32.0).logarithmic(true).max_decimals(2).suffix(" px").text("red is"));
        push_changed(commands, scale_px, state.error_scale_px, Command::ErrorScale);
    }
    ui.horizontal_wrapped(|ui| {
        toggle(ui, commands, state.wireframe, "wireframe", Command::Wireframe);
        toggle(ui, commands, state.normals == Normals::PerVertex, "normals per vertex", Command::Normals);
        toggle(ui, commands, state.mark_stale, "mark stale", Command::Stale);
        toggle(ui, commands, state.boxes, "boxes", Command::Boxes);
        toggle(ui, commands, state.frozen.is_some(), "freeze", Command::Freeze);
        toggle(ui, commands, state.rig.above_ground, "above ground", Command::AboveGround);
        toggle(ui, commands, state.rig.orbit.is_some(), "orbit", Command::Orbit);
        let is_multi = state.submission == Submission::MultiIndirect;
        let other = if is_multi { Submission::Direct } else { Submission::MultiIndirect };
        toggle(ui, commands, is_multi, "multi-draw", Command::Submission(other));
    });
    let mut sun_deg = state.sun_deg;
    ui.add(Slider::new(&mut sun_deg[0], 0.0..=360.0).max_decimals(0).suffix("°").text("sun from"));
    ui.add(Slider::new(&mut sun_deg[1], 5.0..=90.0).max_decimals(0).suffix("°").text("sun height"));
    push_changed(commands, sun_deg, state.sun_deg, Command::Sun);
    let mut times = state.exaggeration;
    ui.horizontal(|ui| {
        ui.label("heights");
        for factor in [1.0, 2.0, 3.0, 5.0] {
            ui.selectable_value(&mut times, factor, format!("x {factor}"));
        }
    });
    push_changed(commands, times, state.exaggeration, Command::Exaggeration);
}

fn toggle(ui: &mut Ui, commands: &mut Vec<Command>, is_on: bool, name: &str, command: Command) {
    if ui.selectable_label(is_on, name).clicked() {
        commands.push(command);
    }
}

fn push_changed<T: PartialEq>(commands: &mut Vec<Command>, value: T, before: T, command: fn(T) -> Command) {
    if value != before {
        commands.push(command(value));
    }
}

fn flight(ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
    ui.horizontal(|ui| {
        let is_playing = state.flight.as_ref().is_some_and(|flight| flight.is_playing);
        toggle(ui, commands, is_playing, if is_playing { "pause" } else { "play" }, Command::Play);
        let recording =
            state.recorder.as_ref().map_or("record".into(), |recorder| format!("end  {:.1} s", recorder.seconds()));
        toggle(ui, commands, state.recorder.is_some(), &recording, Command::Record);
        let name = state.flight.as_ref().map_or("no flight", |flight| flight.name.as_str());
        ui.label(RichText::new(name).color(FAINT));
    });
    if let Some(flight) = &state.flight {
        let mut frame = flight.frame();
        ui.add(Slider::new(&mut frame, 0..=flight.last()).text("frame"));
        push_changed(commands, frame, flight.frame(), Command::Scrub);
    }
}
