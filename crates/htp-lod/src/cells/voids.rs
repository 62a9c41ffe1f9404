//! The voids of a DEM beside its cells: a bit a sample, row by row over the DEM, after all records. Heights and errors are
//! those of the fill, so that who flies needs none of this; who draws or measures does.

use terrain_core::VoidMask;

use super::CellsHeader;
use super::file::{CellSource, CellsError};

/// What a header says of the voids that come last in its file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Voids {
    /// Samples without a height; more than 0.
    pub count: u64,
    /// CRC-32 of the mask's bytes.
    pub crc: u32,
}

impl Voids {
    /// Those of a mask, if it has any.
    pub fn of(mask: &VoidMask) -> Option<Self> {
        (mask.count() > 0).then(|| Self { count: mask.count(), crc: crc32fast::hash(&to_bytes(mask)) })
    }
}

/// Bytes of the mask of a DEM with voids.
pub(super) fn length(header: &CellsHeader) -> u64 {
    if header.voids.is_some() { header.count().div_ceil(u64::BITS.into()) * size_of::<u64>() as u64 } else { 0 }
}

pub(super) fn to_bytes(mask: &VoidMask) -> Vec<u8> {
    mask.words().iter().flat_map(|word| word.to_le_bytes()).collect()
}

/// Reads the mask from a place in a file that is long enough for it.
pub(super) fn read(source: &dyn CellSource, header: &CellsHeader, at: u64) -> Result<Option<VoidMask>, CellsError> {
    let Some(voids) = header.voids else { return Ok(None) };
    let mut bytes = vec![0; length(header) as usize];
    source.read_at(at, &mut bytes)?;
    let words = bytes.as_chunks().0.iter().map(|word| u64::from_le_bytes(*word)).collect();
    let [columns, rows] = header.samples;
    let has_checksum = cfg!(fuzzing) || crc32fast::hash(&bytes) == voids.crc;
    let mask = VoidMask::from_words(columns, rows, words).filter(|mask| has_checksum && mask.count() == voids.count);
    mask.map(Some).ok_or_else(|| CellsError::damaged("voids"))
}
