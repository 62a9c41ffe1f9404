//! All keys.

use egui::{Align2, Context, Grid, RichText, Ui};

use crate::command::{FLYING, KEYS};
use crate::gui::ACCENTS;

pub fn show(context: &Context) {
    egui::Window::new("Keys")
        .anchor(Align2::CENTER_CENTER, [0.0, 0.0])
        .collapsible(false)
        .resizable(false)
        .order(egui::Order::Foreground)
        .show(context, |ui| {
            ui.horizontal_top(|ui| {
                let half = KEYS.len().div_ceil(2);
                grid(ui, "flying", FLYING.iter().map(|(key, says)| ((*key).to_owned(), *says)));
                for (id, bindings) in [("first", &KEYS[..half]), ("second", &KEYS[half..])] {
                    ui.separator();
                    grid(ui, id, bindings.iter().map(|binding| (binding.key.name().to_owned(), binding.says)));
                }
            });
        });
}

fn grid(ui: &mut Ui, id: &str, rows: impl Iterator<Item = (String, &'static str)>) {
    Grid::new(id).num_columns(2).spacing([12.0, 4.0]).show(ui, |ui| {
        for (key, says) in rows {
            ui.label(RichText::new(key).strong().color(ACCENTS[0]));
            ui.label(says);
            ui.end_row();
        }
    });
}
