// The difference of two pictures of one size, many times brighter than it is, over a dark copy of the first.

@group(0) @binding(0) var left: texture_2d<f32>;
@group(0) @binding(1) var right: texture_2d<f32>;

@vertex
fn vertex_screen(@builtin(vertex_index) corner: u32) -> @builtin(position) vec4<f32> {
    // One triangle that covers the screen.
    return vec4<f32>(f32(corner / 2u) * 4.0 - 1.0, f32(corner % 2u) * 4.0 - 1.0, 0.0, 1.0);
}

@fragment
fn fragment_difference(@builtin(position) pixel: vec4<f32>) -> @location(0) vec4<f32> {
    let at = vec2<i32>(pixel.xy);
    let a = textureLoad(left, at, 0).rgb;
    let b = textureLoad(right, at, 0).rgb;
    let change = abs(a - b);
    let strength = clamp(8.0 * max(change.r, max(change.g, change.b)), 0.0, 1.0);
    let grey = dot(a, vec3<f32>(0.2126, 0.7152, 0.0722));
    let hot = mix(vec3<f32>(0.55, 0.03, 0.02), vec3<f32>(1.0, 0.85, 0.35), strength);
    return vec4<f32>(mix(vec3<f32>(0.25 * grey), hot, sqrt(strength)), 1.0);
}
