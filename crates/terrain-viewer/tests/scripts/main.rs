//! Scripts on the program itself: what the pictures show and what the numbers say. Skipped without a graphics adapter.

mod bench;
mod pictures;
mod stage;
