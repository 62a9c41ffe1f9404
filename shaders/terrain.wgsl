// Terrain from either vertex kind: a vertex entry point for each source of heights, one fragment stage, and one for the
// wireframe; both again for DEMs with voids.
//
// World axes: x east, y up, z south, in metres. Positions are relative to the eye.
// Depth is reversed: 1 at the near plane, 0 at infinity.

// `FrameUniforms` in layout.rs; a test compares the two.
struct Frame {
    clip_from_eye: mat4x4<f32>,
    eye_sample: vec2<i32>,
    eye_remainder_m: vec2<f32>,
    spacing_m: vec2<f32>,
    last_sample: vec2<i32>,
    height_range_m: vec2<f32>,
    eye_height_m: f32,
    half_light_m: f32,
    haze_colour: vec3<f32>,
    spacing_px_at_1_m: f32,
    mean_leg_px: f32,
    // Of `Morph`; 0 where a plan has none.
    morph_reach_m: f32,
    metre_px_at_1_m: f32,
    error_scale_px: f32,
    to_sun: vec3<f32>,
    cell_side: u32,
}

// `Shading` in look.rs. Constants of the pipeline: a uniform that decides a branch costs time at every vertex and pixel,
// and lavapipe compiles a shader with such branches anew for every frame, and keeps them all.
override COLOUR: u32 = 0u;
override NORMALS: u32 = 0u;
override MARK_STALE: bool = false;
// Of `Morph`.
override MORPH_K: i32 = 1;
override MORPH_LEVELS: i32 = 0;

const COLOUR_BY_PATCH = 1u;
const COLOUR_BY_LEVEL = 2u;
const COLOUR_PLAIN = 3u;
const COLOUR_BY_NORMAL = 4u;
const COLOUR_BY_CELL = 5u;
const COLOUR_BY_DRAW = 6u;
const COLOUR_BY_ERROR = 8u;
// `PatchTag::STALE`.
const STALE = 0x80000000u;
const NORMALS_PER_VERTEX = 1u;
const MORPH_START = 0.7;
const MORPH_END = 0.95;
const NORMALS_PER_TRIANGLE = 2u;

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var heights: texture_2d<f32>;
@group(0) @binding(2) var normals: texture_2d<f32>;
@group(0) @binding(3) var bilinear: sampler;
// `VoidQuads`; bound where the DEM has voids.
@group(0) @binding(4) var void_quads: texture_2d<u32>;

// The number of the draw, with a dynamic offset; 0 for all unless the colour is by draw.
@group(0) @binding(5) var<uniform> draw_number: vec4<u32>;

struct Corner {
    @builtin(position) @invariant position_clip: vec4<f32>,
    // Metres from the eye, along the world's axes.
    @location(0) position_eye: vec3<f32>,
    // Where the normal comes from: column and row, or x and z of the vertex's own. One member for either, since every
    // interpolated number costs time.
    @location(1) normal_source: vec2<f32>,
    // Height in metres.
    @location(2) height_m: f32,
    // A `PatchTag`.
    @location(3) @interpolate(flat) tag: u32,
}

// ---- vertices --------------------------------------------------------------------------------------------------------

// The whole part of the difference is taken in integers, so nothing is lost far from the DEM's origin.
fn relative_to_eye(column_row: vec2<i32>, height_m: f32) -> vec3<f32> {
    let ground_m = vec2<f32>(column_row - frame.eye_sample) * frame.spacing_m - frame.eye_remainder_m;
    return vec3<f32>(ground_m.x, height_m - frame.eye_height_m, ground_m.y);
}

fn corner(column_row: vec2<i32>, height_m: f32, tag: u32) -> Corner {
    let position_eye = relative_to_eye(column_row, height_m);
    let position_clip = frame.clip_from_eye * vec4<f32>(position_eye, 1.0);
    var normal_source = vec2<f32>(column_row);
    if NORMALS == NORMALS_PER_VERTEX {
        normal_source = textureLoad(normals, column_row, 0).xy;
    }
    return Corner(position_clip, position_eye, normal_source, height_m, tag);
}

// `BakedVertex`; the instance index is the tag.
@vertex
fn vertex_baked(
    @location(0) column_row: vec2<u32>,
    @location(1) height_m: f32,
    @builtin(instance_index) tag: u32,
) -> Corner {
    return corner(vec2<i32>(column_row), height_m, tag);
}

// The same map as `PatchInstance::sample`.
fn sample_of(uv: vec2<u32>, origin: vec2<i32>, leg_u: vec2<i32>, leg_v: vec2<i32>) -> vec2<i32> {
    let local = vec2<i32>(uv);
    return clamp(origin + local.x * leg_u + local.y * leg_v, vec2<i32>(0), frame.last_sample);
}

// `LocalVertex` and `PatchInstance`.
@vertex
fn vertex_displaced(
    @location(0) uv: vec2<u32>,
    @location(1) origin: vec2<i32>,
    @location(2) leg_u: vec2<i32>,
    @location(3) leg_v: vec2<i32>,
    @location(4) tag: u32,
) -> Corner {
    let column_row = sample_of(uv, origin, leg_u, leg_v);
    return corner(column_row, height_of(column_row), tag);
}

fn height_of(column_row: vec2<i32>) -> f32 {
    return textureLoad(heights, column_row, 0).r;
}

// The same while levels glide into one another.
@vertex
fn vertex_morphed(
    @location(0) uv: vec2<u32>,
    @location(1) origin: vec2<i32>,
    @location(2) leg_u: vec2<i32>,
    @location(3) leg_v: vec2<i32>,
    @location(4) tag: u32,
) -> Corner {
    let column_row = sample_of(uv, origin, leg_u, leg_v);
    return corner(column_row, morphed_height_m(column_row), tag);
}

// As `Morph::height_m`.
fn morphed_height_m(column_row: vec2<i32>) -> f32 {
    let own_m = height_of(column_row);
    var side = MORPH_K;
    var reach_m = frame.morph_reach_m;
    for (var level = 0; level < MORPH_LEVELS; level++) {
        if any((column_row % side != vec2<i32>(0)) & (column_row != frame.last_sample)) {
            let distance_m = length(relative_to_eye(column_row, own_m));
            let share = clamp((distance_m / reach_m - MORPH_START) / (MORPH_END - MORPH_START), 0.0, 1.0);
            return (1.0 - share) * own_m + share * morph_target_m(column_row, side);
        }
        side *= MORPH_K;
        reach_m *= f32(MORPH_K);
    }
    return own_m;
}

// The height of a mesh with squares of `side` intervals, clamped to the DEM.
fn morph_target_m(column_row: vec2<i32>, side: i32) -> f32 {
    let first = column_row / side * side;
    let end = min(first + side, frame.last_sample);
    let uv = vec2<f32>(column_row - first) / vec2<f32>(max(end - first, vec2<i32>(1)));
    let north_east_m = height_of(vec2<i32>(end.x, first.y));
    let south_west_m = height_of(vec2<i32>(first.x, end.y));
    if uv.x + uv.y <= 1.0 {
        let apex_m = height_of(first);
        return apex_m + uv.x * (north_east_m - apex_m) + uv.y * (south_west_m - apex_m);
    }
    let apex_m = height_of(end);
    return apex_m + (1.0 - uv.x) * (south_west_m - apex_m) + (1.0 - uv.y) * (north_east_m - apex_m);
}

// ---- heights that a method brings along ------------------------------------------------------------------------------

// `TileUniforms` and `LevelUniforms` in tiles.rs; a test compares them.
struct Tiles {
    coarse_level: u32,
    coarse_step: u32,
    coarse_columns: u32,
    cell_side: u32,
    code_bytes: u32,
    scale_m: f32,
    offset_m: f32,
    padding: u32,
    levels: array<TileLevel, 6>,
}

struct TileLevel {
    window: u32,
    step: u32,
    first_tile: u32,
    tile_codes: u32,
}

@group(1) @binding(0) var<uniform> tiles: Tiles;
@group(1) @binding(1) var<storage, read> codes: array<u32>;

// The same place as `HeightTiles::code_of`.
fn code_of(column_row: vec2<i32>, origin: vec2<i32>, leg_v: vec2<i32>, level: u32) -> u32 {
    let at = vec2<u32>(column_row);
    if level >= tiles.coarse_level {
        let coarse = (at + tiles.coarse_step - 1u) / tiles.coarse_step;
        return coarse.y * tiles.coarse_columns + coarse.x;
    }
    let turned = select(0, 1, leg_v.x < 0);
    let cell = vec2<u32>(origin - turned) / tiles.cell_side;
    let of_level = tiles.levels[level];
    let place = cell % of_level.window;
    let inside = (at - cell * tiles.cell_side + of_level.step - 1u) / of_level.step;
    let tile = of_level.first_tile + (place.y * of_level.window + place.x) * of_level.tile_codes;
    return tile + inside.y * (tiles.cell_side / of_level.step + 1u) + inside.x;
}

// `HeightFormat::decode`, in single precision.
fn decoded_m(code: u32) -> f32 {
    let is_whole = tiles.code_bytes == 4u;
    let word = codes[select(code / 2u, code, is_whole)];
    let steps = (word >> (16u * (code % 2u))) & 0xffffu;
    return select(tiles.offset_m + f32(steps) * tiles.scale_m, bitcast<f32>(word), is_whole);
}

// As `vertex_displaced`, over the method's own tiles.
@vertex
fn vertex_tiled(
    @location(0) uv: vec2<u32>,
    @location(1) origin: vec2<i32>,
    @location(2) leg_u: vec2<i32>,
    @location(3) leg_v: vec2<i32>,
    @location(4) tag: u32,
) -> Corner {
    let column_row = sample_of(uv, origin, leg_u, leg_v);
    return corner(column_row, decoded_m(code_of(column_row, origin, leg_v, tag & 15u)), tag);
}

// ---- colours ---------------------------------------------------------------------------------------------------------

// Normals come from the DEM, which knows x and z of each. Read at every pixel, they do not change with the mesh. Where
// the DEM is not on the GPU, they are the triangles' own, which are seen from above.
fn unit_normal(in: Corner) -> vec3<f32> {
    if NORMALS == NORMALS_PER_TRIANGLE {
        let normal = normalize(cross(dpdx(in.position_eye), dpdy(in.position_eye)));
        return select(normal, -normal, normal.y < 0.0);
    }
    var xz = in.normal_source;
    if NORMALS != NORMALS_PER_VERTEX {
        xz = textureSample(normals, bilinear, (xz + 0.5) / vec2<f32>(textureDimensions(normals))).xy;
    }
    return normalize(vec3<f32>(xz.x, sqrt(max(1.0 - dot(xz, xz), 0.0)), xz.y));
}

// Meadow, dry grass, scree and snow by height; bare rock where it is steep.
fn ground_colour(height_m: f32, normal: vec3<f32>) -> vec3<f32> {
    let range_m = max(frame.height_range_m.y - frame.height_range_m.x, 1.0);
    let height = (height_m - frame.height_range_m.x) / range_m;
    var ground = mix(vec3<f32>(0.085, 0.150, 0.045), vec3<f32>(0.215, 0.205, 0.080), smoothstep(0.03, 0.42, height));
    ground = mix(ground, vec3<f32>(0.26, 0.22, 0.17), smoothstep(0.38, 0.68, height));
    let snow = smoothstep(0.70, 0.84, height + 0.20 * (normal.y - 0.85));
    ground = mix(ground, vec3<f32>(0.66, 0.69, 0.74), snow);
    let steep = smoothstep(0.92, 0.70, normal.y);
    return mix(ground, vec3<f32>(0.170, 0.148, 0.130), steep * (1.0 - 0.6 * snow));
}

fn from_hue(hue: f32, chroma: f32, lightness: f32) -> vec3<f32> {
    let wave = cos(6.2831853 * (hue + vec3<f32>(0.0, 0.667, 0.333)));
    return lightness * (1.0 + chroma * wave);
}

// Neighbouring numbers get far-apart hues: steps of the golden ratio.
fn patch_colour(patch_number: u32) -> vec3<f32> {
    let hue = fract(f32(patch_number & 0xffffu) * 0.61803399);
    let lightness = 0.17 + 0.12 * f32(patch_number * 7u % 5u) / 4.0;
    return from_hue(hue, 0.7, lightness);
}

// Red, orange, green, cyan, blue, violet; the second turn of the hues is darker. A tag has room for 16 levels.
fn level_colour(level: u32) -> vec3<f32> {
    let turn = f32(level / 8u);
    return from_hue(f32(level % 8u) / 8.0 + turn / 16.0, 0.85, 0.27 - 0.12 * turn);
}

// Where a height lies relative to one triangle: 0 on it. `uv` from the corner at the right angle.
fn above_triangle_m(height_m: f32, apex_m: f32, u_end_m: f32, v_end_m: f32, uv: vec2<f32>) -> f32 {
    return height_m - (apex_m + uv.x * (u_end_m - apex_m) + uv.y * (v_end_m - apex_m));
}

// |mesh - DEM| in metres: at a sample as the error oracle has it. Between samples a quad may be cut along either diagonal;
// what lies between the two surfaces is no error, so that a mesh of all samples has none.
fn error_m(column_row: vec2<f32>, mesh_m: f32) -> f32 {
    let first = clamp(vec2<i32>(floor(column_row)), vec2<i32>(0), frame.last_sample - 1);
    let uv = clamp(column_row - vec2<f32>(first), vec2<f32>(0.0), vec2<f32>(1.0));
    let nw_m = height_of(first);
    let ne_m = height_of(first + vec2<i32>(1, 0));
    let sw_m = height_of(first + vec2<i32>(0, 1));
    let se_m = height_of(first + vec2<i32>(1, 1));
    var rising_m = above_triangle_m(mesh_m, nw_m, ne_m, sw_m, uv);
    if uv.x + uv.y > 1.0 {
        rising_m = above_triangle_m(mesh_m, se_m, sw_m, ne_m, 1.0 - uv);
    }
    var falling_m = above_triangle_m(mesh_m, ne_m, nw_m, se_m, vec2<f32>(1.0 - uv.x, uv.y));
    if uv.y > uv.x {
        falling_m = above_triangle_m(mesh_m, sw_m, se_m, nw_m, vec2<f32>(uv.x, 1.0 - uv.y));
    }
    let is_between = rising_m * falling_m <= 0.0;
    return select(min(abs(rising_m), abs(falling_m)), 0.0, is_between);
}

// The same colours as `heat_colour` in look.rs; a test compares the two.
fn heat_colour(share: f32) -> vec3<f32> {
    if share > 1.0 {
        return vec3<f32>(0.55, 0.02, 0.40);
    }
    let cold = mix(vec3<f32>(0.03, 0.08, 0.25), vec3<f32>(0.02, 0.38, 0.42), smoothstep(0.0, 0.33, share));
    let warm = mix(cold, vec3<f32>(0.75, 0.62, 0.04), smoothstep(0.25, 0.66, share));
    return mix(warm, vec3<f32>(0.70, 0.04, 0.02), smoothstep(0.60, 1.0, share));
}

// Hue says the error in pixels, brightness the relief.
fn error_colour(in: Corner) -> vec3<f32> {
    let error_px = error_m(in.normal_source, in.height_m) * frame.metre_px_at_1_m / length(in.position_eye);
    return heat_colour(error_px / frame.error_scale_px);
}

fn patch_of(tag: u32) -> u32 {
    return (tag & ~STALE) >> 4u;
}

// The rows of cells follow each other in the order of the hues, as patches do.
fn cell_colour(column_row: vec2<f32>) -> vec3<f32> {
    let cell = vec2<u32>(column_row) / frame.cell_side;
    return patch_colour(cell.x + 31u * cell.y);
}

// Drawn for an older view: magenta stripes across the picture.
fn marked(colour: vec3<f32>, in: Corner) -> vec3<f32> {
    if !MARK_STALE {
        return colour;
    }
    let is_stripe = fract((in.position_clip.x + in.position_clip.y) / 12.0) < 0.5;
    return select(colour, vec3<f32>(0.75, 0.02, 0.45), is_stripe && (in.tag & STALE) != 0u);
}

fn surface_colour(in: Corner, normal: vec3<f32>) -> vec3<f32> {
    switch COLOUR {
        case COLOUR_BY_PATCH: { return patch_colour(patch_of(in.tag)); }
        case COLOUR_BY_CELL: { return cell_colour(in.normal_source); }
        case COLOUR_BY_DRAW: { return patch_colour(draw_number.x); }
        case COLOUR_BY_LEVEL: { return level_colour(in.tag & 15u); }
        case COLOUR_PLAIN: { return vec3<f32>(0.30); }
        case COLOUR_BY_ERROR: { return error_colour(in); }
        default: { return ground_colour(in.height_m, normal); }
    }
}

// One sun, and a sky that is brighter than the ground.
fn light(normal: vec3<f32>) -> vec3<f32> {
    let sun = vec3<f32>(1.00, 0.90, 0.74) * 2.0 * max(dot(normal, frame.to_sun), 0.0);
    let sky = mix(vec3<f32>(0.12, 0.11, 0.10), vec3<f32>(0.34, 0.43, 0.58), 0.5 + 0.5 * normal.y);
    return sun + sky;
}

// Grows with the square of the distance at first, so that the foreground stays clear.
fn haze(position_eye: vec3<f32>) -> f32 {
    let distance = length(position_eye) / frame.half_light_m;
    return 1.0 - exp2(-distance * distance);
}

// x, z and y of the normal as red, green and blue; squared, since the target takes linear light.
fn normal_colour(normal: vec3<f32>) -> vec3<f32> {
    let colour = 0.5 + 0.5 * normal.xzy;
    return colour * colour;
}

fn lit(in: Corner, normal: vec3<f32>) -> vec3<f32> {
    if COLOUR == COLOUR_BY_NORMAL {
        return normal_colour(normal);
    }
    if COLOUR == COLOUR_BY_ERROR {
        return surface_colour(in, normal) * (0.65 + 0.35 * max(dot(normal, frame.to_sun), 0.0));
    }
    return marked(surface_colour(in, normal) * light(normal), in);
}

fn hazed(colour: vec3<f32>, position_eye: vec3<f32>) -> vec4<f32> {
    return vec4<f32>(mix(colour, frame.haze_colour, haze(position_eye)), 1.0);
}

fn terrain_colour(in: Corner) -> vec4<f32> {
    return hazed(lit(in, unit_normal(in)), in.position_eye);
}

@fragment
fn fragment_terrain(in: Corner) -> @location(0) vec4<f32> {
    return terrain_colour(in);
}

// ---- voids -----------------------------------------------------------------------------------------------------------

// Whether the quad at or under a point is void: 32 quads a texel, a row of quads from a texel of its own on. Only what is
// left of the quad's number beside the eye's is a float, so that it is exact near the eye.
fn is_void(position_eye: vec3<f32>) -> bool {
    let from_eye = vec2<i32>(floor((position_eye.xz + frame.eye_remainder_m) / frame.spacing_m));
    let quad = vec2<u32>(clamp(frame.eye_sample + from_eye, vec2<i32>(0), frame.last_sample - 1));
    let texel = quad.y * ((u32(frame.last_sample.x) + 31u) / 32u) + quad.x / 32u;
    let width = textureDimensions(void_quads).x;
    let bits = textureLoad(void_quads, vec2<u32>(texel % width, texel / width), 0).r;
    return ((bits >> (quad.x % 32u)) & 1u) == 1u;
}

// The colour comes first: slopes between pixels need all of them.
@fragment
fn fragment_terrain_with_voids(in: Corner) -> @location(0) vec4<f32> {
    let colour = terrain_colour(in);
    if is_void(in.position_eye) {
        discard;
    }
    return colour;
}

// ---- wireframe -------------------------------------------------------------------------------------------------------

// Pixels between neighbouring lines, roughly. A leg is as long as the spacing or as the mean of all triangles in the
// picture, whichever is longer; then it is foreshortened by the slope against the view ray.
fn line_gap_px(position_eye: vec3<f32>, normal: vec3<f32>) -> f32 {
    let distance_m = length(position_eye);
    let leg_px = max(frame.spacing_px_at_1_m / distance_m, frame.mean_leg_px);
    return leg_px * abs(dot(normal, position_eye)) / distance_m;
}

// Lines fade into the terrain where they would merge into a black mass. The blending takes the darker of the line and
// what is there already, so that it does not matter which line is drawn first.
fn line_colour(in: Corner) -> vec4<f32> {
    let normal = unit_normal(in);
    let opacity = 0.75 * smoothstep(0.4, 3.0, line_gap_px(in.position_eye, normal));
    return hazed(mix(lit(in, normal), vec3<f32>(0.012, 0.018, 0.035), opacity), in.position_eye);
}

@fragment
fn fragment_wireframe(in: Corner) -> @location(0) vec4<f32> {
    return line_colour(in);
}

@fragment
fn fragment_wireframe_with_voids(in: Corner) -> @location(0) vec4<f32> {
    let colour = line_colour(in);
    if is_void(in.position_eye) {
        discard;
    }
    return colour;
}
