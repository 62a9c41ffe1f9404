//! What lies over the terrain: the divider with the methods' names, the legend, the frozen frustum, messages.

use egui::{
    Align2, Area, Color32, Context, FontId, Id, LayerId, Mesh, Order, Painter, Pos2, Rect, Sense, Stroke, Vec2, pos2,
    vec2,
};
use glam::{DMat4, DVec3, DVec4};
use terrain_core::View;
use terrain_renderer::heat_colour;

use crate::command::{Command, Mode, Side};
use crate::gui::{ACCENTS, FAINT, FAULT, INK, PAPER, from_linear};
use crate::interface::Interface;
use crate::map;
use crate::measure::PatchBox;
use crate::pane::Pane;
use crate::state::{Message, Shown};

/// Boxes that are drawn, the nearest first: more could not be told apart, and would cost time.
const MOST_BOXES: usize = 2000;
/// Metres that the frozen frustum is drawn far.
const FRUSTUM_SHARE: f64 = 0.35;

pub fn show(context: &Context, parts: &mut Interface) {
    let painter = context.layer_painter(LayerId::new(Order::Background, Id::unique("overlay")));
    let screen = context.content_rect();
    if let Some(frozen) = &parts.state.frozen {
        let [x_m, z_m] = parts.ground.dem.heightmap.extent_m();
        paint_frustum(&painter, screen, parts.view, frozen, FRUSTUM_SHARE * x_m.max(z_m));
    }
    if parts.state.boxes {
        paint_boxes(&painter, screen, parts);
    }
    if parts.state.is_split() {
        divide(context, &painter, screen, parts);
    }
    name_methods(&painter, screen, parts);
    if parts.state.frozen.is_some() {
        pill(&painter, screen.center_top() + vec2(0.0, 70.0), Align2::CENTER_TOP, "frozen: F lets go", INK);
    }
    if parts.state.mode == Mode::Error {
        // Beside the map, not below it: a low window has no room there.
        let aside = if parts.state.open.map { map::SIDE + 28.0 } else { 0.0 };
        legend(&painter, screen.translate(vec2(-aside, 0.0)), parts.state.error_scale_px);
    }
    if let Some(message) = &parts.state.message {
        // Over the panel: it may be about what is set there.
        let painter = context.layer_painter(LayerId::new(Order::Foreground, Id::unique("message")));
        say(&painter, screen, message);
    }
}

/// The line between the methods, and a handle to drag it by.
fn divide(context: &Context, painter: &Painter, screen: Rect, parts: &mut Interface) {
    let x = screen.left() + parts.state.divider as f32 * screen.width();
    painter.vline(x, screen.y_range(), Stroke::new(3.0, Color32::from_black_alpha(110)));
    painter.vline(x, screen.y_range(), Stroke::new(1.0, Color32::WHITE));
    let size = vec2(26.0, 44.0);
    let handle = Rect::from_center_size(pos2(x, screen.center().y), size);
    Area::new(Id::unique("divider")).fixed_pos(handle.min).order(Order::Middle).show(context, |ui| {
        let (rect, response) = ui.allocate_exact_size(size, Sense::drag());
        let fill = if response.hovered() || response.dragged() { INK } else { PAPER };
        ui.painter().rect(rect, 13.0, fill, Stroke::new(1.0, Color32::WHITE), egui::StrokeKind::Inside);
        for offset in [-4.0, 0.0, 4.0] {
            ui.painter().vline(
                rect.center().x + offset,
                rect.center().y - 7.0..=rect.center().y + 7.0,
                Stroke::new(1.0, FAINT),
            );
        }
        if let Some(pointer) = response.interact_pointer_pos().filter(|_| response.dragged()) {
            parts.commands.push(Command::Divider(((pointer.x - screen.left()) / screen.width()).into()));
        }
    });
}

fn name_methods(painter: &Painter, screen: Rect, parts: &Interface) {
    let x = match parts.state.shown {
        Shown::Both if parts.state.mode != Mode::Difference => {
            screen.left() + parts.state.divider as f32 * screen.width()
        }
        _ => screen.center().x,
    };
    let gap = if parts.state.shown == Shown::Both { 10.0 } else { 0.0 };
    let sides = [(Side::Left, Align2::RIGHT_TOP, -gap), (Side::Right, Align2::LEFT_TOP, gap)];
    for ((side, align, gap), (pane, accent)) in sides.into_iter().zip(parts.panes.iter().zip(ACCENTS)) {
        let align = if parts.state.shown == Shown::Both { align } else { Align2::CENTER_TOP };
        if parts.state.shown.includes(side) {
            pill(painter, pos2(x + gap, screen.top() + 10.0), align, &title(pane), accent);
        }
    }
    if parts.state.mode == Mode::Difference && parts.state.shown == Shown::Both {
        pill(painter, screen.center_top() + vec2(0.0, 44.0), Align2::CENTER_TOP, "difference of the pictures", INK);
    }
}

/// The method that is drawn, or what is being done about it.
pub fn title(pane: &Pane) -> String {
    let what = pane.run().unwrap_or(&pane.wanted);
    let name = what.method.as_str();
    let setting =
        if what.takes_tolerance() { format!("{name}  {} px", what.settings.tolerance_px) } else { name.to_owned() };
    match pane.run() {
        _ if pane.fault.is_some() => format!("{setting}  (refused)"),
        _ if pane.is_settled() => setting,
        _ => format!("{setting}  (building ...)"),
    }
}

fn pill(painter: &Painter, at: Pos2, align: Align2, text: &str, colour: Color32) {
    let galley = painter.layout_no_wrap(text.to_owned(), FontId::proportional(14.0), colour);
    let rect = align.anchor_size(at, galley.size() + vec2(18.0, 8.0));
    painter.rect_filled(rect, 12.0, PAPER);
    painter.galley(rect.min + vec2(9.0, 4.0), galley, colour);
}

/// Pixels of error by colour, at the right edge.
fn legend(painter: &Painter, screen: Rect, scale_px: f64) {
    const STEPS: usize = 60;
    let bar = Rect::from_min_size(pos2(screen.right() - 74.0, screen.center().y - 110.0), vec2(16.0, 200.0));
    painter.rect_filled(bar.expand2(vec2(12.0, 26.0)).translate(vec2(14.0, -2.0)).expand2(vec2(14.0, 0.0)), 8.0, PAPER);
    let font = FontId::proportional(12.0);
    painter.text(bar.center_top() + vec2(14.0, -8.0), Align2::CENTER_BOTTOM, "error, px", font.clone(), INK);
    let step = bar.height() / STEPS as f32;
    for i in 0..STEPS {
        let share = (i as f32 + 0.5) / STEPS as f32;
        let top = bar.bottom() - (i + 1) as f32 * step;
        let cell = Rect::from_min_size(pos2(bar.left(), top), vec2(bar.width(), step + 0.5));
        painter.rect_filled(cell, 0.0, from_linear(heat_colour(share)));
    }
    let above = Rect::from_min_size(bar.left_top() - vec2(0.0, 6.0), vec2(bar.width(), 5.0));
    painter.rect_filled(above, 0.0, from_linear(heat_colour(2.0)));
    for quarter in 0..=4 {
        let share = quarter as f32 / 4.0;
        let at = pos2(bar.right() + 6.0, bar.bottom() - share * bar.height());
        let px = (f64::from(share) * scale_px * 100.0).round() / 100.0;
        painter.text(at, Align2::LEFT_CENTER, px.to_string(), font.clone(), INK);
    }
}

fn say(painter: &Painter, screen: Rect, message: &Message) {
    let colour = if message.is_fault { FAULT } else { INK };
    let width = (screen.width() - 80.0).clamp(120.0, 760.0);
    let galley = painter.layout(message.text.clone(), FontId::proportional(15.0), colour, width);
    let size = galley.size() + vec2(24.0, 16.0);
    let rect = Rect::from_center_size(screen.center_top() + vec2(0.0, 96.0 + 0.5 * size.y), size);
    painter.rect(rect, 8.0, PAPER, Stroke::new(1.0, colour.gamma_multiply(0.6)), egui::StrokeKind::Inside);
    painter.galley(rect.min + vec2(12.0, 8.0), galley, colour);
}

/// The edges of what the frozen view sees, up to `depth_m` away.
fn paint_frustum(painter: &Painter, screen: Rect, view: &View, frozen: &View, depth_m: f64) {
    let world_from_clip = frozen.clip_from_eye.inverse();
    let corner = |x: f64, y: f64| {
        let direction = (world_from_clip * DVec4::new(x, y, 1.0, 1.0)).truncate().normalize();
        frozen.eye_world + depth_m * direction
    };
    let far = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    let stroke = Stroke::new(1.5, Color32::from_rgb(255, 232, 120));
    for (i, from) in far.iter().enumerate() {
        for to in [far[(i + 1) % 4], frozen.eye_world] {
            if let Some([a, b]) = on_screen(&view.clip_from_world, *from, to) {
                let place = |ndc: Vec2| screen.center() + ndc * screen.size() * 0.5;
                painter.line_segment([place(a), place(b)], stroke);
            }
        }
    }
}

/// A box around each patch, as it was measured last, each method's in its part of the window.
fn paint_boxes(painter: &Painter, screen: Rect, parts: &Interface) {
    let divider = match parts.state.shown {
        _ if !parts.state.is_split() => [screen.left(), screen.right()],
        _ => [screen.left() + parts.state.divider as f32 * screen.width(); 2],
    };
    let sides = [(Side::Left, screen.left()..=divider[1]), (Side::Right, divider[0]..=screen.right())];
    for ((side, columns), (pane, accent)) in sides.into_iter().zip(parts.panes.iter().zip(ACCENTS)) {
        let (true, Some(Ok(measured))) = (parts.state.shown.includes(side), pane.measured()) else { continue };
        let painter = painter.with_clip_rect(Rect::from_x_y_ranges(columns, screen.y_range()));
        let eye = parts.view.eye_world;
        let mut edges = Mesh::default();
        for PatchBox { low, high } in nearest(&measured.boxes, eye) {
            add_box(&mut edges, screen, parts.view, [low, high], accent);
        }
        painter.add(edges);
    }
}

/// As many as are drawn, in any order.
fn nearest(boxes: &[PatchBox], eye: DVec3) -> Vec<PatchBox> {
    let mut boxes: Vec<(f64, PatchBox)> = boxes.iter().map(|found| (found.distance_to(eye), *found)).collect();
    if boxes.len() > MOST_BOXES {
        boxes.select_nth_unstable_by(MOST_BOXES, |(a, _), (b, _)| a.total_cmp(b));
        boxes.truncate(MOST_BOXES);
    }
    boxes.into_iter().map(|(_, found)| found).collect()
}

/// One mesh for all boxes: thousands of lines would each be tessellated with soft edges.
fn add_box(mesh: &mut Mesh, screen: Rect, view: &View, ends: [DVec3; 2], colour: Color32) {
    let corner = |bits: usize| DVec3::new(ends[bits & 1].x, ends[bits >> 1 & 1].y, ends[bits >> 2].z);
    // Each of the 12 edges leads to the corner with one bit more.
    for (from, axis) in (0..8).flat_map(|from| [1, 2, 4].map(|axis| (from, axis))) {
        if from & axis == 0
            && let Some(segment) = on_screen(&view.clip_from_world, corner(from), corner(from | axis))
        {
            add_line(mesh, segment.map(|ndc| screen.center() + ndc * screen.size() * 0.5), colour);
        }
    }
}

/// Two triangles, a point wide.
fn add_line(mesh: &mut Mesh, [a, b]: [Pos2; 2], colour: Color32) {
    let across = (b - a).normalized().rot90() * 0.5;
    let first = mesh.vertices.len() as u32;
    [a - across, a + across, b - across, b + across].into_iter().for_each(|at| mesh.colored_vertex(at, colour));
    mesh.add_triangle(first, first + 1, first + 2);
    mesh.add_triangle(first + 1, first + 2, first + 3);
}

/// The part of a segment that is in front of the near plane, from -1 to 1 over the picture, y downwards.
fn on_screen(clip_from_world: &DMat4, a: DVec3, b: DVec3) -> Option<[Vec2; 2]> {
    let [mut a, mut b] = [a, b].map(|point| *clip_from_world * point.extend(1.0));
    // Reversed depth: in front of the near plane is z <= w.
    let [inside_a, inside_b] = [a, b].map(|clip| clip.w - clip.z);
    if inside_a <= 0.0 && inside_b <= 0.0 {
        return None;
    }
    let crossing = a.lerp(b, inside_a / (inside_a - inside_b));
    if inside_a <= 0.0 {
        a = crossing;
    } else if inside_b <= 0.0 {
        b = crossing;
    }
    // What is far out of the picture stays a number that the painter can use.
    let place =
        |clip: DVec4| vec2((clip.x / clip.w).clamp(-1e3, 1e3) as f32, (-clip.y / clip.w).clamp(-1e3, 1e3) as f32);
    Some([place(a), place(b)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use terrain_core::{Camera, Lens};

    #[test]
    fn segments_are_cut_at_the_near_plane() {
        let camera = Camera { eye_world: DVec3::ZERO, heading: 0.0, pitch: 0.0 };
        let lens = Lens { fov_y: std::f64::consts::FRAC_PI_2, size_px: [100, 100], near_m: 1.0 };
        let clip = View::new(&camera, &lens).unwrap().clip_from_world;
        // From 10 m ahead and 5 m to the right to 10 m behind: seen up to 1 m ahead.
        let [a, b] = on_screen(&clip, DVec3::new(5.0, 0.0, -10.0), DVec3::new(5.0, 0.0, 10.0)).unwrap();
        assert!((a.x - 0.5).abs() < 1e-6 && (b.x - 5.0).abs() < 1e-5, "{a:?} {b:?}");
        assert_eq!(on_screen(&clip, DVec3::new(0.0, 0.0, 2.0), DVec3::new(0.0, 0.0, 3.0)), None);
    }
}
