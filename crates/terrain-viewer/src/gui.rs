//! egui on the renderer's device: the interface of one frame, drawn over the terrain.

use egui::epaint::ImageDelta;
use egui::{ClippedPrimitive, Color32, Context, CornerRadius, FullOutput, PlatformOutput, RawInput, TextureId, Ui};
use egui_wgpu::{RendererOptions, ScreenDescriptor};
use terrain_renderer::Gpu;

/// Ink and paper of the interface. Colours blend as light does, so that paper must be nearly opaque to be dark over the sky.
pub const PAPER: Color32 = Color32::from_rgba_premultiplied(16, 20, 27, 244);
pub const INK: Color32 = Color32::from_rgb(222, 228, 236);
pub const FAINT: Color32 = Color32::from_rgb(168, 178, 192);
pub const ACCENTS: [Color32; 2] = [Color32::from_rgb(255, 176, 84), Color32::from_rgb(110, 196, 255)];
pub const FAULT: Color32 = Color32::from_rgb(255, 112, 96);

pub struct Gui {
    pub context: Context,
    renderer: egui_wgpu::Renderer,
}

/// An interface that is laid out and uploaded.
pub struct Layout {
    primitives: Vec<ClippedPrimitive>,
    screen: ScreenDescriptor,
    changed_textures: Vec<(TextureId, ImageDelta)>,
    freed_textures: Vec<TextureId>,
    pub platform: PlatformOutput,
}

impl Gui {
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat) -> Self {
        let context = Context::default();
        context.set_theme(egui::Theme::Dark);
        context.global_style_mut(style);
        let renderer = egui_wgpu::Renderer::new(&gpu.device, format, RendererOptions::default());
        Self { context, renderer }
    }

    /// Lays the interface out.
    pub fn run(&mut self, input: RawInput, size_px: [u32; 2], ui: impl FnMut(&mut Ui)) -> Layout {
        let FullOutput { platform_output, mut textures_delta, shapes, pixels_per_point, .. } =
            self.context.run_ui(input, ui);
        // Emptied here: egui panics where changes are dropped, and a frame may end with a lost device before it is drawn.
        let changed = std::mem::take(&mut textures_delta.set).into_iter();

        Layout {
            primitives: self.context.tessellate(shapes, pixels_per_point),
            screen: ScreenDescriptor { size_in_pixels: size_px, pixels_per_point },
            changed_textures: changed
                .flat_map(|(id, deltas)| deltas.into_iter().map(move |delta| (id, delta)))
                .collect(),
            freed_textures: std::mem::take(&mut textures_delta.free).into_iter().collect(),
            platform: platform_output,
        }
    }

    /// Uploads what the interface draws; before the passes of the same submission.
    pub fn upload(&mut self, gpu: &Gpu, layout: &Layout, encoder: &mut wgpu::CommandEncoder) {
        for (id, delta) in &layout.changed_textures {
            self.renderer.update_texture(&gpu.device, &gpu.queue, *id, delta);
        }
        // Without paint callbacks there are no further commands.
        self.renderer.update_buffers(&gpu.device, &gpu.queue, encoder, &layout.primitives, &layout.screen);
    }

    /// Draws over what is there.
    pub fn draw(&self, layout: &Layout, encoder: &mut wgpu::CommandEncoder, colour: &wgpu::TextureView) {
        let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("interface"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: colour,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        self.renderer.render(&mut pass.forget_lifetime(), &layout.primitives, &layout.screen);
    }

    /// Frees what the next frame does not need; after the submission.
    pub fn free(&mut self, layout: &Layout) {
        for id in &layout.freed_textures {
            self.renderer.free_texture(id);
        }
    }
}

/// Dark glass: the terrain is the picture.
fn style(style: &mut egui::Style) {
    let visuals = &mut style.visuals;
    visuals.window_fill = PAPER;
    visuals.panel_fill = PAPER;
    visuals.window_stroke = egui::Stroke::new(1.0, Color32::from_white_alpha(18));
    visuals.window_corner_radius = CornerRadius::same(8);
    visuals.window_shadow = egui::Shadow::NONE;
    visuals.popup_shadow = egui::Shadow::NONE;
    visuals.override_text_color = Some(INK);
    // Empty checkboxes and the rails of sliders are seen by their rims.
    visuals.widgets.inactive.bg_stroke = egui::Stroke::new(1.0, Color32::from_white_alpha(48));
    style.text_styles.insert(egui::TextStyle::Small, egui::FontId::proportional(11.0));
    style.spacing.item_spacing = egui::vec2(6.0, 5.0);
    style.spacing.slider_width = 110.0;
    style.animation_time = 0.0;
    style.interaction.selectable_labels = false;
}

/// A linear colour of the renderer as the interface has it.
pub fn from_linear([r, g, b]: [f32; 3]) -> Color32 {
    egui::Rgba::from_rgb(r, g, b).into()
}
