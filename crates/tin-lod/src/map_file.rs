//! Threshold maps as bytes, to be kept in a file: they take longer to compute than to read.
//!
//! | bytes | little-endian |
//! |---|---|
//! | 8 | `tin-maps` |
//! | 4 | version: 1 |
//! | 4 x 4 | columns and rows of the DEM, intervals of a patch, patches across the largest group |
//! | 4 | CRC-32 of the DEM's heights (f32, row by row) |
//! | 4 | CRC-32 of the codes |
//! | rest | codes: for each size of node, patches first, those of all edges, then those of all interiors |
//!
//! Spacing, tolerance and view are not in it: thresholds are vertical, in metres.

use std::io::{self, Write};

use terrain_core::Heightmap;

use crate::node_maps::NodeMaps;
use crate::nodes::Nodes;
use crate::threshold_map::ThresholdMap;

const MAGIC: [u8; 8] = *b"tin-maps";

/// Rises whenever the same DEM gets other codes, or the layout changes.
const VERSION: u32 = 1;

const HEADER: usize = MAGIC.len() + 7 * size_of::<u32>();

/// Why bytes are not the maps that are wanted: they must be computed anew.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum MapFileError {
    /// Something else altogether.
    #[error("no threshold maps of version {VERSION}")]
    NoMaps,
    /// Maps of another DEM, or of patches or groups of other sizes.
    #[error("threshold maps of another DEM or of other patches")]
    Stale,
    /// Cut short, or changed.
    #[error("damaged threshold maps")]
    Damaged,
}

impl NodeMaps {
    /// Writes the maps, which must be those of this DEM: whoever reads them trusts it.
    pub fn write(&self, heightmap: &Heightmap, out: &mut dyn Write) -> io::Result<()> {
        let mut codes = crc32fast::Hasher::new();
        self.codes().for_each(|bytes| codes.update(bytes));
        out.write_all(&MAGIC)?;
        for field in key(heightmap, self.nodes()).into_iter().chain([codes.finalize()]) {
            out.write_all(&field.to_le_bytes())?;
        }
        self.codes().try_for_each(|bytes| out.write_all(bytes))
    }

    /// Takes maps of a DEM and its nodes out of the bytes of a file.
    pub fn read(bytes: &[u8], heightmap: &Heightmap, nodes: Nodes) -> Result<Self, MapFileError> {
        let (header, mut codes) = bytes.split_at_checked(HEADER).ok_or(MapFileError::NoMaps)?;
        let (magic, fields) = header.split_at(MAGIC.len());
        let fields: Vec<u32> = fields.as_chunks().0.iter().map(|field| u32::from_le_bytes(*field)).collect();
        let (found, checksum) = (&fields[..6], fields[6]);
        let expected = key(heightmap, &nodes);
        if magic != MAGIC || found[0] != VERSION {
            return Err(MapFileError::NoMaps);
        }
        if found != expected {
            return Err(MapFileError::Stale);
        }
        if crc32fast::hash(codes) != checksum {
            return Err(MapFileError::Damaged);
        }
        let maps: Option<Vec<ThresholdMap>> =
            nodes.grids().map(|grid| ThresholdMap::take_from(&mut codes, grid)).collect();
        maps.filter(|_| codes.is_empty()).map(|maps| Self::new(nodes, maps)).ok_or(MapFileError::Damaged)
    }
}

/// What the codes depend on.
fn key(heightmap: &Heightmap, nodes: &Nodes) -> [u32; 6] {
    let mut heights = crc32fast::Hasher::new();
    // As many bytes at a time as stay in the cache.
    for some_m in heightmap.heights_m().chunks(4096) {
        let bytes: Vec<u8> = some_m.iter().flat_map(|height_m| height_m.to_le_bytes()).collect();
        heights.update(&bytes);
    }
    [VERSION, heightmap.columns(), heightmap.rows(), nodes.patches().side(), nodes.group(), heights.finalize()]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dem(bump_m: f32) -> Heightmap {
        let height_m = |i: u32| (i * 37 % 101) as f32 + if i == 900 { bump_m } else { 0.0 };
        Heightmap::new(50, 41, [10.0; 2], (0..50 * 41).map(height_m).collect()).unwrap()
    }

    fn bytes_of(dem: &Heightmap, patch: u32, group: u32) -> (NodeMaps, Vec<u8>) {
        let maps = NodeMaps::build(dem, Nodes::new(dem, patch, group));
        let mut bytes = Vec::new();
        maps.write(dem, &mut bytes).unwrap();
        (maps, bytes)
    }

    #[test]
    fn maps_come_back_as_they_were() {
        for (patch, group) in [(8, 1), (8, 4), (16, 2), (32, 2), (64, 1)] {
            let (maps, bytes) = bytes_of(&dem(0.0), patch, group);
            let read = NodeMaps::read(&bytes, &dem(0.0), Nodes::new(&dem(0.0), patch, group)).unwrap();
            assert!(read.codes().eq(maps.codes()));
        }
    }

    /// Kept files of another version of this crate must not look right: if this fails, raise `VERSION`.
    #[test]
    fn the_codes_of_this_version_are_pinned() {
        let height_m = |i: u32| 40.0 * ((i % 97) as f32 * (i / 97) as f32 % 23.0) + (i * 37 % 101) as f32;
        let dem = Heightmap::new(97, 70, [10.0; 2], (0..97 * 70).map(height_m).collect()).unwrap();
        let mut codes = crc32fast::Hasher::new();
        bytes_of(&dem, 16, 4).0.codes().for_each(|bytes| codes.update(bytes));
        assert_eq!((VERSION, codes.finalize()), (1, 963_325_614));
    }

    #[test]
    fn what_is_stale_or_damaged_is_refused() {
        let (dem, other) = (dem(0.0), dem(0.5));
        let bytes = bytes_of(&dem, 16, 2).1;
        let read = |bytes: &[u8], dem, patch, group| NodeMaps::read(bytes, dem, Nodes::new(dem, patch, group)).err();
        assert_eq!(read(&bytes, &dem, 16, 2), None);
        assert_eq!(read(&bytes, &other, 16, 2), Some(MapFileError::Stale));
        assert_eq!(read(&bytes, &dem, 16, 1), Some(MapFileError::Stale));
        assert_eq!(read(&bytes, &dem, 8, 4), Some(MapFileError::Stale));
        assert_eq!(read(b"tin-maps", &dem, 16, 2), Some(MapFileError::NoMaps));
        for at in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[at] ^= 1;
            assert!(read(&changed, &dem, 16, 2).is_some(), "byte {at} changed");
            assert!(read(&bytes[..at], &dem, 16, 2).is_some(), "cut at byte {at}");
        }
        assert_eq!(read(&[&bytes[..], &[0]].concat(), &dem, 16, 2), Some(MapFileError::Damaged));
    }
}
