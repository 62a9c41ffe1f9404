//! `pictures.csv`: how far the pictures of each run are from those of the full grid.

use image::RgbImage;
use serde::{Deserialize, Serialize};
use terrain_core::FlightPath;
use terrain_core::picture::{Raster, compare_depths, mssim, rmse};
use terrain_renderer::{Colour, Look, Normals};

use crate::flip;
use crate::methods::Run;
use crate::output::tidy;

/// One run at one frame.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct PictureRow {
    pub method: String,
    pub setting: String,
    /// Where it is a setting of the method.
    pub tolerance_px: Option<f64>,
    /// What the run's files begin with.
    pub run: String,
    pub frame: u32,
    /// Flat shading of plain triangles: the geometry alone.
    pub flat_rmse: f64,
    pub flat_mssim: Option<f64>,
    /// Empty in a build without the feature `flip`.
    #[serde(default)]
    pub flat_flip: Option<f64>,
    /// As the terrain is seen, with a normal of the DEM at each pixel.
    pub shaded_rmse: f64,
    pub shaded_mssim: Option<f64>,
    #[serde(default)]
    pub shaded_flip: Option<f64>,
    /// Empty where the adapter's depths cannot be read.
    pub depth_rmse_m: Option<f64>,
    pub outline_share: Option<f64>,
    pub ridge_share: Option<f64>,
}

/// What is measured of one view.
pub struct Measured {
    pub flat: RgbImage,
    pub shaded: RgbImage,
    /// Reversed, of the fine picture.
    pub depths: Option<Vec<f32>>,
}

/// Plain triangles, each of one shade.
pub fn flat() -> Look {
    Look { colour: Colour::Plain, normals: Normals::PerTriangle, haze: false, ..Look::default() }
}

/// The luma of a picture, 0 to 255: Rec. 709, of the stored values.
fn luma(picture: &RgbImage) -> Raster {
    let size_px = [picture.width(), picture.height()];
    let luma = |pixel: [u8; 3]| {
        let [red, green, blue] = pixel.map(f32::from);
        0.2126 * red + 0.7152 * green + 0.0722 * blue
    };
    Raster { size_px, values: picture.pixels().map(|pixel| luma(pixel.0)).collect() }
}

impl PictureRow {
    pub fn new(run: &Run, frame: u32, picture: &Measured, reference: &Measured) -> Self {
        let of_luma = |a: &RgbImage, b: &RgbImage| {
            let (a, b) = (luma(a), luma(b));
            (tidy(rmse(&a, &b)), mssim(&a, &b, 255.0).map(tidy))
        };
        let (flat_rmse, flat_mssim) = of_luma(&picture.flat, &reference.flat);
        let (shaded_rmse, shaded_mssim) = of_luma(&picture.shaded, &reference.shaded);
        let depths = picture.depths.as_deref().zip(reference.depths.as_deref());
        let depths = depths.map(|(a, b)| compare_depths(a, b, FlightPath::NEAR_M));
        Self {
            method: run.method.as_str().into(),
            setting: run.setting(),
            tolerance_px: run.takes_tolerance().then_some(run.settings.tolerance_px),
            run: run.file_stem(),
            frame,
            flat_rmse,
            flat_mssim,
            flat_flip: flip::mean(&reference.flat, &picture.flat).map(tidy),
            shaded_rmse,
            shaded_mssim,
            shaded_flip: flip::mean(&reference.shaded, &picture.shaded).map(tidy),
            depth_rmse_m: depths.map(|depths| tidy(depths.rmse_m)),
            outline_share: depths.map(|depths| tidy(depths.outline_share)),
            ridge_share: depths.map(|depths| tidy(depths.ridge_share)),
        }
    }
}
