use super::*;
use std::collections::BTreeSet;
use terrain_core::SplitMix64;

/// Whether a level may be split in a cell, by the definition, straight up the levels.
fn may_split(loaded: &BTreeSet<Sheet>, streamed: u32, cells: [u32; 2], level: u32, cell: [u32; 2]) -> bool {
    if level > streamed {
        return true;
    }
    let steps = |other: &[u32; 2]| cell[0].abs_diff(other[0]) + cell[1].abs_diff(other[1]);
    let all = (0..cells[1]).flat_map(|row| (0..cells[0]).map(move |column| [column, row]));
    loaded.contains(&Sheet { level: level - 1, cell })
        && all.filter(|other| steps(other) <= 1).all(|other| may_split(loaded, streamed, cells, level + 1, other))
}

/// A random walk of windows, arrivals and departures.
#[test]
fn what_may_be_split_is_what_the_loaded_sheets_around_allow() {
    let mut allowed_by_depth = [0; 4];
    for seed in 0..60 {
        let mut random = SplitMix64::new(seed);
        let cells = [1 + random.below(9) as u32, 1 + random.below(9) as u32];
        let streamed = 1 + random.below(3) as u32;
        let largest = cells[0].max(cells[1]) as u64;
        let sides: Vec<u32> = (0..streamed).map(|_| 1 + random.below(largest) as u32).collect();
        let (mut window, mut loaded) = (Window::new(&sides, cells), BTreeSet::new());
        for _ in 0..60 {
            window.leaving().into_iter().for_each(|sheet| window.free(sheet));
            window.follow(cells.map(|cells| random.below(cells as u64) as u32));
            loaded.retain(|sheet| window.is_inside(*sheet));
            let inside: Vec<Sheet> = window.inside().collect();
            for sheet in inside.into_iter().filter(|_| random.below(4) > 0) {
                if window.lacks(sheet) {
                    window.enter(sheet);
                    loaded.insert(sheet);
                }
            }
            let allowed = |window: &Window, cell| (1..=4).filter(|level| window.may_split(*level, cell)).count();
            let all = || (0..cells[1]).flat_map(|row| (0..cells[0]).map(move |column| [column, row]));
            let before: Vec<_> = all().map(|cell| allowed(&window, cell)).collect();
            let (fewer, more) = window.count_depths();
            for (cell, before) in all().zip(before) {
                let expected = (1..=4).filter(|level| may_split(&loaded, streamed, cells, *level, cell));
                let (found, expected) = (allowed(&window, cell), expected.count());
                assert_eq!(found, expected, "seed {seed}, cell {cell:?}");
                assert_eq!(fewer.contains(&cell), found < before, "seed {seed}, cell {cell:?}");
                assert!(more || found <= before, "seed {seed}");
                allowed_by_depth[found + streamed as usize - 4] += 1;
            }
        }
    }
    assert!(allowed_by_depth.iter().all(|count| *count > 100), "{allowed_by_depth:?}");
}

#[test]
fn a_place_is_given_away_once_its_sheet_has_left() {
    let sheet = |level, column| Sheet { level, cell: [column, 0] };
    let mut window = Window::new(&[3, 5], [9, 1]);
    window.follow([1, 0]);
    window.inside().collect::<Vec<_>>().into_iter().for_each(|sheet| window.enter(sheet));
    window.count_depths();
    assert!(window.holds(0, [0, 0]) && !window.lacks(sheet(0, 0)) && window.holder(0, [0, 0]) == [0, 0]);
    assert!(window.may_split(1, [0, 0]) && window.may_split(2, [4, 0]) && !window.may_split(1, [4, 0]));
    window.follow([2, 0]);
    assert_eq!(window.leaving(), [sheet(0, 0)]);
    assert!(window.is_inside(sheet(0, 3)) && !window.lacks(sheet(0, 3)), "its place is still that of cell 0");
    window.count_depths();
    assert!(!window.may_split(1, [0, 0]) && window.may_split(2, [0, 0]), "the wider window has not moved");
    window.free(sheet(0, 0));
    assert!(window.lacks(sheet(0, 3)) && !window.holds(0, [0, 0]) && window.holds(1, [0, 0]));
}
