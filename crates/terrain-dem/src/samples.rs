//! Numbers as files hold them: type, byte order, and the way to a height.

use crate::raster::Heights;

/// How a file holds one sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleType {
    U8,
    I8,
    U16,
    I16,
    U32,
    I32,
    U64,
    I64,
    F16,
    F32,
    F64,
    /// Decimal digits.
    Text,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ByteOrder {
    Little,
    Big,
}

impl SampleType {
    /// Bytes a sample; 0 for text, which has no fixed length.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 | Self::I8 => 1,
            Self::U16 | Self::I16 | Self::F16 => 2,
            Self::U32 | Self::I32 | Self::F32 => 4,
            Self::U64 | Self::I64 | Self::F64 => 8,
            Self::Text => 0,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "uint8",
            Self::I8 => "int8",
            Self::U16 => "uint16",
            Self::I16 => "int16",
            Self::U32 => "uint32",
            Self::I32 => "int32",
            Self::U64 => "uint64",
            Self::I64 => "int64",
            Self::F16 => "float16",
            Self::F32 => "float32",
            Self::F64 => "float64",
            Self::Text => "text",
        }
    }

    pub fn parse(name: &str) -> Option<Self> {
        use SampleType::*;
        [U8, I8, U16, I16, U32, I32, U64, I64, F16, F32, F64].into_iter().find(|one| one.name() == name)
    }

    pub fn is_float(self) -> bool {
        matches!(self, Self::F16 | Self::F32 | Self::F64 | Self::Text)
    }

    /// The number as a sample of this type would hold it: a void of -9999.9 in float32 is not the f64 of that name.
    pub fn rounded(self, number: f64) -> f64 {
        match self {
            Self::F32 => number as f32 as f64,
            Self::F16 => rounded_to_half(number),
            _ => number,
        }
    }
}

/// Where the samples of one row are in its bytes.
#[derive(Clone, Copy, Debug)]
pub struct Packing {
    pub samples: SampleType,
    pub order: ByteOrder,
    /// From one sample to the next of the same band, in bytes.
    pub stride: usize,
}

impl Packing {
    /// Puts the samples in `bytes`, one every `stride` bytes from the first on, into a row from a column on.
    pub fn put(self, heights: &mut Heights, row: u32, column: u32, bytes: &[u8]) {
        if (self.samples, self.order, self.stride) == (SampleType::F32, ByteOrder::Little, 4) {
            return heights.put_floats(row, column, bytes.as_chunks().0);
        }
        let at = At { heights, row, column, bytes, packing: self };
        match self.samples {
            SampleType::U8 => at.put(|b: [u8; 1]| b[0] as f64),
            SampleType::I8 => at.put(|b: [u8; 1]| b[0] as i8 as f64),
            SampleType::U16 => at.put(|b| u16::from_le_bytes(b) as f64),
            SampleType::I16 => at.put(|b| i16::from_le_bytes(b) as f64),
            SampleType::U32 => at.put(|b| u32::from_le_bytes(b) as f64),
            SampleType::I32 => at.put(|b| i32::from_le_bytes(b) as f64),
            SampleType::U64 => at.put(|b| u64::from_le_bytes(b) as f64),
            SampleType::I64 => at.put(|b| i64::from_le_bytes(b) as f64),
            SampleType::F16 => at.put(|b| half(u16::from_le_bytes(b))),
            SampleType::F32 => at.put(|b| f32::from_le_bytes(b) as f64),
            SampleType::F64 => at.put(f64::from_le_bytes),
            SampleType::Text => unreachable!("text is not packed"),
        }
    }
}

struct At<'a, 'h> {
    heights: &'a mut Heights<'h>,
    row: u32,
    column: u32,
    bytes: &'a [u8],
    packing: Packing,
}

impl At<'_, '_> {
    /// `value` takes little-endian bytes.
    fn put<const N: usize>(self, value: impl Fn([u8; N]) -> f64) {
        let Self { heights, row, column, bytes, packing: Packing { order, stride, .. } } = self;
        let turned = |mut bytes: [u8; N]| {
            bytes.reverse();
            bytes
        };
        // Samples side by side, as nearly all are, are many times as quick without a stride.
        let dense = || bytes.as_chunks::<N>().0.iter().copied();
        let sparse = || bytes.chunks(stride).filter_map(|sample| sample.first_chunk::<N>().copied());
        match (order, stride == N) {
            (ByteOrder::Little, true) => heights.put(row, column, dense().map(value)),
            (ByteOrder::Little, false) => heights.put(row, column, sparse().map(value)),
            (ByteOrder::Big, true) => heights.put(row, column, dense().map(turned).map(value)),
            (ByteOrder::Big, false) => heights.put(row, column, sparse().map(turned).map(value)),
        }
    }
}

/// A half-precision float (IEEE 754 binary16), exactly.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = ((bits >> 10) & 31, (bits & 1023) as f64 / 1024.0);
    let magnitude = match exponent {
        0 => fraction * 2f64.powi(-14),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1.0 + fraction) * 2f64.powi(exponent as i32 - 15),
    };
    if bits >> 15 == 1 { -magnitude } else { magnitude }
}

/// The nearest half-precision float; of two as near, the one with an even fraction.
fn rounded_to_half(number: f64) -> f64 {
    if !number.is_finite() || number == 0.0 {
        return number;
    }
    // The highest 11 bits stay; the exponent ends at that of the smallest normal number.
    let exponent = libm::ilogb(number).max(-14);
    let step = 2f64.powi(exponent - 10);
    let rounded = (number / step).round_ties_even() * step;
    if rounded.abs() > 65_504.0 { f64::INFINITY.copysign(number) } else { rounded }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_half_is_its_own_nearest_and_voids_are_found() {
        for bits in (0..=u16::MAX).filter(|bits| bits & 0x7c00 != 0x7c00) {
            let (value, next) = (half(bits), half((bits & 0x8000) | ((bits & 0x7fff) + 1)));
            assert_eq!(rounded_to_half(value), value, "{bits:x}");
            if next.is_finite() {
                let nearer = value + (next - value) * 0.49;
                assert_eq!((rounded_to_half(nearer), rounded_to_half(next)), (value, next), "{bits:x}");
                let tie = if bits % 2 == 0 { value } else { next };
                assert_eq!(rounded_to_half((value + next) / 2.0), tie, "{bits:x}");
            }
        }
        // What GDAL writes into a float16 file for this void.
        assert_eq!(SampleType::F16.rounded(-9999.0), -10_000.0);
        assert_eq!((rounded_to_half(65_519.9), rounded_to_half(-65_520.0)), (65_504.0, f64::NEG_INFINITY));
    }

    #[test]
    fn half_precision_is_exact() {
        let cases =
            [(0x3c00, 1.0), (0xc000, -2.0), (0x7bff, 65504.0), (0x0001, 2f64.powi(-24)), (0x3555, 0.333251953125)];
        for (bits, expected) in cases {
            assert_eq!(half(bits), expected);
        }
        assert!(half(0x7c00) == f64::INFINITY && half(0x7e00).is_nan() && half(0x8000).is_sign_negative());
    }
}
