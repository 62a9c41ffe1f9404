#![no_main]

use std::sync::Arc;

use htp_lod::CellFile;

/// So few that a mutant is read in milliseconds.
const MAX_CELLS: u32 = 64;

// A file of cells, all of which are read; checksums count as right in a fuzzer's build.
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok((file, _)) = CellFile::open(Arc::new(bytes.to_vec())) else { return };
    let header = file.header();
    let [columns, rows] = header.cells().map(|cells| cells.min(MAX_CELLS));
    for cell in (0..rows).flat_map(|row| (0..columns).map(move |column| [column, row])) {
        for level in 0..header.streamed {
            let _ = file.read(level, cell);
        }
    }
    let _ = (file.voids(), file.heights_m(0));
});
