//! Seeded damage to files, for tests that whoever reads them neither panics nor swells.

use crate::SplitMix64;

/// The bytes of a file with one to four places changed, lost, doubled or cut off.
pub fn damage(bytes: &[u8], random: &mut SplitMix64) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    for _ in 0..=random.below(4) {
        let length = bytes.len() as u64;
        if length == 0 {
            break;
        }
        let at = random.below(length) as usize;
        match random.below(8) {
            0 => bytes[at] ^= 1 << random.below(8),
            1 => bytes[at] = random.next_u64() as u8,
            2 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff, b'-', b'9', b' '][random.below(8) as usize],
            3 => bytes.truncate(at),
            4 => drop(bytes.remove(at)),
            5 => bytes.insert(at, [0, 0xff, b'9', b'e', b'\n'][random.below(5) as usize]),
            6 => {
                let end = (at + 1 + random.below(8) as usize).min(bytes.len());
                bytes[at..end].fill([0, 0xff][random.below(2) as usize]);
            }
            _ => {
                let from = random.below(length) as usize;
                let count = (1 + random.below(16) as usize).min(bytes.len() - at.max(from));
                bytes.copy_within(from..from + count, at);
            }
        }
    }
    bytes
}
