//! How the crate uses wgpu, checked by wgpu's own validation on a backend that draws nothing. Needs no driver.

mod hills;

use hills::{Mesh, SIZE_PX, baked_grid, displaced_grid, noop, oblique};
use terrain_renderer::{Colour, Look, RenderError, Renderer, RendererSettings, Submission};

fn renderer(submission: Submission) -> Renderer {
    let settings = RendererSettings { size_px: SIZE_PX, submission, count_primitives: true };
    Renderer::new(noop(), &hills::hills(), &settings).unwrap()
}

fn draw_calls(submission: Submission, mesh: &Mesh, wireframe: bool) -> u32 {
    let mut renderer = renderer(submission);
    let mut buffers = renderer.buffers(mesh.sizes).unwrap();
    let look = Look { colour: Colour::ByLevel, wireframe, ..Default::default() };
    renderer.frame(&oblique(&hills::hills()), &mesh.plan, &mut buffers, &look).unwrap().draw_calls
}

#[test]
fn both_vertex_kinds_and_both_submissions_are_valid_and_their_calls_are_counted() {
    let baked = baked_grid(&hills::hills(), 100);
    let displaced = displaced_grid(&hills::hills(), 8);
    for mesh in [&baked, &displaced] {
        let draws = mesh.plan.draws.len() as u32;
        assert_eq!(draw_calls(Submission::Direct, mesh, false), draws);
        assert_eq!(draw_calls(Submission::Direct, mesh, true), 2 * draws);
        assert_eq!(draw_calls(Submission::MultiIndirect, mesh, false), 1);
        assert_eq!(draw_calls(Submission::MultiIndirect, mesh, true), 2);
    }
}

#[test]
fn an_empty_plan_is_a_frame_without_draw_calls() {
    let mut mesh = baked_grid(&hills::hills(), 100);
    mesh.plan.clear();
    assert_eq!(draw_calls(Submission::Direct, &mesh, false), 0);
    assert_eq!(draw_calls(Submission::MultiIndirect, &mesh, false), 0);
}

/// A camera that has seen nothing yet: an index buffer that follows what is drawn has no bytes.
#[test]
fn an_empty_plan_over_empty_buffers_is_a_frame_too() {
    let mut mesh = baked_grid(&hills::hills(), 100);
    mesh.plan.clear();
    mesh.sizes.indices = 0;
    for submission in [Submission::Direct, Submission::MultiIndirect] {
        assert_eq!(draw_calls(submission, &mesh, true), 0);
    }
}

#[test]
fn a_read_back_picture_has_the_size_of_the_target() {
    let renderer = renderer(Submission::Direct);
    let picture = renderer.target().read_back(renderer.gpu()).unwrap();
    assert_eq!([picture.width(), picture.height()], SIZE_PX);
    let depths = renderer.target().read_depth(renderer.gpu()).unwrap();
    assert_eq!(depths.len(), (SIZE_PX[0] * SIZE_PX[1]) as usize);
}

#[test]
fn a_plan_that_breaks_the_contract_is_an_error_and_the_next_frame_is_drawn() {
    for submission in [Submission::Direct, Submission::MultiIndirect] {
        let mut renderer = renderer(submission);
        let view = oblique(&hills::hills());
        let good = baked_grid(&hills::hills(), 100);
        let mut buffers = renderer.buffers(good.sizes).unwrap();
        let mut frame = |plan| renderer.frame(&view, plan, &mut buffers, &Look::default());

        let mut draws_too_much = good.plan.clone();
        draws_too_much.draws.last_mut().unwrap().indices.end += 3;
        frame(&draws_too_much).unwrap_err();
        let mut uploads_too_much = good.plan.clone();
        uploads_too_much.uploads[0].offset = 8;
        let refused = frame(&uploads_too_much).unwrap_err();
        assert!(matches!(refused, RenderError::Gpu(_)), "{refused}");
        frame(&good.plan).unwrap();
    }
}

#[test]
fn a_draw_beyond_the_instances_is_an_error() {
    for submission in [Submission::Direct, Submission::MultiIndirect] {
        let mut renderer = renderer(submission);
        let mut mesh = displaced_grid(&hills::hills(), 8);
        mesh.plan.draws[1].instances.end += 1;
        let mut buffers = renderer.buffers(mesh.sizes).unwrap();
        renderer.frame(&oblique(&hills::hills()), &mesh.plan, &mut buffers, &Look::default()).unwrap_err();
    }
}

#[test]
fn a_lost_device_is_an_error() {
    let mut renderer = renderer(Submission::Direct);
    let mesh = baked_grid(&hills::hills(), 100);
    let mut buffers = renderer.buffers(mesh.sizes).unwrap();
    renderer.gpu().device.destroy();
    let refused = renderer.frame(&oblique(&hills::hills()), &mesh.plan, &mut buffers, &Look::default());
    assert!(matches!(refused, Err(RenderError::Gpu(_))), "{refused:?}");
}

#[test]
fn a_view_of_another_size_is_refused() {
    let settings = RendererSettings { size_px: [64, 64], ..Default::default() };
    let mut renderer = Renderer::new(noop(), &hills::hills(), &settings).unwrap();
    let mesh = baked_grid(&hills::hills(), 100);
    let mut buffers = renderer.buffers(mesh.sizes).unwrap();
    let refused = renderer.frame(&oblique(&hills::hills()), &mesh.plan, &mut buffers, &Look::default());
    assert_eq!(refused.unwrap_err().to_string(), "view of 320 x 180 pixels on a target of 64 x 64: make both alike");
}
