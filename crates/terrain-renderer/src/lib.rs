//! Replays [`FramePlan`](terrain_core::FramePlan)s on wgpu, headless, and measures them. It never names a method.
//!
//! ```text
//!  Heightmap ──> Scene ──────────┐
//!  BufferSizes ─> MethodBuffers ─┤
//!  View, FramePlan, Look ────────┴─> Renderer::frame ──> FrameTimes, Target ──> PNG
//!                                      TerrainPass::prepare ──> PreparedFrame: one loop over the draws
//! ```
//!
//! **Depth** is reversed with the far plane at infinity: 1 at the near plane, 0 at infinity, compare "greater", clear 0.
//! In a float depth buffer the steps of `near / distance` and the steps of the float format then nearly cancel, so
//! that the precision is even from one metre to the horizon; the standard direction would spend almost all of it on
//! the first metres.
//!
//! **Positions** reach the GPU relative to the eye, which is split into a whole sample and a remainder
//! ([`FrameUniforms`]), so that `f32` is exact where it matters: near the eye.
//!
//! A viewer uses [`TerrainPass`] with a pass over its own surface; [`Renderer`] is the same with an offscreen
//! [`Target`] and clocks. Several methods share a pass: each has its [`MethodBuffers`] and each viewport its
//! [`ViewBindings`], and what is prepared stays as it is until it is drawn.

mod buffers;
mod error;
mod gpu;
mod layout;
mod look;
mod pass;
mod pipelines;
mod renderer;
mod scene;
mod submission;
mod target;
mod tiles;
mod timing;

pub use buffers::MethodBuffers;
pub use error::RenderError;
pub use gpu::{AdapterChoice, AdapterFacts, Gpu, ListedAdapter};
pub use layout::FrameUniforms;
pub use look::{Colour, Look, Normals, heat_colour};
pub use pass::{PreparedFrame, TerrainPass, ViewBindings};
pub use renderer::{FrameTimes, Renderer, RendererSettings};
pub use scene::Scene;
pub use submission::Submission;
pub use target::Target;
pub use tiles::{LevelUniforms, TileUniforms};
