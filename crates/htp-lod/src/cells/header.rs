//! The first bytes of a file of cells.

use terrain_core::{HeightFormat, Heightmap};

use super::file::CellsError;
use super::scan::check_shape;
use super::{CellsHeader, codes};

pub(super) const MAGIC: [u8; 8] = *b"htp-cell";

/// Rises whenever the same DEM gets other bytes, or the layout changes.
pub(super) const VERSION: u32 = 1;

/// Bytes of the header, its checksum included.
pub(super) const HEADER: usize = 84;

impl CellsHeader {
    pub(super) fn to_bytes(&self) -> [u8; HEADER] {
        let (height_bytes, scale_m, offset_m) = match self.format {
            HeightFormat::F32 => (4_u32, 0.0, 0.0),
            HeightFormat::U16 { scale_m, offset_m } => (2, scale_m, offset_m),
        };
        let mut bytes = MAGIC.to_vec();
        for number in [VERSION, self.k, self.layers, self.streamed, self.samples[0], self.samples[1]] {
            bytes.extend(number.to_le_bytes());
        }
        self.spacing_m.iter().for_each(|metres| bytes.extend(metres.to_le_bytes()));
        bytes.extend(height_bytes.to_le_bytes());
        [scale_m, offset_m].iter().for_each(|metres: &f64| bytes.extend(metres.to_le_bytes()));
        self.height_range_m.iter().for_each(|metres| bytes.extend(metres.to_le_bytes()));
        bytes.extend(self.heights_crc.to_le_bytes());
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        bytes.try_into().expect("84 bytes")
    }

    /// Refuses what no cutter writes, so that whoever computes with a header need not fear overflows.
    pub(super) fn parse(bytes: &[u8; HEADER]) -> Result<Self, CellsError> {
        let mut at = Fields(bytes);
        if at.take() != MAGIC {
            return Err(CellsError::NoCells);
        }
        let version = at.u32();
        if version != VERSION {
            return Err(CellsError::Version { found: version });
        }
        let (before, checksum) = bytes.split_last_chunk().expect("longer than a checksum");
        if crc32fast::hash(before) != u32::from_le_bytes(*checksum) {
            return Err(CellsError::damaged("header"));
        }
        let [k, layers, streamed, columns, rows] = [(); 5].map(|_| at.u32());
        let spacing_m = [(); 2].map(|_| at.f64());
        let (height_bytes, scale_m, offset_m) = (at.u32(), at.f64(), at.f64());
        let format = match height_bytes {
            2 => HeightFormat::U16 { scale_m, offset_m },
            4 => HeightFormat::F32,
            _ => return Err(CellsError::damaged("header")),
        };
        let height_range_m = [(); 2].map(|_| f32::from_le_bytes(at.take()));
        let samples = [columns, rows];
        let header = Self { k, layers, samples, spacing_m, format, height_range_m, streamed, heights_crc: at.u32() };
        if header.is_sound() { Ok(header) } else { Err(CellsError::damaged("header")) }
    }

    fn is_sound(&self) -> bool {
        let [low, high] = self.height_range_m;
        check_shape(&self.options()).is_ok()
            && (1..self.layers).contains(&self.streamed)
            && self.samples.iter().all(|side| (2..=Heightmap::MAX_SIDE).contains(side))
            && self.spacing_m.iter().all(|metres| metres.is_finite() && *metres > 0.0)
            && codes::is_sound(self.format)
            && low.is_finite()
            && high.is_finite()
            && low <= high
    }
}

/// Little-endian fields, one after the other.
struct Fields<'a>(&'a [u8]);

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let (field, rest) = self.0.split_first_chunk().expect("fields within the header");
        self.0 = rest;
        *field
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }
}
