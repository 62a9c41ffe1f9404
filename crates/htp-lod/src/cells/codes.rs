//! Heights to codes and back.

use terrain_core::HeightFormat;

/// Appends a height's code. A height that the format cannot hold gets some other code: ask [`holds`] first.
pub(super) fn push(format: HeightFormat, height_m: f32, codes: &mut Vec<u8>) {
    match format {
        HeightFormat::F32 => codes.extend(height_m.to_le_bytes()),
        HeightFormat::U16 { scale_m, offset_m } => codes.extend(code(height_m, scale_m, offset_m).to_le_bytes()),
    }
}

/// Whether codes have heights at all: only then can they be told apart, and computed with.
pub(super) fn is_sound(format: HeightFormat) -> bool {
    match format {
        HeightFormat::F32 => true,
        HeightFormat::U16 { scale_m, offset_m } => scale_m.is_finite() && scale_m != 0.0 && offset_m.is_finite(),
    }
}

/// Whether a height comes back as it was, bit for bit.
pub(super) fn holds(format: HeightFormat, height_m: f32) -> bool {
    match format {
        HeightFormat::F32 => true,
        HeightFormat::U16 { scale_m, offset_m } => {
            let code = code(height_m, scale_m, offset_m).to_le_bytes();
            format.decode(&code).to_bits() == height_m.to_bits()
        }
    }
}

fn code(height_m: f32, scale_m: f64, offset_m: f64) -> u16 {
    ((height_m as f64 - offset_m) / scale_m).round() as u16
}

/// All heights of some codes; of a whole number of codes.
pub(super) fn decode(format: HeightFormat, codes: &[u8]) -> Vec<f32> {
    codes.chunks(format.bytes() as usize).map(|code| format.decode(code)).collect()
}

/// Zeros up to a multiple of 4 bytes.
pub(super) fn pad(codes: &mut Vec<u8>) {
    codes.resize(codes.len().next_multiple_of(4), 0);
}
