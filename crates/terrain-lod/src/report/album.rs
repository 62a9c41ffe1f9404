//! Pictures in the page itself, as far as they are not too large for one.

use std::path::Path;

use crate::fault::Fault;
use crate::report::html;

/// A larger picture stays a file.
const MOST_OF_ONE: u64 = 8_000_000;
/// So do all that come after so many bytes: a page of more than about 64 MB is slow to open.
const MOST_OF_ALL: u64 = 48_000_000;

/// What a page has room for.
pub struct Album {
    is_open: bool,
    left: u64,
    /// Pictures that had no place.
    pub left_out: usize,
}

impl Album {
    /// `is_open`: whether pictures are wanted at all.
    pub fn new(is_open: bool) -> Self {
        Self { is_open, left: MOST_OF_ALL, left_out: 0 }
    }

    pub fn is_open(&self) -> bool {
        self.is_open
    }

    /// A picture as a URI that needs no file; `None` where it has to stay one.
    pub fn embed(&mut self, path: &Path) -> Result<Option<String>, Fault> {
        let failed = |e| Fault::read(path, &e, "a picture of a bench");
        let bytes = if self.is_open { std::fs::metadata(path).map_err(failed)?.len() } else { 0 };
        if !self.is_open || bytes > MOST_OF_ONE.min(self.left) {
            self.left_out += 1;
            return Ok(None);
        }
        self.left -= bytes;
        let kind = if path.extension().is_some_and(|ending| ending == "svg") { "image/svg+xml" } else { "image/png" };
        Ok(Some(html::data_uri(kind, &std::fs::read(path).map_err(failed)?)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_has_room_for_so_many_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: u64| {
            let path = folder.path().join(name);
            std::fs::File::create(&path).unwrap().set_len(bytes).unwrap();
            path
        };
        let (large, picture) = (write("large.png", MOST_OF_ONE + 1), write("a.svg", 3));
        let mut album = Album::new(true);
        assert_eq!(album.embed(&large).unwrap(), None);
        assert_eq!(album.embed(&picture).unwrap().unwrap(), "data:image/svg+xml;base64,AAAA");
        album.left = 2;
        assert_eq!((album.embed(&picture).unwrap(), album.left_out), (None, 2));
        let missing = album.embed(&folder.path().join("b.png")).unwrap_err();
        assert!(missing.to_string().contains("b.png"), "{missing}");
    }
}
