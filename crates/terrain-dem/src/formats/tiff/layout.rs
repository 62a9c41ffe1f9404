//! Where the samples of a TIFF are: strips or tiles ("chunks" here), and how they are packed.

use crate::DemError;
use crate::formats::convert;
use crate::formats::tiff::codec::Compression;
use crate::formats::tiff::ifd::Tags;
use crate::formats::tiff::predictor::Predictor;
use crate::input::Input;
use crate::samples::SampleType;

/// The longest row of a chunk that is read, in bytes.
const MAX_ROW_BYTES: u64 = 64 << 20;

const COLOURS: u64 = 2;
const PALETTE: u64 = 3;

pub struct Layout {
    pub columns: u32,
    pub rows: u32,
    pub samples: SampleType,
    pub bands: u32,
    /// Each band has chunks of its own.
    pub is_planar: bool,
    /// Red, green and blue, as the file says.
    pub is_colour: bool,
    pub compression: Compression,
    pub predictor: Predictor,
    pub is_tiled: bool,
    pub chunk_columns: u32,
    pub chunk_rows: u32,
    /// First byte and count of bytes in the file; both 0 for a chunk that was never written.
    pub chunks: Vec<[u64; 2]>,
}

impl Layout {
    pub fn read(input: &mut Input, tags: &Tags) -> Result<Self, DemError> {
        check_picture(input, tags)?;
        let [columns, rows] = [side(input, tags, 256, "columns")?, side(input, tags, 257, "rows")?];
        let samples = sample_type(input, tags)?;
        let compression = Compression::of(tags.whole(input, 259, 1)?).map_err(|what| unreadable(input, &what))?;
        let predictor = Predictor::of(tags.whole(input, 317, 1)?, samples).map_err(|what| unreadable(input, &what))?;
        let is_tiled = tags.count(324).is_some();
        let [chunk_columns, chunk_rows] = match is_tiled {
            true => [side(input, tags, 322, "columns a tile")?, side(input, tags, 323, "rows a tile")?],
            // The largest number stands for a single strip.
            false => [columns, tags.whole(input, 278, rows as u64)?.clamp(1, rows as u64) as u32],
        };
        let mut layout = Self {
            columns,
            rows,
            samples,
            bands: u32::try_from(tags.whole(input, 277, 1)?).unwrap_or(u32::MAX).max(1),
            is_planar: tags.whole(input, 284, 1)? == 2,
            is_colour: tags.whole(input, 262, 1)? == COLOURS,
            compression,
            predictor,
            is_tiled,
            chunk_columns,
            chunk_rows,
            chunks: Vec::new(),
        };
        layout.check_row().map_err(|reason| input.refuse(reason))?;
        layout.chunks = layout.read_chunks(input, tags)?;
        layout.check_chunks(input)?;
        Ok(layout)
    }

    /// Chunks side by side.
    pub fn across(&self) -> u64 {
        self.columns.div_ceil(self.chunk_columns) as u64
    }

    /// Chunks of one band, or of all where the bands stand together.
    pub fn chunks_a_plane(&self) -> u64 {
        self.across() * self.rows.div_ceil(self.chunk_rows) as u64
    }

    /// Samples that stand together at one place.
    pub fn interleaved(&self) -> u32 {
        if self.is_planar { 1 } else { self.bands }
    }

    pub fn row_bytes(&self) -> u64 {
        self.chunk_columns as u64 * self.interleaved() as u64 * self.samples.bytes() as u64
    }

    /// Rows of a chunk that are within the picture.
    pub fn rows_of(&self, chunk: u64) -> u32 {
        let first = (chunk % self.chunks_a_plane() / self.across()) as u32 * self.chunk_rows;
        self.chunk_rows.min(self.rows - first)
    }

    pub fn chunk_name(&self) -> &'static str {
        if self.is_tiled { "tile" } else { "strip" }
    }

    /// Makes longer strips of those that follow each other in the file, of `bytes` or more where there are as many: GDAL writes
    /// some 8 KB a strip, less than a read is worth.
    pub fn join_strips(&mut self, bytes: u64) {
        let strip_bytes = self.row_bytes() * self.chunk_rows as u64;
        let joined = bytes.div_ceil(strip_bytes) as usize;
        let is_plain = (self.compression, self.is_tiled, self.is_planar) == (Compression::None, false, false);
        let is_next = |pair: &[[u64; 2]]| pair[0][1] == strip_bytes && pair[0][0] + strip_bytes == pair[1][0];
        let is_last_there = self.chunks.last().is_some_and(|[_, bytes]| *bytes != 0);
        if is_plain && is_last_there && self.chunks.windows(2).all(is_next) {
            let join = |strips: &[[u64; 2]]| [strips[0][0], strips.iter().map(|[_, bytes]| bytes).sum()];
            self.chunks = self.chunks.chunks(joined).map(join).collect();
            self.chunk_rows *= joined as u32;
        }
    }

    fn check_row(&self) -> Result<(), String> {
        let bytes = self.chunk_columns as u64 * self.samples.bytes() as u64;
        if bytes.saturating_mul(self.interleaved() as u64) <= MAX_ROW_BYTES {
            return Ok(());
        }
        let (columns, bands) = (self.chunk_columns, self.interleaved());
        Err(format!("a TIFF with rows of {columns} x {bands} samples; expected at most {MAX_ROW_BYTES} bytes: crop it"))
    }

    fn read_chunks(&self, input: &mut Input, tags: &Tags) -> Result<Vec<[u64; 2]>, DemError> {
        let (offsets, counts) = if self.is_tiled { (324, 325) } else { (273, 279) };
        let planes = if self.is_planar { self.bands as u64 } else { 1 };
        let expected = self.chunks_a_plane().saturating_mul(planes);
        for (tag, what) in [(offsets, "offsets"), (counts, "byte counts")] {
            let (found, name) = (tags.count(tag).unwrap_or(0), self.chunk_name());
            if found != expected {
                let reason =
                    format!("a TIFF of {found} {what} of {name}s; expected {expected} by its size: fetch it again");
                return Err(input.refuse(reason));
            }
        }
        let (offsets, counts) = (tags.wholes(input, offsets)?, tags.wholes(input, counts)?);
        if offsets.len() != counts.len() || offsets.len() as u64 != expected {
            return Err(input.refuse("a TIFF whose list of chunks is not of whole numbers: fetch it again"));
        }
        Ok(offsets.into_iter().zip(counts).map(<[u64; 2]>::from).collect())
    }

    /// What the header promises must be in the file, before anything is allocated for it.
    fn check_chunks(&self, input: &Input) -> Result<(), DemError> {
        let name = self.chunk_name();
        if self.chunks.iter().all(|[_, bytes]| *bytes == 0) {
            return Err(input.refuse(format!("a TIFF without any {name}s; expected at least one: fetch it again")));
        }
        for (index, &[offset, bytes]) in self.chunks.iter().enumerate().filter(|(_, [_, bytes])| *bytes != 0) {
            if !input.holds(offset, bytes) {
                let length = input.length;
                let reason = format!(
                    "{length} bytes; expected {name} {index} at byte {offset}, {bytes} bytes long: fetch it again"
                );
                return Err(input.refuse(reason));
            }
            let needed = self.row_bytes() * self.rows_of(index as u64) as u64;
            if needed > bytes.saturating_mul(self.compression.most_a_byte()) {
                let reason =
                    format!("{name} {index} has {bytes} bytes; expected {needed} of samples in it: fetch it again");
                return Err(input.refuse(reason));
            }
        }
        Ok(())
    }
}

/// What is no grid of numbers, whatever else the tags say.
fn check_picture(input: &mut Input, tags: &Tags) -> Result<(), DemError> {
    if tags.whole(input, 262, 1)? == PALETTE {
        return Err(input.refuse("a TIFF of a palette, which is a picture; expected one number a sample"));
    }
    if tags.whole(input, 266, 1)? != 1 {
        return Err(unreadable(input, "bits in reverse order; expected the highest first"));
    }
    Ok(())
}

fn unreadable(input: &Input, what: &str) -> DemError {
    let reason = format!("a TIFF of {what}: {}", convert(&input.shown));
    input.refuse(reason)
}

fn side(input: &mut Input, tags: &Tags, tag: u16, what: &str) -> Result<u32, DemError> {
    let found = tags.whole(input, tag, 0)?;
    match u32::try_from(found) {
        Ok(side @ 1..) => Ok(side),
        _ => Err(input.refuse(format!("a TIFF of {found} {what}; expected 1 or more: fetch it again"))),
    }
}

fn sample_type(input: &mut Input, tags: &Tags) -> Result<SampleType, DemError> {
    let (bits, formats) = (tags.wholes(input, 258)?, tags.wholes(input, 339)?);
    let is_mixed = |values: &[u64]| values.iter().any(|value| *value != values[0]);
    let (bit, format) = (bits.first().copied().unwrap_or(1), formats.first().copied().unwrap_or(1));
    let samples = match (bit, format) {
        _ if is_mixed(&bits) || is_mixed(&formats) => None,
        // 4 is "undefined", which GDAL takes as unsigned.
        (8, 1 | 4) => Some(SampleType::U8),
        (8, 2) => Some(SampleType::I8),
        (16, 1 | 4) => Some(SampleType::U16),
        (16, 2) => Some(SampleType::I16),
        (16, 3) => Some(SampleType::F16),
        (32, 1 | 4) => Some(SampleType::U32),
        (32, 2) => Some(SampleType::I32),
        (32, 3) => Some(SampleType::F32),
        (64, 1 | 4) => Some(SampleType::U64),
        (64, 2) => Some(SampleType::I64),
        (64, 3) => Some(SampleType::F64),
        _ => None,
    };
    samples.ok_or_else(|| {
        let kind = match format {
            _ if is_mixed(&bits) || is_mixed(&formats) => "mixed",
            1 | 4 => "unsigned",
            2 => "signed",
            3 => "float",
            _ => "complex",
        };
        let remedy = format!("gdal_translate -ot Float32 {} OUT.tif", input.shown);
        input.refuse(format!("a TIFF of {bit}-bit {kind} samples; expected 8 to 64 bits, all bands alike: {remedy}"))
    })
}
