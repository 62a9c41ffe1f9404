//! One keyframe, before and after it meets a DEM.

use std::mem::discriminant;

use glam::DVec3;

use crate::Heightmap;
use crate::source::LineColumn;

/// Where the camera is and where it looks at one moment.
#[derive(Clone, Debug, PartialEq)]
pub struct Key {
    /// Where the key starts in its file.
    pub written_at: LineColumn,
    pub time_s: f64,
    pub position: Position,
    pub direction: Direction,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Position {
    /// Metres.
    World(DVec3),
    /// Shares of the DEM's extent in x and z, and the height above ground.
    OverGround([f64; 2], Clearance),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clearance {
    Metres(f64),
    /// Of the DEM's shorter side.
    Share(f64),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// Towards a point in metres.
    LookAtWorld(DVec3),
    /// Towards a point at shares of the DEM's extent in x and z, metres above ground.
    LookAtGround([f64; 2], f64),
    /// In radians.
    Angles { heading: f64, pitch: f64 },
}

impl Position {
    pub fn is_same_kind(&self, other: &Self) -> bool {
        discriminant(self) == discriminant(other)
    }

    /// The TOML key that makes this kind of position.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::World(_) => "position_m",
            Self::OverGround(..) => "at",
        }
    }

    /// The point to spline, in metres: y is the height above ground where the position is given over ground.
    pub fn control_point(&self, heightmap: &Heightmap) -> DVec3 {
        match *self {
            Self::World(point_world) => point_world,
            Self::OverGround(at, Clearance::Metres(clearance_m)) => over_ground(heightmap, at, clearance_m),
            Self::OverGround(at, Clearance::Share(share)) => {
                let [x_m, z_m] = heightmap.extent_m();
                over_ground(heightmap, at, share * x_m.min(z_m))
            }
        }
    }
}

impl Direction {
    pub fn is_same_kind(&self, other: &Self) -> bool {
        discriminant(self) == discriminant(other)
    }

    /// The TOML key that makes this kind of direction.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::LookAtWorld(_) => "look_at_m",
            Self::LookAtGround(..) => "look_at",
            Self::Angles { .. } => "heading_deg",
        }
    }

    /// The point to spline: in metres, or heading and pitch in radians.
    pub fn control_point(&self, heightmap: &Heightmap) -> DVec3 {
        match *self {
            Self::LookAtWorld(point_world) => point_world,
            Self::LookAtGround(at, above_ground_m) => over_ground(heightmap, at, above_ground_m),
            Self::Angles { heading, pitch } => DVec3::new(heading, pitch, 0.0),
        }
    }
}

fn over_ground(heightmap: &Heightmap, at: [f64; 2], above_ground_m: f64) -> DVec3 {
    let [x_m, z_m] = heightmap.extent_m();
    DVec3::new(at[0] * x_m, above_ground_m, at[1] * z_m)
}
