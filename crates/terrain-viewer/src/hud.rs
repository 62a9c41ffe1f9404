//! The numbers: what the bench counts and measures, by its code, of the frame that is on the screen.

use egui::{Align2, Color32, Context, Frame, Grid, Id, RichText, Sense, Stroke, Ui, Window, pos2, vec2};
use serde::Serialize;

use crate::command::Side;
use crate::gui::{ACCENTS, FAINT, INK};
use crate::interface::Interface;
use crate::overlay::title;
use crate::pane::Pane;
use crate::times::Times;

/// The numbers of one method, as the HUD shows them and scripts write them.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Numbers {
    pub method: String,
    pub triangles: u64,
    pub draws: u64,
    pub draw_calls: u32,
    pub upload_bytes: u64,
    pub uploaded_bytes: u64,
    pub buffer_bytes: u64,
    pub updated_patches: u64,
    pub stale_patches: u64,
    pub latency_ms: f64,
    pub unheld_px: f64,
    pub cells_due: u64,
    /// Of the last measurement; absent before the first, or without samples in view.
    pub error_px_max: Option<f64>,
    pub error_px_p99: Option<f64>,
    pub error_px_rms: Option<f64>,
    pub cracks: Option<u64>,
    /// How long ago the measured frame was drawn.
    pub measured_age_s: Option<f64>,
    /// Why nothing is measured.
    pub fault: Option<String>,
}

impl Numbers {
    /// `None` before the method is there.
    pub fn of(pane: &Pane) -> Option<Self> {
        let (run, counts) = (pane.run()?, pane.counts()?);
        let (measured, fault) = match pane.measured() {
            Some(Ok(measured)) => (Some(measured), None),
            Some(Err(fault)) => (None, Some(fault)),
            None => (None, None),
        };
        let row = measured.as_ref().map(|measured| &measured.row);
        Some(Self {
            method: run.method.as_str().into(),
            triangles: counts.stats.triangles,
            draws: counts.stats.draws,
            draw_calls: counts.draw_calls,
            upload_bytes: counts.stats.upload_bytes,
            uploaded_bytes: counts.uploaded,
            buffer_bytes: counts.buffer_bytes,
            updated_patches: counts.stats.updated_patches,
            stale_patches: counts.stats.stale_patches,
            latency_ms: counts.latency_ms,
            unheld_px: counts.unheld_px,
            cells_due: counts.cells_due,
            error_px_max: row.and_then(|row| row.error_px_max),
            error_px_p99: row.and_then(|row| row.error_px_p99),
            error_px_rms: row.and_then(|row| row.error_px_rms),
            cracks: row.map(|row| row.cracks),
            measured_age_s: measured.as_ref().map(|measured| measured.drawn.elapsed().as_secs_f64()),
            fault,
        })
    }
}

pub fn show(context: &Context, parts: &Interface) {
    let sides = [(Side::Left, Align2::LEFT_BOTTOM, 12.0), (Side::Right, Align2::RIGHT_BOTTOM, -12.0)];
    for ((side, align, x), (pane, accent)) in sides.into_iter().zip(parts.panes.iter().zip(ACCENTS)) {
        if parts.state.shown.includes(side) {
            card(context, Id::unique(("numbers", x as i32)), align, x, |ui| method_card(ui, pane, accent));
        }
    }
    card(context, Id::unique("times"), Align2::CENTER_BOTTOM, 0.0, |ui| times_card(ui, parts));
}

fn card(context: &Context, id: Id, align: Align2, x: f32, add: impl FnOnce(&mut Ui)) {
    Window::new("")
        .id(id)
        .title_bar(false)
        .resizable(false)
        .interactable(false)
        .anchor(align, [x, -12.0])
        .frame(Frame::window(&context.global_style()).inner_margin(10.0))
        .show(context, add);
}

fn method_card(ui: &mut Ui, pane: &Pane, accent: Color32) {
    ui.label(RichText::new(title(pane)).strong().color(accent));
    if let Some(fault) = &pane.fault {
        ui.set_max_width(300.0);
        ui.label(RichText::new(fault).color(crate::gui::FAULT));
    }
    let Some(numbers) = Numbers::of(pane) else { return };
    let id = ("grid", accent.r());
    Grid::new(id).num_columns(4).spacing([10.0, 3.0]).show(ui, |ui| {
        pair(ui, "triangles", with_commas(numbers.triangles));
        pair(ui, "error max", px(numbers.error_px_max));
        ui.end_row();
        pair(
            ui,
            "draws / calls",
            format!("{} / {}", with_commas(numbers.draws), with_commas(numbers.draw_calls.into())),
        );
        pair(ui, "error P99", px(numbers.error_px_p99));
        ui.end_row();
        pair(ui, "upload", bytes(numbers.upload_bytes));
        pair(ui, "error RMS", px(numbers.error_px_rms));
        ui.end_row();
        pair(ui, "uploaded", bytes(numbers.uploaded_bytes));
        pair(ui, "cracks", numbers.cracks.map_or("-".into(), with_commas));
        ui.end_row();
        pair(ui, "buffers", bytes(numbers.buffer_bytes));
        let age = numbers.measured_age_s.map_or("measuring ...".into(), |age_s| format!("{age_s:.1} s ago"));
        pair(ui, "measured", age);
        ui.end_row();
        pair(ui, "stale patches", with_commas(numbers.stale_patches));
        pair(ui, "update lag", format!("{:.0} ms", numbers.latency_ms));
        ui.end_row();
        if numbers.unheld_px > 0.0 || numbers.cells_due > 0 {
            pair(ui, "cells due", with_commas(numbers.cells_due));
            pair(ui, "not held by", format!("{:.2} px", numbers.unheld_px));
            ui.end_row();
        }
    });
    if let Some(fault) = numbers.fault {
        ui.label(RichText::new(fault).color(crate::gui::FAULT));
    }
}

fn pair(ui: &mut Ui, name: &str, value: String) {
    ui.label(RichText::new(name).small().color(FAINT));
    ui.label(RichText::new(value).monospace().size(12.0).color(INK));
}

fn times_card(ui: &mut Ui, parts: &Interface) {
    let ([frame_p50, frame_p99], [work_p50, work_p99]) = (parts.times.frame_ms(), parts.times.work_ms());
    graph(ui, parts.times);
    let line = |text: String| RichText::new(text).monospace().size(12.0);
    ui.label(line(format!("frame P50 {frame_p50:>5.1}  P99 {frame_p99:>5.1} ms")));
    ui.label(line(format!("work  P50 {work_p50:>5.1}  P99 {work_p99:>5.1} ms")));
    if let Some([own_p50, own_p99]) = parts.times.own_ms() {
        ui.label(line(format!("own   P50 {own_p50:>5.1}  P99 {own_p99:>5.1} ms")));
    }
    let speed_m_s = parts.state.rig.speed_m_s;
    let memory = parts.memory.bytes().map_or("-".into(), bytes);
    ui.label(RichText::new(format!("{memory} in memory   {speed_m_s:.0} m/s   H: keys")).small().color(FAINT));
    ui.label(RichText::new(adapter(parts)).small().color(FAINT));
}

fn adapter(parts: &Interface) -> String {
    // The part in brackets says no more than the type does.
    let name = parts.adapter.name.split('(').next().unwrap_or_default().trim();
    format!("{name} ({}, {})", parts.adapter.adapter_type, parts.adapter.backend)
}

/// A bar a frame; the line is P99.
fn graph(ui: &mut Ui, times: &Times) {
    let (rect, _) = ui.allocate_exact_size(vec2(240.0, 44.0), Sense::hover());
    let [_, p99] = times.frame_ms();
    let top_ms = (1.25 * p99).max(4.0);
    let height = |ms: f64| ((ms / top_ms).min(1.0) * f64::from(rect.height())) as f32;
    ui.painter().rect_filled(rect, 3.0, Color32::from_black_alpha(90));
    let first = rect.right() - times.frames_ms().len() as f32;
    for (i, ms) in times.frames_ms().enumerate() {
        let x = first + i as f32 + 0.5;
        let bar = [pos2(x, rect.bottom()), pos2(x, rect.bottom() - height(ms))];
        ui.painter().line_segment(bar, Stroke::new(1.0, Color32::from_rgb(120, 200, 140)));
    }
    let y = rect.bottom() - height(p99);
    ui.painter().hline(rect.x_range(), y, Stroke::new(1.0, Color32::from_rgb(255, 200, 90)));
}

fn px(value: Option<f64>) -> String {
    value.map_or("-".into(), |px| format!("{px:.3} px"))
}

fn with_commas(number: u64) -> String {
    let digits = number.to_string();
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().map(|group| std::str::from_utf8(group).expect("digits")).collect();
    groups.join(",")
}

fn bytes(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{:.0} kB", bytes as f64 / 1e3),
        _ => format!("{:.1} MB", bytes as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_for_people() {
        assert_eq!([0, 999, 1000, 1_234_567].map(with_commas), ["0", "999", "1,000", "1,234,567"]);
        assert_eq!([9_999, 12_000, 12_000_000].map(bytes), ["9999 B", "12 kB", "12.0 MB"]);
    }
}
