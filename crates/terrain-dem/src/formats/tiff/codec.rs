//! What a TIFF's chunks are compressed with.
//!
//! Own readers around `flate2`, `weezl` and `ruzstd` rather than the crate `tiff`, for four reasons: `tiff` 0.11 fails on
//! tiled LZW files that GDAL writes (its issue 395), cannot read files with tiles left out, turns heights upside down
//! where white is zero, and reads on beyond the end of an uncompressed chunk.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};

use flate2::bufread::ZlibDecoder;
use ruzstd::decoding::StreamingDecoder;
use weezl::{BitOrder, LzwStatus, decode};

const EXPECTED: &str = "expected none, LZW, deflate, PackBits or ZSTD";

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compression {
    None,
    Lzw,
    Deflate,
    PackBits,
    Zstd,
}

impl Compression {
    /// By the number in the tag; the name of what we do not read.
    pub fn of(tag: u64) -> Result<Self, String> {
        let other = match tag {
            1 => return Ok(Self::None),
            5 => return Ok(Self::Lzw),
            8 | 32946 => return Ok(Self::Deflate),
            32773 => return Ok(Self::PackBits),
            50000 => return Ok(Self::Zstd),
            2..=4 => "fax",
            6 | 7 => "JPEG",
            34712 => "JPEG 2000",
            34887 => "LERC",
            34925 => "LZMA",
            50001 => "WebP",
            50002 => "JPEG XL",
            _ => return Err(format!("unknown compression {tag}; {EXPECTED}")),
        };
        Err(format!("{other} compression; {EXPECTED}"))
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::None => "uncompressed",
            Self::Lzw => "LZW",
            Self::Deflate => "deflate",
            Self::PackBits => "PackBits",
            Self::Zstd => "ZSTD",
        }
    }

    /// The most bytes that one byte can stand for, generously.
    pub fn most_a_byte(self) -> u64 {
        match self {
            Self::None => 1,
            // 128 bytes from 2.
            Self::PackBits => 64,
            // 258 bytes from 2 bits.
            Self::Deflate => 1040,
            // Up to 4096 bytes from 12 bits.
            Self::Lzw => 2731,
            // A block of 128 KiB from 4 bytes.
            Self::Zstd => 1 << 15,
        }
    }

    /// Unpacks what `packed` holds, which ends with the chunk.
    pub fn reader<'a>(self, packed: impl BufRead + 'a) -> io::Result<Box<dyn Read + 'a>> {
        Ok(match self {
            Self::None => Box::new(packed),
            Self::Lzw => Box::new(Lzw::new(packed)),
            Self::Deflate => Box::new(ZlibDecoder::new(packed)),
            Self::PackBits => Box::new(PackBits { packed, left: 0, repeated: None }),
            // Only a frame's window is held, which `StreamingDecoder` refuses beyond 100 MB.
            Self::Zstd => Box::new(BufReader::new(StreamingDecoder::new(packed).map_err(io::Error::other)?)),
        })
    }
}

/// LZW as TIFF has it (TIFF 6.0, section 13). Ends where the samples do, whether or not an end code follows.
struct Lzw<R> {
    packed: R,
    decoder: decode::Decoder,
}

impl<R: BufRead> Lzw<R> {
    fn new(packed: R) -> Self {
        Self { packed, decoder: decode::Decoder::with_tiff_size_switch(BitOrder::Msb, 8) }
    }
}

impl<R: BufRead> Read for Lzw<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        while !out.is_empty() {
            let packed = self.packed.fill_buf()?;
            let is_end = packed.is_empty();
            let step = self.decoder.decode_bytes(packed, out);
            self.packed.consume(step.consumed_in);
            let status = step.status.map_err(|e| io::Error::new(ErrorKind::InvalidData, e))?;
            if step.consumed_out > 0 || is_end {
                return Ok(step.consumed_out);
            }
            match status {
                LzwStatus::Ok => {}
                LzwStatus::Done => return Ok(0),
                LzwStatus::NoProgress => {
                    return Err(io::Error::new(ErrorKind::InvalidData, "LZW codes that lead nowhere"));
                }
            }
        }
        Ok(0)
    }
}

/// PackBits (TIFF 6.0, section 9).
struct PackBits<R> {
    packed: R,
    /// Bytes left of the present run.
    left: usize,
    /// The byte that the run repeats, or `None` where it is literal.
    repeated: Option<u8>,
}

impl<R: BufRead> PackBits<R> {
    /// The next byte, if there is one.
    fn byte(&mut self) -> io::Result<Option<u8>> {
        let byte = self.packed.fill_buf()?.first().copied();
        self.packed.consume(byte.is_some() as usize);
        Ok(byte)
    }

    /// Begins the next run; false at the end.
    fn next_run(&mut self) -> io::Result<bool> {
        while self.left == 0 {
            match self.byte()?.map(|byte| byte as i8) {
                None => return Ok(false),
                Some(-128) => {}
                Some(header @ 0..) => (self.left, self.repeated) = (header as usize + 1, None),
                Some(header) => match self.byte()? {
                    Some(byte) => (self.left, self.repeated) = (1 + header.unsigned_abs() as usize, Some(byte)),
                    None => return Ok(false),
                },
            }
        }
        Ok(true)
    }
}

impl<R: BufRead> Read for PackBits<R> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        if out.is_empty() || !self.next_run()? {
            return Ok(0);
        }
        let length = self.left.min(out.len());
        let done = match self.repeated {
            Some(byte) => {
                out[..length].fill(byte);
                length
            }
            None => self.packed.read(&mut out[..length])?,
        };
        // A literal run that ends too soon ends the chunk.
        self.left = if done == 0 { 0 } else { self.left - done };
        Ok(done)
    }
}
