//! Tiles joined by their places: rims that two of them share are compared, and what none of them covers is a void.
//!
//! ```text
//!     N45W123 | N45W122      one grid over all of them; a tile begins at a whole sample of it
//!     --------+--------
//!     N44W123 |  (gap)
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use crate::georef::{Place, Spacing};
use crate::input::Input;
use crate::load::{Opened, finish, open};
use crate::raster::{Decoded, Facts, Meaning};
use crate::sidecar::Sidecar;
use crate::tiles::Tiles;
use crate::{Dem, DemError, ReadOptions};

/// How far a tile may lie off the grid of the first one, in samples: files round their places.
const MOST_OFF: f64 = 0.05;

/// Reads each tile twice: first all headers, so that nothing is allocated for tiles that do not fit together.
pub fn load(spec: &str, tiles: &Tiles, options: &ReadOptions) -> Result<Dem, DemError> {
    let headers = tiles.paths.iter().map(|path| Header::read(path, options)).collect::<Result<Vec<_>, _>>()?;
    let refuse = |reason: String| DemError::input(spec, reason);
    let first = &headers[0];
    let frame = Frame::around(&headers)?;
    let facts = frame.facts(&headers);
    facts.check_size(options.limit()).map_err(refuse)?;

    let mut joined = Joined::new(&frame);
    let mut rims = Vec::new();
    for (path, header) in tiles.paths.iter().zip(&headers) {
        let place = frame.rectangle(header).map_err(|reason| DemError::input(&header.shown, reason))?;
        let rim = joined.add(header.decode(path, place, options)?, place);
        rims.extend(rim.warning().map(|said| format!("{}: {said}", header.shown)));
    }
    let mut facts = Facts { warnings: warnings(&headers), ..facts };
    facts.warnings.extend(rims);
    let decoded = joined.finish(frame.gaps(&headers));
    let opened = Opened::joined(facts, first.meaning, &first.sidecar, options).map_err(refuse)?;
    finish(tiles.name.clone(), opened, decoded, first.sidecar.clone(), options).map_err(|unread| unread.of(spec))
}

/// A tile of which the header has been read.
struct Header {
    shown: String,
    sidecar: Sidecar,
    facts: Facts,
    meaning: Meaning,
    place: Place,
}

impl Header {
    fn read(path: &Path, options: &ReadOptions) -> Result<Self, DemError> {
        let (sidecar, opened) = open_tile(path, options)?;
        let (shown, facts) = (path.display().to_string(), opened.facts);
        let Some(place) = facts.place else {
            let reason = "nothing says where it lies; expected tiles with a place: GeoTIFF, .hgt by its name, .asc, .bil, \
                          .flt, DTED, or any with one in a sidecar";
            return Err(DemError::input(&shown, reason.to_owned()));
        };
        Ok(Self { shown, sidecar, facts, meaning: opened.meaning, place })
    }

    /// Opens the tile again and reads its samples.
    fn decode(&self, path: &Path, place: Rectangle, options: &ReadOptions) -> Result<Decoded, DemError> {
        let (_, mut opened) = open_tile(path, options)?;
        if [opened.facts.columns, opened.facts.rows] != place.size {
            return Err(DemError::input(&self.shown, "changed while it was read; expected the same file".to_owned()));
        }
        opened.decode().map_err(|unread| unread.of(&self.shown))
    }
}

fn open_tile(path: &Path, options: &ReadOptions) -> Result<(Sidecar, Opened), DemError> {
    let sidecar = Sidecar::read(&path.with_extension("toml"))?;
    // A crop is one of the whole.
    let opened = open(Input::open(path)?, &sidecar, &ReadOptions { crop: None, ..*options });
    let opened = opened.map_err(|unread| unread.of(&path.display().to_string()))?;
    Ok((sidecar, opened))
}

/// Where a tile's samples go.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rectangle {
    /// Column and row of its first sample.
    first: [u32; 2],
    size: [u32; 2],
}

/// The grid over all tiles.
#[derive(Debug)]
struct Frame {
    place: Place,
    size: [u32; 2],
}

impl Frame {
    /// Tiles of one coordinate system and one spacing.
    fn around(headers: &[Header]) -> Result<Self, DemError> {
        let first = &headers[0];
        for header in headers {
            check_alike(first, header).map_err(|reason| DemError::input(&header.shown, reason))?;
        }
        let step = first.place.step;
        let west = headers.iter().map(|header| header.place.west).fold(f64::INFINITY, f64::min);
        let north = headers.iter().map(|header| header.place.north).fold(f64::NEG_INFINITY, f64::max);
        let mut frame = Self { place: Place { west, north, step }, size: [0; 2] };
        for header in headers {
            let place = frame.rectangle(header).map_err(|reason| DemError::input(&header.shown, reason))?;
            for axis in [0, 1] {
                frame.size[axis] = frame.size[axis].max(place.first[axis].saturating_add(place.size[axis]));
            }
        }
        Ok(frame)
    }

    fn rectangle(&self, header: &Header) -> Result<Rectangle, String> {
        let ([x, z], place) = (self.place.step, header.place);
        let exact = [(place.west - self.place.west) / x, (self.place.north - place.north) / z];
        let first = exact.map(f64::round);
        let off = [0, 1].map(|axis| (exact[axis] - first[axis]).abs());
        if off.iter().any(|off| *off > MOST_OFF) {
            return Err(format!(
                "lies {:.2} x {:.2} samples off the grid of the other tiles; expected one grid: \
                 gdalbuildvrt -tap -tr {x} {z} OUT.vrt TILES, then gdal_translate OUT.vrt OUT.tif",
                off[0], off[1]
            ));
        }
        // Sums beyond any heightmap saturate, and are refused by their size.
        Ok(Rectangle { first: first.map(|sample| sample as u32), size: [header.facts.columns, header.facts.rows] })
    }

    /// What is said of the whole: what the first tile says, in another place.
    fn facts(&self, headers: &[Header]) -> Facts {
        let ([columns, rows], first) = (self.size, &headers[0].facts);
        let middle = self.place.north - rows.saturating_sub(1) as f64 * self.place.step[1] / 2.0;
        let spacing = first.spacing.map(|spacing| match spacing {
            Spacing::Degrees { degrees, .. } => Spacing::Degrees { degrees, latitude: middle },
            metres => metres,
        });
        let count = headers.len();
        let is_one_format = headers.iter().all(|header| header.facts.format == first.format);
        let tiles = if count == 1 { "a tile" } else { "tiles" };
        let format = match is_one_format {
            true => format!("{count} {tiles}: {}", first.format),
            false => format!("{count} {tiles}, the first one: {}", first.format),
        };
        Facts { format, columns, rows, spacing, place: Some(self.place), south_up: false, ..first.clone() }
    }

    /// Samples that no tile covers.
    fn gaps(&self, headers: &[Header]) -> u64 {
        let rectangles = || headers.iter().filter_map(|header| self.rectangle(header).ok());
        let mut cuts: Vec<u32> = rectangles().flat_map(|r| [r.first[1], r.first[1] + r.size[1]]).collect();
        cuts.extend([0, self.size[1]]);
        cuts.sort_unstable();
        let band = |from: u32, to: u32| {
            let within = rectangles().filter(|r| r.first[1] <= from && to <= r.first[1] + r.size[1]);
            let mut spans: Vec<[u32; 2]> = within.map(|r| [r.first[0], r.first[0] + r.size[0]]).collect();
            spans.sort_unstable();
            let (mut end, mut gaps) = (0, 0);
            for [first, last] in spans.into_iter().chain([[self.size[0]; 2]]) {
                gaps += u64::from(first.saturating_sub(end));
                end = end.max(last);
            }
            gaps * u64::from(to - from)
        };
        cuts.windows(2).map(|cut| band(cut[0], cut[1])).sum()
    }
}

/// Whether a tile can lie in one grid with the first one.
fn check_alike(first: &Header, tile: &Header) -> Result<(), String> {
    let (one, other) = (first.place.step, tile.place.step);
    let sides = [first, tile].map(|header| header.facts.columns.max(header.facts.rows));
    let longest = sides[0].max(sides[1]) as f64;
    if [0, 1].iter().any(|&axis| (one[axis] - other[axis]).abs() * longest > MOST_OFF * one[axis]) {
        let ([x, z], [other_x, other_z]) = (one, other);
        return Err(format!(
            "steps of {other_x} x {other_z}, and {} of {x} x {z}; expected one: gdalwarp -tr {x} {z} IN OUT.tif",
            first.shown
        ));
    }
    let is_degrees = |header: &Header| matches!(header.facts.spacing, Some(Spacing::Degrees { .. }));
    if is_degrees(first) != is_degrees(tile) || !may_be_one(first.facts.crs.as_deref(), tile.facts.crs.as_deref()) {
        let [one, other] = [first, tile].map(|header| header.facts.crs.as_deref().unwrap_or("of no known system"));
        return Err(format!(
            "{other}, and {} is {one}; expected one coordinate system: gdalwarp -t_srs ONE IN OUT.tif",
            first.shown
        ));
    }
    Ok(())
}

/// Whether two coordinate systems can be the same: by number, `EPSG:4326 (by the name)`, or by name. One has a number, the
/// other a name, or nothing: nobody can tell.
fn may_be_one(one: Option<&str>, other: Option<&str>) -> bool {
    let number = |crs: &str| crs.starts_with("EPSG:").then(|| crs.split(' ').next().unwrap_or(crs).to_owned());
    let (Some(one), Some(other)) = (one, other) else { return true };
    match (number(one), number(other)) {
        (Some(one), Some(other)) => one == other,
        (None, None) => one == other,
        _ => true,
    }
}

/// What the tiles' headers warn of, each text once, with the first tile that says it.
fn warnings(headers: &[Header]) -> Vec<String> {
    let mut said: BTreeMap<&str, (&str, u32)> = BTreeMap::new();
    for header in headers {
        for warning in &header.facts.warnings {
            said.entry(warning).and_modify(|(_, count)| *count += 1).or_insert((&header.shown, 1));
        }
    }
    let line = |(warning, (tile, count)): (&str, (&str, u32))| match count {
        1 => format!("{tile}: {warning}"),
        _ => format!("{tile} and {} more: {warning}", count - 1),
    };
    said.into_iter().map(line).collect()
}

/// The heights of the tiles so far; NaN at voids and gaps.
struct Joined {
    columns: u32,
    heights_m: Vec<f32>,
    absurd: u64,
    undeclared: u64,
    notes: Vec<String>,
}

/// The samples that a tile has in common with those before it.
#[derive(Debug, Default, PartialEq)]
struct Rim {
    shared: u64,
    differ: u64,
    most_m: f32,
}

impl Rim {
    fn warning(&self) -> Option<String> {
        let Self { shared, differ, most_m } = self;
        let differs = *differ > 0;
        differs.then(|| {
            format!("{differ} of {shared} samples that it shares with tiles before it differ, by at most {most_m} m; theirs are kept")
        })
    }
}

impl Joined {
    fn new(frame: &Frame) -> Self {
        let [columns, rows] = frame.size;
        let heights_m = vec![f32::NAN; columns as usize * rows as usize];
        Self { columns, heights_m, absurd: 0, undeclared: 0, notes: Vec::new() }
    }

    /// A height fills a void or a gap, and is compared with a height that is there.
    fn add(&mut self, tile: Decoded, place: Rectangle) -> Rim {
        let ([column, row], [columns, _]) = (place.first, place.size);
        let mut rim = Rim::default();
        for (z, row_m) in tile.heights_m.chunks_exact(columns as usize).enumerate() {
            let start = (row as usize + z) * self.columns as usize + column as usize;
            for (target, &height_m) in self.heights_m[start..start + columns as usize].iter_mut().zip(row_m) {
                if target.is_nan() {
                    *target = height_m;
                } else if !height_m.is_nan() {
                    rim.shared += 1;
                    rim.differ += u64::from(*target != height_m);
                    rim.most_m = rim.most_m.max((*target - height_m).abs());
                }
            }
        }
        self.absurd += tile.absurd;
        self.undeclared += tile.undeclared;
        self.notes.extend(tile.notes);
        rim
    }

    fn finish(self, gaps: u64) -> Decoded {
        let Self { heights_m, absurd, undeclared, notes, .. } = self;
        let whole = Decoded::of(heights_m);
        // Another tile may have had heights for some.
        let voids = whole.heights_m.len() as u64 - whole.found - gaps;
        Decoded { absurd: absurd.min(voids), undeclared: undeclared.min(voids), gaps, notes, ..whole }
    }
}
