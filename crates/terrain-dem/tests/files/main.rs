//! Files made on the fly: the same grid in every way that a format allows, and files that are wrong.

mod broken;
mod broken_headers;
mod broken_tiffs;
mod by_rows;
mod parts;
mod tiff_writer;
mod tiles;
mod variants;
mod writers;
