//! The map: the DEM from above with the camera on it. A click flies there.

use egui::{
    Align2, Color32, ColorImage, Context, Image, Sense, Shape, Stroke, TextureHandle, TextureOptions, Ui, Window, vec2,
};
use glam::DVec3;
use terrain_core::{Heightmap, Sample};

use crate::command::Command;
use crate::state::State;

/// Points of the longer side.
const SIDE: f32 = 170.0;
/// Texels of the longer side.
const TEXELS: usize = 340;

pub struct Map {
    image: ColorImage,
    /// Made when it is shown first, and with every new interface.
    texture: Option<TextureHandle>,
    extent_m: [f64; 2],
}

impl Map {
    pub fn of(heightmap: &Heightmap) -> Self {
        Self { image: shaded_relief(heightmap), texture: None, extent_m: heightmap.extent_m() }
    }

    pub fn show(&mut self, context: &Context, state: &State, commands: &mut Vec<Command>) {
        Window::new("map")
            .title_bar(false)
            .resizable(false)
            .anchor(Align2::RIGHT_TOP, [-12.0, 12.0])
            .show(context, |ui| self.contents(ui, state, commands));
    }

    fn contents(&mut self, ui: &mut Ui, state: &State, commands: &mut Vec<Command>) {
        let Self { image, texture, extent_m: [x_m, z_m] } = self;
        let texture =
            texture.get_or_insert_with(|| ui.ctx().load_texture("map", image.clone(), TextureOptions::LINEAR));
        let scale = f64::from(SIDE) / x_m.max(*z_m);
        let size = vec2((*x_m * scale) as f32, (*z_m * scale) as f32);
        let response = ui.add(Image::new((texture.id(), size)).sense(Sense::click()));
        let place = |world: DVec3| response.rect.min + vec2((world.x * scale) as f32, (world.z * scale) as f32);
        let (camera, half) = (state.rig.camera, 0.6 * state.rig.fov_y);
        let ray = |angle: f64| place(camera.eye_world) + vec2(angle.sin() as f32, -angle.cos() as f32) * 34.0;
        let sees = vec![place(camera.eye_world), ray(camera.heading - half), ray(camera.heading + half)];
        let painter = ui.painter_at(response.rect);
        painter.add(Shape::convex_polygon(sees, Color32::from_white_alpha(70), Stroke::NONE));
        painter.circle(place(camera.eye_world), 4.0, Color32::from_rgb(255, 90, 70), Stroke::new(1.5, Color32::WHITE));
        if let Some(at) = response.interact_pointer_pos().filter(|_| response.clicked()) {
            let moved = (at - response.rect.min) / size;
            let mut rig = state.rig.clone();
            (rig.camera.eye_world.x, rig.camera.eye_world.z) = (f64::from(moved.x) * *x_m, f64::from(moved.y) * *z_m);
            commands.push(Command::Camera(rig.link()));
        }
    }
}

/// Heights by tint, slopes by light from the north-west.
fn shaded_relief(heightmap: &Heightmap) -> ColorImage {
    let sides = [heightmap.columns(), heightmap.rows()].map(|side| side as usize);
    let scale = (TEXELS as f64 / sides[0].max(sides[1]) as f64).min(1.0);
    let size = sides.map(|side| ((side as f64 * scale) as usize).max(2));
    let last = Sample { column: heightmap.columns() - 1, row: heightmap.rows() - 1 };
    let [low_m, high_m] = heightmap.height_range_m(Sample { column: 0, row: 0 }, last);
    let texel = |x: usize, y: usize| {
        let along = |at: usize, size: usize, last: u32| (at as u64 * u64::from(last) / (size as u64 - 1)) as u32;
        let at = Sample { column: along(x, size[0], last.column), row: along(y, size[1], last.row) };
        let height = (heightmap.height_m(at) - low_m) / (high_m - low_m).max(1e-3);
        let [nx, ny, nz] = heightmap.normal(at);
        let light = (0.35 + 0.75 * (-0.6 * nx + 0.6 * ny - 0.53 * nz)).clamp(0.15, 1.1);
        let tint = |from: f32, to: f32| ((from + (to - from) * height) * light).clamp(0.0, 255.0) as u8;
        Color32::from_rgb(tint(104.0, 226.0), tint(132.0, 222.0), tint(92.0, 212.0))
    };
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y))).map(|(x, y)| texel(x, y)).collect();
    ColorImage::new(size, pixels)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_of_any_shape_have_an_image() {
        for [columns, rows] in [[2, 2], [1000, 3], [65, 129]] {
            let flat = vec![0.0; (columns * rows) as usize];
            let image = shaded_relief(&Heightmap::new(columns, rows, [1.0; 2], flat).unwrap());
            assert!(image.size.iter().all(|side| (2..=TEXELS).contains(side)), "{:?}", image.size);
        }
    }
}
