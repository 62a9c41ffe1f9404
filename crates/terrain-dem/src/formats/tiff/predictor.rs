//! What is done to the samples of a row before they are compressed.

use crate::samples::{ByteOrder, SampleType};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Predictor {
    None,
    /// Differences between neighbours (TIFF 6.0, section 14).
    Differences,
    /// Differences between the bytes of floats, sorted by significance (Adobe Photoshop TIFF Technical Note 3).
    Floats,
}

impl Predictor {
    /// By the number in the tag; what is wrong with it.
    pub fn of(tag: u64, samples: SampleType) -> Result<Self, String> {
        match tag {
            0 | 1 => Ok(Self::None),
            2 => Ok(Self::Differences),
            3 if samples.is_float() => Ok(Self::Floats),
            3 => Err(format!("{} samples with predictor 3; expected floats with it", samples.name())),
            _ => Err(format!("unknown predictor {tag}; expected 1 to 3")),
        }
    }

    /// Gives a row its samples back, and says in which byte order they now are. `sorted` is room to work in.
    pub fn undo(self, row: &mut [u8], row_layout: RowLayout, sorted: &mut Vec<u8>) -> ByteOrder {
        let RowLayout { interleaved, sample_bytes, order } = row_layout;
        match self {
            Self::None => return order,
            Self::Differences => {
                if order == ByteOrder::Big {
                    row.chunks_exact_mut(sample_bytes).for_each(<[u8]>::reverse);
                }
                match sample_bytes {
                    1 => sum::<1>(row, interleaved),
                    2 => sum::<2>(row, interleaved),
                    4 => sum::<4>(row, interleaved),
                    _ => sum::<8>(row, interleaved),
                }
            }
            Self::Floats => {
                sum::<1>(row, interleaved);
                unsort(row, sample_bytes, sorted);
            }
        }
        ByteOrder::Little
    }
}

#[derive(Clone, Copy)]
pub struct RowLayout {
    /// Samples that stand together at one place.
    pub interleaved: usize,
    pub sample_bytes: usize,
    pub order: ByteOrder,
}

/// Adds to each little-endian number of `N` bytes the one `apart` numbers before it.
fn sum<const N: usize>(row: &mut [u8], apart: usize) {
    let (numbers, _) = row.as_chunks_mut::<N>();
    for i in apart..numbers.len() {
        let before = wide(numbers[i - apart]);
        let own = wide(numbers[i]).wrapping_add(before).to_le_bytes();
        numbers[i].copy_from_slice(&own[..N]);
    }
}

fn wide<const N: usize>(bytes: [u8; N]) -> u64 {
    let mut all = [0; 8];
    all[..N].copy_from_slice(&bytes);
    u64::from_le_bytes(all)
}

/// From all highest bytes, then all second bytes, ... to little-endian numbers.
fn unsort(row: &mut [u8], sample_bytes: usize, sorted: &mut Vec<u8>) {
    sorted.clear();
    sorted.extend_from_slice(row);
    let count = row.len() / sample_bytes;
    for (i, number) in row.chunks_exact_mut(sample_bytes).enumerate() {
        for (place, byte) in number.iter_mut().rev().enumerate() {
            *byte = sorted[place * count + i];
        }
    }
}
