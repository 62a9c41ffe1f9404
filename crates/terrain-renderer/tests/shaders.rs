//! The WGSL files against naga and against Rust's layouts. Needs neither a driver nor a GPU.

use std::mem::offset_of;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use terrain_renderer::FrameUniforms;

/// Name and text of every WGSL file.
fn shaders() -> Vec<(String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../shaders");
    let paths = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let files = paths.filter(|path| path.extension().is_some_and(|extension| extension == "wgsl"));
    files.map(|path| (path.display().to_string(), std::fs::read_to_string(path).unwrap())).collect()
}

fn parse(name: &str, source: &str) -> naga::Module {
    naga::front::wgsl::parse_str(source)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string_with_path(source, name)))
}

#[test]
fn every_shader_is_valid() {
    assert!(!shaders().is_empty());
    for (name, source) in shaders() {
        Validator::new(ValidationFlags::all(), Capabilities::empty())
            .validate(&parse(&name, &source))
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string_with_path(&source, &name)));
    }
}

#[test]
fn frame_uniforms_have_the_layout_of_the_shader() {
    let (name, source) = shaders().into_iter().find(|(name, _)| name.ends_with("terrain.wgsl")).unwrap();
    let module = parse(&name, &source);
    let (_, frame) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some("Frame")).unwrap();
    let naga::TypeInner::Struct { members, span } = &frame.inner else { panic!("Frame is no struct") };
    let in_wgsl: Vec<_> = members.iter().map(|m| (m.name.as_deref().unwrap(), m.offset as usize)).collect();
    let in_rust = [
        ("clip_from_eye", offset_of!(FrameUniforms, clip_from_eye)),
        ("eye_sample", offset_of!(FrameUniforms, eye_sample)),
        ("eye_remainder_m", offset_of!(FrameUniforms, eye_remainder_m)),
        ("spacing_m", offset_of!(FrameUniforms, spacing_m)),
        ("last_sample", offset_of!(FrameUniforms, last_sample)),
        ("height_range_m", offset_of!(FrameUniforms, height_range_m)),
        ("eye_height_m", offset_of!(FrameUniforms, eye_height_m)),
        ("half_light_m", offset_of!(FrameUniforms, half_light_m)),
        ("haze_colour", offset_of!(FrameUniforms, haze_colour)),
        ("colour", offset_of!(FrameUniforms, colour)),
    ];
    assert_eq!(in_wgsl, in_rust);
    assert_eq!(*span as usize, size_of::<FrameUniforms>());
}
