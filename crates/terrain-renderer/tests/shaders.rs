//! The WGSL files against naga and against Rust's layouts. Needs neither a driver nor a GPU.

use std::mem::offset_of;

use naga::valid::{Capabilities, ValidationFlags, Validator};
use terrain_core::{Morph, PatchTag};
use terrain_renderer::{FrameUniforms, LevelUniforms, TileUniforms};

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

/// Name, offset, scalar kind, and size in bytes of a member.
type Member<'a> = (&'a str, usize, naga::ScalarKind, usize);

/// The members of a struct that are scalars, vectors or matrices, and the size of all in bytes.
fn members<'a>(module: &'a naga::Module, name: &str) -> (Vec<Member<'a>>, usize) {
    let (_, ty) = module.types.iter().find(|(_, ty)| ty.name.as_deref() == Some(name)).unwrap();
    let naga::TypeInner::Struct { members, span } = &ty.inner else { panic!("{name} is no struct") };
    let member = |member: &'a naga::StructMember| {
        let inner = &module.types[member.ty].inner;
        let size = inner.size(module.to_ctx()) as usize;
        Some((member.name.as_deref().unwrap(), member.offset as usize, inner.scalar_kind()?, size))
    };
    (members.iter().filter_map(member).collect(), *span as usize)
}

/// The scalars that a field of uniforms may be made of.
trait Scalar {
    const KIND: naga::ScalarKind;
}

impl Scalar for f32 {
    const KIND: naga::ScalarKind = naga::ScalarKind::Float;
}
impl Scalar for i32 {
    const KIND: naga::ScalarKind = naga::ScalarKind::Sint;
}
impl Scalar for u32 {
    const KIND: naga::ScalarKind = naga::ScalarKind::Uint;
}
impl<T: Scalar, const N: usize> Scalar for [T; N] {
    const KIND: naga::ScalarKind = T::KIND;
}

/// A field's row of the comparison.
fn field<'a, T: Scalar>(name: &'a str, offset: usize, value: &T) -> Member<'a> {
    (name, offset, T::KIND, size_of_val(value))
}

macro_rules! fields {
    ($uniforms:ty: $($name:ident),*) => {{
        let uniforms: $uniforms = bytemuck::Zeroable::zeroed();
        [$(field(stringify!($name), offset_of!($uniforms, $name), &uniforms.$name)),*]
    }};
}

#[test]
fn levels_glide_in_the_same_ranges_as_in_the_mirror() {
    let (_, source) = shaders().into_iter().find(|(name, _)| name.ends_with("terrain.wgsl")).unwrap();
    for (name, value) in [("MORPH_START", Morph::START), ("MORPH_END", Morph::END)] {
        assert!(source.contains(&format!("const {name} = {value};")), "{name} is {value}");
    }
}

#[test]
fn stale_patches_are_marked_alike() {
    let (_, source) = shaders().into_iter().find(|(name, _)| name.ends_with("terrain.wgsl")).unwrap();
    assert!(source.contains(&format!("const STALE = {:#x}u;", PatchTag::STALE)));
}

#[test]
fn frame_uniforms_have_the_layout_of_the_shader() {
    let (name, source) = shaders().into_iter().find(|(name, _)| name.ends_with("terrain.wgsl")).unwrap();
    let module = parse(&name, &source);
    let (in_wgsl, span) = members(&module, "Frame");
    let in_rust = fields!(
        FrameUniforms:
        clip_from_eye,
        eye_sample,
        eye_remainder_m,
        spacing_m,
        last_sample,
        height_range_m,
        eye_height_m,
        half_light_m,
        haze_colour,
        spacing_px_at_1_m,
        mean_leg_px,
        morph_reach_m,
        metre_px_at_1_m,
        error_scale_px,
        to_sun,
        cell_side
    );
    assert_eq!(in_wgsl, in_rust);
    assert_eq!(span, size_of::<FrameUniforms>());
}

#[test]
fn tile_uniforms_have_the_layout_of_the_shader() {
    let (name, source) = shaders().into_iter().find(|(name, _)| name.ends_with("terrain.wgsl")).unwrap();
    let module = parse(&name, &source);
    let (in_wgsl, span) = members(&module, "Tiles");
    let in_rust = fields!(
        TileUniforms:
        coarse_level,
        coarse_step,
        coarse_columns,
        cell_side,
        code_bytes,
        scale_m,
        offset_m,
        padding
    );
    assert_eq!(in_wgsl, in_rust);
    assert_eq!(span, size_of::<TileUniforms>());
    let (in_wgsl, span) = members(&module, "TileLevel");
    assert_eq!(in_wgsl, fields!(LevelUniforms: window, step, first_tile, tile_codes));
    assert_eq!(span, size_of::<LevelUniforms>());
}
