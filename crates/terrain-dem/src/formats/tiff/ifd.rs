//! The directory of a TIFF: its tags (TIFF 6.0, section 2; BigTIFF).

use crate::DemError;
use crate::input::Input;
use crate::samples::ByteOrder;

/// More entries than any program writes.
const MAX_ENTRIES: u64 = 4096;

/// The longest text of a tag that is read, in bytes.
const MAX_TEXT: u64 = 1 << 20;

/// The tags of a directory. The first one is the picture itself, those that follow are overviews and masks.
pub struct Tags {
    pub order: ByteOrder,
    pub is_big: bool,
    entries: Vec<Entry>,
    /// Where the next directory is; 0 after the last one.
    pub next: u64,
}

#[derive(Clone, Copy)]
struct Entry {
    tag: u16,
    kind: u16,
    count: u64,
    /// Where its values are in the file.
    offset: u64,
}

impl Entry {
    fn bytes_each(self) -> u64 {
        match self.kind {
            1 | 2 | 6 | 7 => 1,
            3 | 8 => 2,
            4 | 9 | 11 | 13 => 4,
            _ => 8,
        }
    }
}

pub fn is_one(input: &Input) -> bool {
    matches!(input.start.get(..4), Some(b"II\x2a\0" | b"MM\0\x2a" | b"II\x2b\0" | b"MM\0\x2b"))
}

impl Tags {
    pub fn read(input: &mut Input) -> Result<Self, DemError> {
        let order = if input.start.starts_with(b"II") { ByteOrder::Little } else { ByteOrder::Big };
        let mut tags = Self { order, is_big: input.start[2..4].contains(&0x2b), entries: Vec::new(), next: 0 };
        let first = if tags.is_big { input.bytes_at(8, 8)? } else { input.bytes_at(4, 4)? };
        let at = tags.unsigned(&first);
        tags.read_directory(input, at)?;
        Ok(tags)
    }

    /// Those of the directory at a place that another one names; `None` for none.
    pub fn following(&self, input: &mut Input, at: u64) -> Result<Option<Self>, DemError> {
        if at == 0 {
            return Ok(None);
        }
        let mut tags = Self { order: self.order, is_big: self.is_big, entries: Vec::new(), next: 0 };
        tags.read_directory(input, at)?;
        Ok(Some(tags))
    }

    fn read_directory(&mut self, input: &mut Input, at: u64) -> Result<(), DemError> {
        let (count_bytes, entry_bytes) = if self.is_big { (8, 20) } else { (2, 12) };
        let count_field = input.bytes_at(at, count_bytes)?;
        let count = self.unsigned(&count_field);
        if count > MAX_ENTRIES {
            return Err(input.refuse(format!("a TIFF directory of {count} tags; expected at most {MAX_ENTRIES}")));
        }
        let bytes = input.bytes_at(at + count_bytes, count * entry_bytes)?;
        for (index, entry) in bytes.chunks_exact(entry_bytes as usize).enumerate() {
            self.entries.push(self.entry(entry, at + count_bytes + index as u64 * entry_bytes));
        }
        // Files that end without it have no more directories.
        let (after, length) = (at + count_bytes + count * entry_bytes, if self.is_big { 8 } else { 4 });
        if input.holds(after, length) {
            let next = input.bytes_at(after, length)?;
            self.next = self.unsigned(&next);
        }
        Ok(())
    }

    /// `at` is the entry's own place: short values stand in it.
    fn entry(&self, bytes: &[u8], at: u64) -> Entry {
        let (count, value) = if self.is_big { bytes[4..].split_at(8) } else { bytes[4..].split_at(4) };
        let count = self.unsigned(count);
        let mut entry = Entry { tag: self.u16(bytes), kind: self.u16(&bytes[2..]), count, offset: 0 };
        let is_inline = count.saturating_mul(entry.bytes_each()) <= value.len() as u64;
        entry.offset = if is_inline { at + (bytes.len() - value.len()) as u64 } else { self.unsigned(value) };
        entry
    }

    fn u16(&self, bytes: &[u8]) -> u16 {
        self.unsigned(&bytes[..2]) as u16
    }

    /// A number of all the bytes given.
    fn unsigned(&self, bytes: &[u8]) -> u64 {
        let add = |sum: u64, byte: &u8| sum << 8 | *byte as u64;
        match self.order {
            ByteOrder::Big => bytes.iter().fold(0, add),
            ByteOrder::Little => bytes.iter().rev().fold(0, add),
        }
    }

    fn find(&self, tag: u16) -> Option<Entry> {
        self.entries.iter().find(|entry| entry.tag == tag).copied()
    }

    /// How many values a tag has, without reading them.
    pub fn count(&self, tag: u16) -> Option<u64> {
        self.find(tag).map(|entry| entry.count)
    }

    /// All values of a tag of whole numbers; none without the tag, or if it is of another kind.
    pub fn wholes(&self, input: &mut Input, tag: u16) -> Result<Vec<u64>, DemError> {
        let Some(entry) = self.find(tag).filter(|entry| matches!(entry.kind, 1 | 3 | 4 | 7 | 13 | 16 | 18)) else {
            return Ok(Vec::new());
        };
        let bytes = self.bytes(input, entry)?;
        Ok(bytes.chunks_exact(entry.bytes_each() as usize).map(|value| self.unsigned(value)).collect())
    }

    /// The first value of a tag, or what TIFF 6.0 says without it.
    pub fn whole(&self, input: &mut Input, tag: u16, default: u64) -> Result<u64, DemError> {
        Ok(self.wholes(input, tag)?.first().copied().unwrap_or(default))
    }

    /// All values of a tag of doubles.
    pub fn doubles(&self, input: &mut Input, tag: u16) -> Result<Vec<f64>, DemError> {
        let Some(entry) = self.find(tag).filter(|entry| entry.kind == 12) else { return Ok(Vec::new()) };
        let bytes = self.bytes(input, entry)?;
        Ok(bytes.chunks_exact(8).map(|value| f64::from_bits(self.unsigned(value))).collect())
    }

    /// A text up to its first zero byte.
    pub fn text(&self, input: &mut Input, tag: u16) -> Result<Option<String>, DemError> {
        let Some(mut entry) = self.find(tag).filter(|entry| entry.kind == 2) else { return Ok(None) };
        entry.count = entry.count.min(MAX_TEXT);
        let bytes = self.bytes(input, entry)?;
        let end = bytes.iter().position(|byte| *byte == 0).unwrap_or(bytes.len());
        Ok(Some(String::from_utf8_lossy(&bytes[..end]).into_owned()))
    }

    fn bytes(&self, input: &mut Input, entry: Entry) -> Result<Vec<u8>, DemError> {
        input.bytes_at(entry.offset, entry.count.saturating_mul(entry.bytes_each()))
    }
}
