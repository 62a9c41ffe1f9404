//! FLIP: how different two pictures look when one flips between them (Andersson, Nilsson, Akenine-Möller, Oskarsson,
//! Åström and Fairchild, *FLIP: A difference evaluator for alternating images*, Proc. ACM CGIT 3(2), 2020).

use image::RgbImage;

/// The mean over the pixels, 0 (equal) to 1, seen as the authors assume by default: 67 pixels a degree, about 0.7 m from a
/// screen 0.7 m wide with 3840 pixels. None in a build without the feature `flip`. Panics where the sizes differ.
#[cfg(feature = "flip")]
pub fn mean(reference: &RgbImage, picture: &RgbImage) -> Option<f64> {
    assert_eq!(reference.dimensions(), picture.dimensions(), "pictures of one size");
    let [reference, picture] =
        [reference, picture].map(|it| nv_flip::FlipImageRgb8::with_data(it.width(), it.height(), it));
    let differences = nv_flip::flip(reference, picture, nv_flip::DEFAULT_PIXELS_PER_DEGREE);
    Some(nv_flip::FlipPool::from_image(&differences).mean().into())
}

#[cfg(not(feature = "flip"))]
pub fn mean(_: &RgbImage, _: &RgbImage) -> Option<f64> {
    None
}

#[cfg(all(test, feature = "flip"))]
mod tests {
    use super::*;
    use image::Rgb;

    fn stripes(width_px: u32, dark: u8, light: u8) -> RgbImage {
        RgbImage::from_fn(64, 64, |x, _| Rgb([if x / width_px % 2 == 0 { dark } else { light }; 3]))
    }

    #[test]
    fn equal_pictures_are_not_apart_and_black_and_white_wholly() {
        let [black, white] = [0, 255].map(|grey| RgbImage::from_pixel(64, 64, Rgb([grey; 3])));
        assert_eq!(mean(&black, &black), Some(0.0));
        let apart = mean(&black, &white).unwrap();
        assert!(apart > 0.9 && apart <= 1.0, "{apart}");
    }

    /// What RMSE cannot tell: fine stripes blur into grey at that distance, wide ones do not.
    #[test]
    fn stripes_that_no_eye_resolves_are_nearer_to_grey_than_wide_ones() {
        let grey = RgbImage::from_pixel(64, 64, Rgb([128; 3]));
        let [fine, wide] = [1, 16].map(|width_px| mean(&grey, &stripes(width_px, 96, 160)).unwrap());
        assert!(fine < 0.7 * wide, "{fine} {wide}");
    }

    #[test]
    fn a_stronger_difference_counts_for_more() {
        let plain = stripes(8, 100, 150);
        let apart = |by: u8| mean(&plain, &stripes(8, 100 + by, 150 + by)).unwrap();
        assert!(0.0 < apart(5) && apart(5) < apart(20) && apart(20) < apart(80));
    }
}
