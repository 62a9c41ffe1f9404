//! The patches of one cell, layer by layer: the hierarchy as such, for pictures and checks (section 2.1, Figure 1).

use terrain_core::PatchInstance;

use crate::grid::{Grid, Half};
use crate::options::{HtpError, Options};
use crate::window::Window;

/// All patches of one cell of a DEM of `k^layers + 1` samples a side: a list a layer, the finest first, as maps from
/// [`local_vertices`](crate::local_vertices) to samples. Refuses what [`Options::validate`] does.
pub fn cell_patches(k: u32, layers: u32) -> Result<Vec<Vec<PatchInstance>>, HtpError> {
    let options = Options { k, layers, ..Options::default() };
    options.validate()?;
    let samples = k.pow(layers) + 1;
    let grid = Grid::sized([samples; 2], [1.0; 2], &options, Window::everything());
    let of_level = |level| {
        let patches = grid.squares(level).flat_map(|square| Half::BOTH.map(|half| square.half(half)));
        patches.map(|patch| grid.instance(patch)).collect()
    };
    Ok((0..layers).map(of_level).collect())
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::{index_list, local_vertices};

    /// More samples a side than any of the cells.
    const SIDE: u32 = 1 << 16;

    /// The three samples of each small triangle of a patch.
    fn triangles(patch: &PatchInstance, k: u32) -> impl Iterator<Item = BTreeSet<[u32; 2]>> {
        let vertices = local_vertices(k);
        let samples = move |index: &u32| {
            let at = patch.sample(vertices[*index as usize], SIDE, SIDE);
            [at.column, at.row]
        };
        index_list(k, 0).into_iter().map(move |triangle| triangle.iter().map(&samples).collect())
    }

    fn corners(patch: &PatchInstance, k: u32) -> BTreeSet<[u32; 2]> {
        let [left, right] = [[k as u16, 0], [0, k as u16]];
        let at = |uv| patch.sample(terrain_core::LocalVertex { uv }, SIDE, SIDE);
        [[0, 0], left, right].map(|uv| [at(uv).column, at(uv).row]).into()
    }

    /// Section 2.1: a patch of a layer is a triangle of the next coarser layer, and each such triangle a patch.
    #[test]
    fn every_triangle_of_a_layer_is_a_patch_of_the_next_finer_one() {
        for (k, layers) in [(2, 4), (3, 3), (4, 2), (5, 1)] {
            let all = cell_patches(k, layers).unwrap();
            assert_eq!(all.len() as u32, layers);
            assert_eq!(all[layers as usize - 1].len(), 2, "the halves of the cell");
            for pair in all.windows(2) {
                let fine: BTreeSet<_> = pair[0].iter().map(|patch| corners(patch, k)).collect();
                let coarse: BTreeSet<_> = pair[1].iter().flat_map(|patch| triangles(patch, k)).collect();
                assert_eq!(fine.len(), pair[0].len());
                assert!(fine == coarse, "k {k}");
            }
        }
        assert!(cell_patches(1, 3).is_err() && cell_patches(3, 9).is_err());
    }
}
