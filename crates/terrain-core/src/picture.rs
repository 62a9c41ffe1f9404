//! How far two pictures of one view are apart, and their depths.
//!
//! RMSE is the root of the mean squared difference. MSSIM is the mean structural similarity of Wang, Bovik, Sheikh and
//! Simoncelli (*Image quality assessment: from error visibility to structural similarity*, IEEE Transactions on Image
//! Processing 13(4), 2004): 1 for equal pictures, less the more their light, contrast and structure differ. As there:
//! Gaussian windows of 11 x 11 with a standard deviation of 1.5, K1 = 0.01, K2 = 0.03. Only windows that lie wholly in
//! the picture count, and pictures are not shrunk first.

/// Numbers of a picture, row by row.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Columns and rows.
    pub size_px: [u32; 2],
    /// One a pixel.
    pub values: Vec<f32>,
}

impl Raster {
    /// A number for each column and row.
    pub fn from_fn(size_px: [u32; 2], value: impl Fn(u32, u32) -> f32) -> Self {
        let [width, height] = size_px;
        let values = (0..height).flat_map(|row| (0..width).map(move |column| (column, row)));
        Self { size_px, values: values.map(|(column, row)| value(column, row)).collect() }
    }
}

/// Root of the mean squared difference; 0 for empty pictures. Panics where the sizes differ.
pub fn rmse(a: &Raster, b: &Raster) -> f64 {
    assert_eq!(a.size_px, b.size_px, "pictures of one size");
    let squares = a.values.iter().zip(&b.values).map(|(a, b)| (f64::from(*a) - f64::from(*b)).powi(2));
    (squares.sum::<f64>() / a.values.len().max(1) as f64).sqrt()
}

/// Pixels along a window of [`mssim`].
pub const WINDOW_PX: usize = 11;
const WINDOW_SIGMA_PX: f64 = 1.5;
const K: [f64; 2] = [0.01, 0.03];

/// Mean structural similarity of pictures whose numbers span `range`; none where no window fits into them. Panics where
/// the sizes differ.
pub fn mssim(a: &Raster, b: &Raster, range: f64) -> Option<f64> {
    assert_eq!(a.size_px, b.size_px, "pictures of one size");
    let [width, height] = a.size_px.map(|side| side as usize);
    if width < WINDOW_PX || height < WINDOW_PX {
        return None;
    }
    let [c1, c2] = K.map(|k| (k * range).powi(2));
    let mean_of = |value: &dyn Fn(f64, f64) -> f64| {
        let products: Vec<f64> = a.values.iter().zip(&b.values).map(|(a, b)| value((*a).into(), (*b).into())).collect();
        window_means(&products, width)
    };
    let (a_mean, b_mean) = (mean_of(&|a, _| a), mean_of(&|_, b| b));
    let (aa, bb, ab) = (mean_of(&|a, _| a * a), mean_of(&|_, b| b * b), mean_of(&|a, b| a * b));
    let similarity = |i: usize| {
        let (a, b) = (a_mean[i], b_mean[i]);
        let (variances, covariance) = (aa[i] - a * a + (bb[i] - b * b), ab[i] - a * b);
        (2.0 * a * b + c1) * (2.0 * covariance + c2) / ((a * a + b * b + c1) * (variances + c2))
    };
    Some((0..a_mean.len()).map(similarity).sum::<f64>() / a_mean.len() as f64)
}

/// The weighted mean of every window that lies wholly in the picture, row by row: the columns of a window first.
fn window_means(values: &[f64], width: usize) -> Vec<f64> {
    let weights = window_weights();
    let weighted = |window: &mut dyn Iterator<Item = f64>| window.zip(weights).map(|(v, w)| v * w).sum::<f64>();
    let along_rows: Vec<f64> = values
        .chunks(width)
        .flat_map(|row| row.windows(WINDOW_PX).map(|window| weighted(&mut window.iter().copied())))
        .collect();
    let columns = width + 1 - WINDOW_PX;
    let rows = along_rows.len() / columns + 1 - WINDOW_PX;
    let at = |row: usize, column: usize| {
        weighted(&mut (0..WINDOW_PX).map(|further| along_rows[(row + further) * columns + column]))
    };
    (0..rows)
        .flat_map(|row| (0..columns).map(move |column| (row, column)))
        .map(|(row, column)| at(row, column))
        .collect()
}

/// Of the pixels along one side of a window; the weight of a pixel is the product of two.
fn window_weights() -> [f64; WINDOW_PX] {
    let centre = (WINDOW_PX / 2) as f64;
    let bell: [f64; WINDOW_PX] =
        std::array::from_fn(|i| libm::exp(-(i as f64 - centre).powi(2) / (2.0 * WINDOW_SIGMA_PX * WINDOW_SIGMA_PX)));
    let sum: f64 = bell.iter().sum();
    bell.map(|weight| weight / sum)
}

/// How far the depths of two pictures of one view are apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DepthDifference {
    /// Root of the mean squared difference of the distances along the view's axis, in metres, over the points that are
    /// terrain in both pictures; 0 where there are none.
    pub rmse_m: f64,
    /// Share of all points, 0 to 1, that are sky in one picture alone: the outline against the sky is another.
    pub outline_share: f64,
    /// Share of all points, 0 to 1, that are terrain in both, one of them farther away by more than a tenth: another
    /// ridge, or a place behind it, is seen.
    pub ridge_share: f64,
}

/// By how much one distance must exceed another for another ridge to be seen.
const RIDGE_RATIO: f64 = 1.1;

/// Compares reversed depths: `near_m` over the distance along the view's axis, 0 for the sky. Panics where there are not
/// as many of both.
pub fn compare_depths(a: &[f32], b: &[f32], near_m: f64) -> DepthDifference {
    assert_eq!(a.len(), b.len(), "depths of one view");
    let (mut both, mut outline, mut ridges, mut sum_of_squares_m2) = (0_u64, 0_u64, 0_u64, 0.0);
    for (a, b) in a.iter().zip(b) {
        match (*a > 0.0, *b > 0.0) {
            (true, true) => {
                let [a_m, b_m] = [a, b].map(|depth| near_m / f64::from(*depth));
                both += 1;
                ridges += u64::from(a_m.max(b_m) > RIDGE_RATIO * a_m.min(b_m));
                sum_of_squares_m2 += (a_m - b_m).powi(2);
            }
            (false, false) => {}
            _ => outline += 1,
        }
    }
    let share = |points: u64| points as f64 / a.len().max(1) as f64;
    DepthDifference {
        rmse_m: (sum_of_squares_m2 / both.max(1) as f64).sqrt(),
        outline_share: share(outline),
        ridge_share: share(ridges),
    }
}

#[cfg(test)]
mod tests;
