use std::io;
use std::sync::Arc;

use terrain_core::{HeightFormat, Heightmap, Sample, SplitMix64, VoidMask};

use super::*;
use crate::errors::{ErrorTable, record_length};
use crate::grid::{Grid, Square};

const SHAPES: [(u32, u32); 5] = [(2, 2), (2, 5), (3, 3), (3, 4), (4, 3)];

fn options(k: u32, layers: u32) -> Options {
    Options { k, layers, ..Options::default() }
}

/// Whole metres or not, from a seed.
fn rough(columns: u32, rows: u32, seed: u64, is_whole: bool) -> Heightmap {
    let mut random = SplitMix64::new(seed);
    let height_m = |_| random.range(-100.0, 3000.0) as f32;
    let mut heights_m: Vec<f32> = (0..columns * rows).map(height_m).collect();
    if is_whole {
        heights_m.iter_mut().for_each(|height_m| *height_m = height_m.round());
    }
    // Whole metres have no negative zero.
    heights_m.iter_mut().for_each(|height_m| *height_m += 0.0);
    Heightmap::new(columns, rows, [30.0, 20.0], heights_m).unwrap()
}

/// One sample of so many has no height.
fn with_voids(heightmap: Heightmap, seed: u64, one_in: u64) -> Heightmap {
    let mut random = SplitMix64::new(seed);
    let flags: Vec<bool> = heightmap.heights_m().iter().map(|_| random.below(one_in) == 0).collect();
    let mask = VoidMask::of_flags(heightmap.columns(), &flags);
    heightmap.with_voids(Arc::new(mask)).unwrap()
}

fn open(bytes: &[u8]) -> Result<(CellFile, Resident), CellsError> {
    CellFile::open(Arc::new(bytes.to_vec()))
}

/// DEMs of awkward sizes, smaller than a cell among them, with each shape of the hierarchy.
fn for_each_dem(mut check: impl FnMut(&Heightmap, u32, u32, &str)) {
    for (k, layers) in SHAPES {
        for (columns, rows, is_whole) in [(100, 70, true), (82, 82, false), (2, 90, true), (19, 3, false)] {
            let seed = (columns * rows * k + layers) as u64;
            let what = format!("{columns} x {rows}, k {k}, {layers} layers, seed {seed}");
            check(&rough(columns, rows, seed, is_whole), k, layers, &what);
        }
    }
}

#[test]
fn heights_come_back_bit_by_bit() {
    let mut formats = [0; 2];
    for_each_dem(|heightmap, k, layers, what| {
        let (file, _) = open(&cut(heightmap, &options(k, layers))).unwrap();
        formats[matches!(file.header().format, HeightFormat::F32) as usize] += 1;
        let rows = 0..file.header().cells()[1];
        let found: Vec<f32> = rows.flat_map(|row| file.heights_m(row).unwrap()).collect();
        let bits = |heights_m: &[f32]| heights_m.iter().map(|height_m| height_m.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&found), bits(heightmap.heights_m()), "{what}");
    });
    assert_eq!(formats, [2 * SHAPES.len(); 2], "whole metres in 16 bits, others in 32");
}

#[test]
fn cells_hold_the_samples_the_ranges_and_the_errors_of_the_whole_dem() {
    for_each_dem(|heightmap, k, layers, what| {
        let options = options(k, layers);
        let (grid, record) = (Grid::new(heightmap, &options), record_length(k));
        let table = ErrorTable::new(heightmap, &grid);
        let (file, _) = open(&cut(heightmap, &options)).unwrap();
        let header = file.header();
        for cell in grid.squares(grid.top()) {
            for level in 0..header.streamed {
                let found = file.read(level, [cell.column, cell.row]).unwrap();
                let side = k.pow(layers - 1 - level);
                for (i, range_m) in found.ranges_m.iter().enumerate() {
                    let [column, row] = [cell.column * side + i as u32 % side, cell.row * side + i as u32 / side];
                    let square = Square { level, column, row };
                    let of_the_grid = |square| (range_of(&grid, square), errors_of(&grid, &table, square, record));
                    let beyond = ([0.0; 2], vec![0; if level > 0 { record } else { 0 }]);
                    let expected = if grid.exists(square) { of_the_grid(square) } else { beyond };
                    assert_eq!(*range_m, expected.0, "{what}, {square:?}");
                    let length = expected.1.len();
                    assert_eq!(found.errors[i * length..][..length], expected.1, "{what}, {square:?}");
                }
                let (step, along) = (k.pow(level), k.pow(layers - level) + 1);
                let heights_m = codes::decode(header.format, &found.heights);
                for (i, height_m) in heights_m.iter().take(along.pow(2) as usize).enumerate() {
                    let at = [(cell.column, i as u32 % along), (cell.row, i as u32 / along)];
                    let [column, row] = at.map(|(cell, at)| cell * header.cell_side() + at * step);
                    let at = Sample { column: column.min(header.samples[0] - 1), row: row.min(header.samples[1] - 1) };
                    assert_eq!(*height_m, heightmap.height_m(at), "{what}, level {level}, {cell:?}, {at:?}");
                }
            }
        }
    });
}

fn range_of(grid: &Grid, square: Square) -> [f32; 2] {
    grid.heights_m(square.level, grid.index(square)).map(|metres| metres as f32)
}

fn errors_of(grid: &Grid, table: &ErrorTable, square: Square, record: usize) -> Vec<u8> {
    if square.level == 0 {
        return Vec::new();
    }
    let at = square.row * grid.layer(square).size[0] + square.column;
    table.records(grid, square.level)[at as usize * record..][..record].to_vec()
}

#[test]
fn what_stays_resident_is_that_of_the_whole_dem() {
    for_each_dem(|heightmap, k, layers, what| {
        let grid = Grid::new(heightmap, &options(k, layers));
        let table = ErrorTable::new(heightmap, &grid);
        let (file, resident) = open(&cut(heightmap, &options(k, layers))).unwrap();
        let header = file.header();
        for (i, level) in (header.streamed..layers).enumerate() {
            assert_eq!(resident.ranges_m[i], grid.ranges_m(level), "{what}, level {level}");
            assert_eq!(resident.errors[i], table.records(&grid, level), "{what}, level {level}");
        }
        let [columns, rows] = header.coarse_size();
        let step = header.coarse_step();
        let code = header.format.bytes() as usize;
        assert_eq!(resident.heights.len(), (columns as usize * rows as usize * code).next_multiple_of(4));
        for i in 0..columns * rows {
            let column = (i % columns * step).min(heightmap.columns() - 1);
            let row = (i / columns * step).min(heightmap.rows() - 1);
            let found_m = header.format.decode(&resident.heights[i as usize * code..][..code]);
            assert_eq!(found_m, heightmap.height_m(Sample { column, row }), "{what}, {column}, {row}");
        }
    });
}

#[test]
fn a_file_that_declares_its_steps_is_kept_in_16_bits() {
    let [scale, offset_m] = [0.1, -10.0];
    for first in [0.0, -20_000.0] {
        let height_m = |i: u32| ((first + (i * 37 % 30_011) as f64) * scale + offset_m) as f32;
        let heights_m: Vec<f32> = (0..60 * 50).map(height_m).collect();
        let mut scan = Scan::new([60, 50], [1.0; 2], Some([scale, offset_m]), &options(3, 3)).unwrap();
        heights_m.chunks(60).for_each(|row_m| scan.push(row_m));
        let format = scan.finish().format;
        assert!(matches!(format, HeightFormat::U16 { scale_m, .. } if scale_m == scale), "{format:?}");
        for height_m in heights_m {
            let mut code = Vec::new();
            codes::push(format, height_m, &mut code);
            assert_eq!(format.decode(&code), height_m);
        }
    }
}

#[test]
fn levels_that_are_streamed() {
    let streamed = |k, layers| Scan::new([50, 50], [1.0; 2], None, &options(k, layers)).unwrap().finish().streamed;
    assert_eq!(
        [(3, 5), (3, 3), (3, 2), (2, 6), (4, 4), (8, 2)].map(|(k, layers)| streamed(k, layers)),
        [2, 2, 1, 3, 2, 1]
    );
    let refused = |k, layers| Scan::new([50, 50], [1.0; 2], None, &options(k, layers)).err().unwrap().to_string();
    assert_eq!(refused(3, 1), "1 layer: expected at least 2, a resident one above those that are loaded");
    assert_eq!(refused(1, 3), "k of 1: expected 2 to 16");
    assert_eq!(refused(4, 6), "k of 4 with 6 layers makes cells of 4096 sample intervals: expected at most 1024");
}

/// Reads all that a file has.
fn read_all(bytes: &[u8]) -> Result<(), CellsError> {
    let (file, _) = open(bytes)?;
    file.voids()?;
    let ([columns, rows], streamed) = (file.header().cells(), file.header().streamed);
    let cells = (0..columns * rows).map(|i| [i % columns, i / columns]);
    let mut sheets = cells.flat_map(|cell| (0..streamed).map(move |level| (level, cell)));
    sheets.try_for_each(|(level, cell)| file.read(level, cell).map(drop))
}

#[test]
fn every_changed_byte_and_every_truncation_is_noticed() {
    for is_whole in [true, false] {
        // With whole metres, voids as well.
        let bytes = cut(&with_voids(rough(12, 7, 5, is_whole), 1, if is_whole { 3 } else { u64::MAX }), &options(2, 3));
        assert_eq!(open(&bytes).unwrap().0.header().voids.is_some(), is_whole);
        assert!(read_all(&bytes).is_ok());
        for at in 0..bytes.len() {
            for bit in [0x01, 0x80] {
                let mut changed = bytes.clone();
                changed[at] ^= bit;
                assert!(read_all(&changed).is_err(), "byte {at} changed");
            }
            assert!(open(&bytes[..at]).is_err(), "cut at byte {at}");
        }
        let longer = [&bytes[..], &[0]].concat();
        assert!(matches!(open(&longer), Err(CellsError::Length { .. })));
    }
}

#[test]
fn a_cell_in_the_place_of_another_is_noticed() {
    let bytes = cut(&rough(12, 7, 5, true), &options(2, 2));
    let (file, _) = open(&bytes).unwrap();
    let (from, cell) = (file.resident_bytes() as usize, file.cell_bytes() as usize);
    let mut swapped = bytes.clone();
    swapped[from..from + 2 * cell].rotate_left(cell);
    let (file, _) = open(&swapped).unwrap();
    let expected = "cell (1, 0) in place of cell (0, 0); expected each in its own: copy or cut it again";
    assert_eq!(file.read(0, [0, 0]).unwrap_err().to_string(), expected);
    assert!(matches!(file.read(0, [1, 0]), Err(CellsError::WrongCell { expected: [1, 0], found: [0, 0] })));
    assert!(file.read(0, [2, 0]).is_ok());
}

#[test]
fn a_cell_of_another_dem_is_noticed() {
    let [mut bytes, other] = [5, 6].map(|seed| cut(&rough(12, 7, seed, true), &options(2, 2)));
    let from = open(&bytes).unwrap().0.resident_bytes() as usize;
    bytes[from..].copy_from_slice(&other[from..]);
    assert!(matches!(open(&bytes).unwrap().0.read(0, [0, 0]), Err(CellsError::Damaged { .. })));
}

#[test]
fn refusals_say_what_was_found_and_expected() {
    let bytes = cut(&rough(12, 7, 5, true), &options(2, 2));
    let refused = |bytes: &[u8]| open(bytes).err().unwrap().to_string();
    let changed = |at: usize| {
        let mut bytes = bytes.clone();
        bytes[at] ^= 2;
        bytes
    };
    assert_eq!(refused(b"tin-maps"), "no file of cells; expected one that `terrain-lod dem cells` has written");
    assert_eq!(refused(&changed(0)), "no file of cells; expected one that `terrain-lod dem cells` has written");
    assert_eq!(
        refused(&changed(8)),
        format!("cells of version {}; expected version {}: cut them again", header::VERSION ^ 2, header::VERSION)
    );
    let damaged = |part| format!("damaged: {part}; expected bytes with their checksum: copy or cut it again");
    let header_bytes = open(&bytes).unwrap().0.header().bytes() as usize;
    for at in [12, header_bytes - 1] {
        assert_eq!(refused(&changed(at)), damaged("header"));
    }
    assert_eq!(refused(&changed(header_bytes + 10)), damaged("resident part, cell (0, 0)"));
    let length =
        format!("{} bytes; expected {} by the file's header: copy or cut it again", bytes.len() - 1, bytes.len());
    assert_eq!(refused(&bytes[..bytes.len() - 1]), length);
}

#[test]
fn a_header_whose_heights_are_no_numbers_is_refused() {
    let bytes = cut(&rough(12, 7, 5, true), &options(2, 2));
    let sound = open(&bytes).unwrap().0.header().clone();
    let is_refused =
        |header: CellsHeader| matches!(CellsHeader::read(&header.to_bytes()), Err(CellsError::Damaged { .. }));
    assert!(!is_refused(sound.clone()));
    for [scale_m, offset_m] in
        [[0.0, 1.0], [f64::NAN, 1.0], [f64::INFINITY, 1.0], [1.0, f64::NAN], [1.0, f64::INFINITY]]
    {
        let format = HeightFormat::U16 { scale_m, offset_m };
        assert!(is_refused(CellsHeader { format, ..sound.clone() }), "{format:?}");
    }
    for metres in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(is_refused(CellsHeader { spacing_m: [1.0, metres], ..sound.clone() }), "spacing of {metres}");
    }
}

#[test]
fn a_step_of_no_metres_is_not_chosen_by_the_scan() {
    let mut scan = Scan::new([9, 9], [1.0; 2], Some([0.0, 0.5]), &options(2, 2)).unwrap();
    (0..9).for_each(|_| scan.push(&[0.5; 9]));
    assert_eq!(scan.finish().format, HeightFormat::F32);
}

#[test]
fn resident_numbers_that_no_cutter_writes_are_refused() {
    let bytes = cut(&rough(12, 7, 5, false), &options(2, 2));
    let header = open(&bytes).unwrap().0.header().clone();
    let part = bytes::Part::resident(&header);
    let from = part.offset([1, 0]) as usize;
    let with = |change: &dyn Fn(&mut Cell)| {
        let (mut changed, mut record) = (bytes.clone(), Vec::new());
        let mut cell = part.parse([1, 0], &bytes[from..][..part.record()]).unwrap();
        change(&mut cell);
        part.write([1, 0], &cell, &mut record);
        changed[from..][..record.len()].copy_from_slice(&record);
        open(&changed).map(drop).map_err(|error| error.to_string())
    };
    assert_eq!(with(&|_| ()), Ok(()));
    let expected = "damaged: resident part, cell (1, 0); expected bytes with their checksum: copy or cut it again";
    for range_m in [[2.0, 1.0], [f32::NAN, 1.0], [0.0, f32::INFINITY]] {
        assert_eq!(with(&|cell| cell.ranges_m[0] = range_m), Err(expected.to_owned()), "{range_m:?}");
    }
    assert_eq!(with(&|cell| cell.heights[..4].copy_from_slice(&f32::NAN.to_le_bytes())), Err(expected.to_owned()));
}

/// The loop of whoever keeps the file, ended after some rows of cells.
fn cut_into(file: &mut Vec<u8>, heightmap: &Heightmap, shape: &Options, mut rows_of_cells: u32) -> u32 {
    let samples = [heightmap.columns(), heightmap.rows()];
    let rows = || heightmap.heights_m().chunks(samples[0] as usize);
    let mut scan = Scan::new(samples, heightmap.spacing_m(), None, shape).unwrap();
    rows().for_each(|row_m| scan.push(row_m));
    heightmap.voids().into_iter().for_each(|mask| scan.set_voids(mask));
    let mut cutter = Cutter::new(scan.finish());
    if !cutter.began(file) {
        *file = vec![0; cutter.file_bytes() as usize];
        put(file, vec![(0, cutter.header_bytes())]);
        put(file, heightmap.voids().map(|mask| cutter.cut_voids(mask).unwrap()).into_iter().collect());
    }
    let mut made = 0;
    for row_m in rows() {
        let Some(row) = cutter.push(row_m) else { continue };
        if cutter.has_row(file, row).unwrap() {
            continue;
        }
        if rows_of_cells == 0 {
            return made;
        }
        (rows_of_cells, made) = (rows_of_cells - 1, made + 1);
        put(file, cutter.cut().unwrap());
    }
    cutter.finish().unwrap();
    made
}

fn put(file: &mut [u8], pieces: Vec<(u64, Vec<u8>)>) {
    for (at, piece) in pieces {
        file[at as usize..][..piece.len()].copy_from_slice(&piece);
    }
}

#[test]
fn a_cut_that_was_ended_goes_on() {
    let (heightmap, shape) = (rough(40, 70, 9, true), options(2, 4));
    let whole = cut(&heightmap, &shape);
    for ended in 0..=5 {
        let mut file = Vec::new();
        assert_eq!(cut_into(&mut file, &heightmap, &shape, ended), ended);
        assert_eq!(cut_into(&mut file, &heightmap, &shape, 9), 5 - ended, "rows of cells that were missing");
        assert!(file == whole, "ended after {ended}");
    }
}

#[test]
fn a_cut_that_was_ended_begins_anew_for_another_dem_and_mends_what_is_damaged() {
    let (heightmap, shape) = (rough(40, 70, 9, true), options(2, 4));
    let mut file = Vec::new();
    cut_into(&mut file, &rough(40, 70, 10, true), &shape, 3);
    assert_eq!(cut_into(&mut file, &heightmap, &shape, 9), 5);
    let at = file.len() / 2;
    file[at] ^= 1;
    assert_eq!(cut_into(&mut file, &heightmap, &shape, 9), 1);
    assert!(file == cut(&heightmap, &shape));
}

#[test]
fn rows_that_changed_after_the_scan_are_noticed() {
    let heightmap = rough(12, 7, 5, true);
    let mut scan = Scan::new([12, 7], [1.0; 2], None, &options(2, 2)).unwrap();
    heightmap.heights_m().chunks(12).for_each(|row_m| scan.push(row_m));
    let mut cutter = Cutter::new(scan.finish());
    for row in 0..7 {
        let mut row_m = heightmap.heights_m()[row * 12..][..12].to_vec();
        row_m[3] += (row == 5) as u32 as f32;
        if cutter.push(&row_m).is_some() {
            cutter.cut().unwrap();
        }
    }
    assert_eq!(cutter.finish(), Err(CutError::Changed));
}

/// Cuts a DEM into its own file again, as if sample 3 of row 5 were another by now.
fn cut_changed(file: &mut [u8], heightmap: &Heightmap, change: impl Fn(f32) -> f32) -> Result<(), CutError> {
    let mut cutter = Cutter::new(open(file).unwrap().0.header().clone());
    for (row, row_m) in heightmap.heights_m().chunks(heightmap.columns() as usize).enumerate() {
        let mut row_m = row_m.to_vec();
        if row == 5 {
            row_m[3] = change(row_m[3]);
        }
        if cutter.push(&row_m).is_some() {
            put(file, cutter.cut()?);
        }
    }
    cutter.finish()
}

#[test]
fn a_row_that_was_kept_with_other_heights_is_cut_again() {
    for is_whole in [true, false] {
        let (heightmap, shape) = (rough(40, 70, 9, is_whole), options(2, 4));
        let whole = cut(&heightmap, &shape);
        let mut file = whole.clone();
        assert_eq!(cut_changed(&mut file, &heightmap, |height_m| height_m + 1.0), Err(CutError::Changed));
        assert!(file != whole && read_all(&file).is_ok(), "checksums say nothing");
        assert_eq!(cut_into(&mut file, &heightmap, &shape, 9), 1);
        assert!(file == whole);
    }
}

#[test]
fn a_nan_that_appears_after_the_scan_does_not_panic() {
    for is_whole in [true, false] {
        let heightmap = rough(40, 70, 9, is_whole);
        let mut file = cut(&heightmap, &options(2, 4));
        assert_eq!(cut_changed(&mut file, &heightmap, |_| f32::NAN), Err(CutError::Changed));
    }
}

#[test]
fn a_changed_height_without_a_code_is_not_kept_as_its_neighbour() {
    let heightmap = rough(40, 70, 9, true);
    let whole = cut(&heightmap, &options(2, 4));
    let mut file = whole.clone();
    assert_eq!(cut_changed(&mut file, &heightmap, |height_m| height_m + 0.25), Err(CutError::Changed));
    assert!(file == whole, "nothing of that row was cut");
}

#[test]
fn where_a_dem_comes_from_is_kept_with_its_cells() {
    let heightmap = rough(12, 7, 5, true);
    let text = |text: &str| Some(text.to_owned());
    let all = Provenance {
        source: text("NASA"),
        licence: text("free"),
        notice: text("Höhen © NASA,\nSRTM"),
        place: text("place = { west = 1.0 }"),
    };
    let without = [Provenance { licence: None, ..all.clone() }, Provenance { place: None, ..all.clone() }];
    for provenance in [vec![all.clone(), Provenance::default()], without.into()].concat() {
        let mut scan = Scan::new([12, 7], [1.0; 2], None, &options(2, 3)).unwrap();
        heightmap.heights_m().chunks(12).for_each(|row_m| scan.push(row_m));
        let mut cutter = Cutter::new(CellsHeader { provenance: provenance.clone(), ..scan.finish() });
        let mut file = vec![0; cutter.file_bytes() as usize];
        put(&mut file, vec![(0, cutter.header_bytes())]);
        for row_m in heightmap.heights_m().chunks(12) {
            if cutter.push(row_m).is_some() {
                put(&mut file, cutter.cut().unwrap());
            }
        }
        assert!(read_all(&file).is_ok());
        assert_eq!(open(&file).unwrap().0.header().provenance, provenance);
    }
    let long = Provenance { notice: Some("n".repeat(Provenance::MAX_BYTES)), ..all };
    assert_eq!(
        long.check().unwrap_err().to_string(),
        "65566 bytes of source, licence, notice and place: expected at most 65536"
    );
}

#[test]
fn voids_are_kept_with_cells() {
    for_each_dem(|heightmap, k, layers, what| {
        for (seed, one_in) in [(1, 2), (2, 40), (3, u64::MAX)] {
            let holey = with_voids(heightmap.clone(), seed, one_in);
            let (expected, bytes) = (holey.voids(), cut(&holey, &options(k, layers)));
            let (file, _) = open(&bytes).unwrap();
            let found = file.voids().unwrap();
            assert_eq!(found.as_ref(), expected, "{what}, seed {seed}");
            let counted = file.header().voids.map_or(0, |voids| voids.count);
            assert_eq!(counted, expected.map_or(0, VoidMask::count), "{what}, seed {seed}");
            let without = cut(heightmap, &options(k, layers));
            let header = |bytes: &[u8]| open(bytes).unwrap().0.header().bytes() as usize;
            let records = &without[header(&without)..];
            assert_eq!(&bytes[header(&bytes)..][..records.len()], records, "{what}: heights and errors are the fill's");
        }
    });
}

#[test]
fn a_header_that_promises_other_voids_is_refused() {
    let holey = with_voids(rough(12, 7, 5, true), 1, 3);
    let bytes = cut(&holey, &options(2, 2));
    let (file, _) = open(&bytes).unwrap();
    let (header, length) = (file.header().clone(), file.header().bytes() as usize);
    let with_header = |voids: Voids| {
        let header = CellsHeader { voids: Some(voids), ..header.clone() };
        [&header.to_bytes(), &bytes[length..]].concat()
    };
    let Voids { count, crc } = header.voids.unwrap();
    for voids in [Voids { count: count + 1, crc }, Voids { count, crc: crc ^ 1 }] {
        let said = open(&with_header(voids)).unwrap().0.voids().unwrap_err().to_string();
        assert_eq!(said, "damaged: voids; expected bytes with their checksum: copy or cut it again");
    }
    for count in [0, 12 * 7 + 1, u64::MAX] {
        assert!(matches!(open(&with_header(Voids { count, crc })), Err(CellsError::Damaged { .. })), "{count} voids");
    }
}

#[test]
fn a_cut_that_was_ended_begins_anew_for_other_voids() {
    let (heightmap, shape) = (rough(40, 70, 9, true), options(2, 4));
    let [one, other] = [1, 2].map(|seed| with_voids(heightmap.clone(), seed, 5));
    let mut file = Vec::new();
    assert_eq!(cut_into(&mut file, &one, &shape, 3), 3);
    assert_eq!(cut_into(&mut file, &one, &shape, 9), 2);
    assert!(file == cut(&one, &shape));
    assert_eq!(cut_into(&mut file, &other, &shape, 9), 5);
    assert!(file == cut(&other, &shape));
}

#[test]
fn voids_that_changed_after_the_scan_are_noticed() {
    let [one, other] = [1, 2].map(|seed| with_voids(rough(12, 7, 5, true), seed, 5));
    let cutter = Cutter::new(open(&cut(&one, &options(2, 2))).unwrap().0.header().clone());
    assert!(cutter.cut_voids(one.voids().unwrap()).is_ok());
    assert_eq!(cutter.cut_voids(other.voids().unwrap()).unwrap_err(), CutError::Changed);
}

struct Broken;

impl CellSource for Broken {
    fn len(&self) -> io::Result<u64> {
        Ok(1 << 40)
    }

    fn read_at(&self, _: u64, _: &mut [u8]) -> io::Result<()> {
        Err(io::Error::other("the disk is gone"))
    }
}

#[test]
fn a_disk_that_fails_is_not_a_damaged_file() {
    let error = CellFile::open(Arc::new(Broken)).err().unwrap();
    assert_eq!(error.to_string(), "cannot read cells: the disk is gone");
}

/// Kept files of another version of this crate must not look right: if this fails, raise `VERSION`.
#[test]
fn the_bytes_of_this_version_are_pinned() {
    let height_m = |i: u32| 40.0 * ((i % 97) as f32 * (i / 97) as f32 % 23.0) + (i * 37 % 101) as f32;
    let heightmap = Heightmap::new(97, 70, [10.0; 2], (0..97 * 70).map(height_m).collect()).unwrap();
    let mut bytes = cut(&with_voids(heightmap, 1, 9), &options(3, 4));
    // Forwards, all bytes with a checksum of their own behind them leave a CRC as it was before them.
    bytes.reverse();
    assert_eq!(crc32fast::hash(&bytes), 2_071_075_264);
}
