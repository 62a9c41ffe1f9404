//! The command line of what draws: which adapter, how draws reach it, and how frames look.

use clap::{Args, ValueEnum};
use serde::{Deserialize, Serialize};
use terrain_renderer::{AdapterChoice, Colour, Normals, Submission};

/// Which adapter draws.
#[derive(Clone, Debug, Args)]
pub struct AdapterArgs {
    /// Part of the adapter's name (or WGPU_ADAPTER_NAME)
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// vulkan, metal, dx12 or gl (or WGPU_BACKEND)
    #[arg(long, value_name = "NAME")]
    pub backend: Option<String>,
}

impl AdapterArgs {
    /// Whether any adapter will do.
    pub fn is_open(&self) -> bool {
        self.adapter.is_none() && self.backend.is_none()
    }

    /// The same for the renderer.
    pub fn choice(&self) -> AdapterChoice {
        AdapterChoice { backend: self.backend.clone(), name: self.adapter.clone() }
    }
}

/// How the draws of a plan reach the GPU.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SubmissionName {
    /// One draw call each
    #[default]
    Direct,
    /// One multi-draw-indirect call for all
    Multi,
}

impl From<SubmissionName> for Submission {
    fn from(name: SubmissionName) -> Self {
        match name {
            SubmissionName::Direct => Self::Direct,
            SubmissionName::Multi => Self::MultiIndirect,
        }
    }
}

/// What the triangles are coloured by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ColourName {
    /// Height and slope, under one sun
    Shaded,
    /// One colour a patch
    Patch,
    /// One colour a level
    Level,
    /// One grey
    Plain,
    /// The normals themselves
    Normal,
    /// One colour a cell of HTP; by patch for methods without cells
    Cell,
    /// One colour a draw call
    Draw,
}

impl From<ColourName> for Colour {
    fn from(name: ColourName) -> Self {
        match name {
            ColourName::Shaded => Self::Shaded,
            ColourName::Patch => Self::ByPatch,
            ColourName::Level => Self::ByLevel,
            ColourName::Plain => Self::Plain,
            ColourName::Normal => Self::ByNormal,
            ColourName::Cell => Self::ByCell,
            ColourName::Draw => Self::ByDraw,
        }
    }
}

/// Where the normals are read that the light falls on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum NormalsName {
    /// At every pixel
    #[default]
    Pixel,
    /// At the vertices
    Vertex,
    /// Of each triangle: flat shading
    Triangle,
}

impl From<NormalsName> for Normals {
    fn from(name: NormalsName) -> Self {
        match name {
            NormalsName::Pixel => Self::PerPixel,
            NormalsName::Vertex => Self::PerVertex,
            NormalsName::Triangle => Self::PerTriangle,
        }
    }
}
