//! Smaller versions of a picture in the directories that follow its own (COG; TIFF 6.0, NewSubfileType).

use crate::DemError;
use crate::formats::tiff::ifd::Tags;
use crate::formats::tiff::layout::Layout;
use crate::georef::Spacing;
use crate::input::Input;
use crate::raster::Facts;

const NEW_SUBFILE_TYPE: u16 = 254;

/// Bits of it.
const SMALLER: u64 = 1;
const MASK: u64 = 4;

/// More directories are not followed: a chain may lead back to its start.
const MAX_DIRECTORIES: u32 = 64;

/// The overview of this number, from 1, the finest one; `facts`, which are those of the picture, become its own.
pub fn read(input: &mut Input, picture: &Tags, number: u32, facts: &mut Facts) -> Result<Layout, DemError> {
    let mut overviews = Vec::new();
    let mut next = picture.next;
    for _ in 0..MAX_DIRECTORIES {
        let Some(tags) = picture.following(input, next)? else { break };
        if tags.whole(input, NEW_SUBFILE_TYPE, 0)? & (SMALLER | MASK) == SMALLER {
            overviews.push(Layout::read(input, &tags)?);
        }
        next = tags.next;
    }
    overviews.sort_by_key(|layout| std::cmp::Reverse(layout.columns));
    let count = overviews.len();
    let chosen =
        (number as usize).checked_sub(1).filter(|index| *index < count).map(|index| overviews.swap_remove(index));
    let Some(layout) = chosen else {
        let expected = if count == 0 { "none, since the file has none".to_owned() } else { format!("1 to {count}") };
        return Err(input.refuse(format!("no overview {number}; expected {expected}")));
    };
    if layout.samples != facts.samples || layout.bands != facts.bands {
        return Err(
            input.refuse(format!("overview {number} has other samples than the picture; expected the same ones"))
        );
    }
    facts.format += &format!(", overview {number} of {count}");
    coarsen(facts, &layout);
    Ok(layout)
}

/// The same ground in fewer samples.
fn coarsen(facts: &mut Facts, layout: &Layout) {
    let ratio = [facts.columns as f64 / layout.columns as f64, facts.rows as f64 / layout.rows as f64];
    let coarser = |step: [f64; 2]| [step[0] * ratio[0], step[1] * ratio[1]];
    facts.spacing = facts.spacing.map(|spacing| match spacing {
        Spacing::Metres(metres) => Spacing::Metres(coarser(metres)),
        Spacing::Degrees { degrees, latitude } => Spacing::Degrees { degrees: coarser(degrees), latitude },
    });
    if let Some(place) = &mut facts.place {
        // The corner of the cells stays where it was.
        let [x, z] = place.step;
        place.step = coarser(place.step);
        place.west += (place.step[0] - x) / 2.0;
        place.north -= (place.step[1] - z) / 2.0;
    }
    (facts.columns, facts.rows) = (layout.columns, layout.rows);
}
