//! The first bytes of a file of cells.

use terrain_core::{HeightFormat, Heightmap};

use super::file::{CellSource, CellsError};
use super::scan::check_shape;
use super::{CellsHeader, Provenance, Voids, codes};

pub(super) const MAGIC: [u8; 8] = *b"htp-cell";

/// Rises whenever the same DEM gets other bytes, or the layout changes.
pub(super) const VERSION: u32 = 3;

/// Bytes before the texts, with a checksum at their end.
const NUMBERS: usize = 112;

/// Bytes of a checksum.
const CHECKSUM: usize = 4;

impl CellsHeader {
    /// Bytes of the header.
    pub(super) fn bytes(&self) -> u64 {
        (NUMBERS + self.provenance.texts().map(str::len).iter().sum::<usize>() + CHECKSUM) as u64
    }

    pub(super) fn to_bytes(&self) -> Vec<u8> {
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
        let Voids { count, crc } = self.voids.unwrap_or(Voids { count: 0, crc: 0 });
        bytes.extend(count.to_le_bytes());
        bytes.extend(crc.to_le_bytes());
        let texts = self.provenance.texts();
        texts.iter().for_each(|text| bytes.extend((text.len() as u32).to_le_bytes()));
        bytes.extend(crc32fast::hash(&bytes).to_le_bytes());
        debug_assert_eq!(bytes.len(), NUMBERS);
        bytes.extend(texts.concat().bytes());
        bytes.extend(crc32fast::hash(&bytes[NUMBERS..]).to_le_bytes());
        bytes
    }

    /// Refuses what no cutter writes, so that whoever computes with a header need not fear overflows.
    pub(super) fn read(source: &dyn CellSource) -> Result<Self, CellsError> {
        let (mut bytes, length) = ([0; NUMBERS], source.len()?);
        if length < NUMBERS as u64 {
            return Err(CellsError::NoCells);
        }
        source.read_at(0, &mut bytes)?;
        let (mut header, texts) = Self::parse(&bytes)?;
        let mut bytes = vec![0; texts.iter().sum::<usize>() + CHECKSUM];
        if length < (NUMBERS + bytes.len()) as u64 {
            return Err(CellsError::damaged("header"));
        }
        source.read_at(NUMBERS as u64, &mut bytes)?;
        header.provenance = parse_texts(&bytes, texts).ok_or_else(|| CellsError::damaged("header"))?;
        Ok(header)
    }

    /// All but the texts, and their lengths.
    fn parse(bytes: &[u8; NUMBERS]) -> Result<(Self, [usize; 4]), CellsError> {
        let mut at = Fields(bytes);
        if at.take() != MAGIC {
            return Err(CellsError::NoCells);
        }
        let version = at.u32();
        if version != VERSION {
            return Err(CellsError::Version { found: version });
        }
        let damaged = || CellsError::damaged("header");
        if !has_checksum(bytes) {
            return Err(damaged());
        }
        let [k, layers, streamed, columns, rows] = [(); 5].map(|_| at.u32());
        let spacing_m = [(); 2].map(|_| at.f64());
        let (height_bytes, scale_m, offset_m) = (at.u32(), at.f64(), at.f64());
        let format = match height_bytes {
            2 => HeightFormat::U16 { scale_m, offset_m },
            4 => HeightFormat::F32,
            _ => return Err(damaged()),
        };
        let height_range_m = [(); 2].map(|_| f32::from_le_bytes(at.take()));
        let (heights_crc, samples, provenance) = (at.u32(), [columns, rows], Provenance::default());
        let voids = Voids { count: at.u64(), crc: at.u32() };
        let voids = (voids != Voids { count: 0, crc: 0 }).then_some(voids);
        let texts = [(); 4].map(|_| at.u32() as usize);
        let header =
            Self { k, layers, samples, spacing_m, format, height_range_m, streamed, heights_crc, voids, provenance };
        let is_sound = header.is_sound() && texts.iter().all(|bytes| *bytes <= Provenance::MAX_BYTES);
        if is_sound { Ok((header, texts)) } else { Err(damaged()) }
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
            && self.voids.is_none_or(|voids| (1..=self.count()).contains(&voids.count))
    }
}

/// Whether some bytes end with the checksum of those before. A fuzzer gets past it: it would not guess one.
fn has_checksum(bytes: &[u8]) -> bool {
    let (before, checksum) = bytes.split_last_chunk().expect("longer than a checksum");
    cfg!(fuzzing) || crc32fast::hash(before) == u32::from_le_bytes(*checksum)
}

/// Texts of some lengths, and their checksum.
fn parse_texts(bytes: &[u8], lengths: [usize; 4]) -> Option<Provenance> {
    if !has_checksum(bytes) {
        return None;
    }
    let mut rest = std::str::from_utf8(&bytes[..bytes.len() - CHECKSUM]).ok()?;
    let mut next = |bytes: usize| {
        let (text, after) = rest.split_at_checked(bytes)?;
        rest = after;
        Some((!text.is_empty()).then(|| text.to_owned()))
    };
    let [source, licence, notice, place] = lengths;
    Some(Provenance { source: next(source)?, licence: next(licence)?, notice: next(notice)?, place: next(place)? })
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

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }
}
