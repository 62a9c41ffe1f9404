//! What a suite says of its figures.
//!
//! ```toml
//! [[figures]]
//! name = "tin-figure-1"       # figures/tin-figure-1.png
//! kind = "views"              # or a drawing: "htp-layers", "htp-blocks", "htp-orientations"
//! title = "Figure 1"
//! caption = "What is to be seen, and how the paper's differs."
//! bench = ["1025", "257"]     # in a suite of several: the first of these that is flown; its DEM and runs
//! size_px = [480, 360]        # of each panel
//! columns = 3                 # of panels; all in one row without it
//! camera = { at = [0.5, 0.9], above_ground_share = 0.05, look_at = [0.5, 0.4], fov_y_deg = 45 }
//! zoom = 6                    # the mesh is made for the camera, and looked at closer,
//! aim = [0.5, 0.3]            # in this direction (shares of the DEM)
//!
//! [[figures.panels]]
//! label = "0.5 px"
//! run = 'tin .*tolerance 0.5 px'  # the first run of the bench that matches, as --filter does
//! colour = "shaded"               # as --colour; so normals
//! wireframe = true
//! haze = false
//! ```
//!
//! Without `camera` the view is that of the bench's flight at `moment`, a share of its frames.

use std::ops::RangeInclusive;

use regex_lite::Regex;
use serde::Deserialize;
use terrain_core::{Camera, Flight, FlightPath, Heightmap, Lens, Sample, View};
use terrain_renderer::{Colour, Look, Normals};

use crate::fault::Fault;
use crate::methods::Run;
use crate::render_args::{ColourName, NormalsName};
use crate::suite::{Bench, SIDE_PX, is_folder_name};

/// One figure.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Figure {
    /// Of its file, without the ending.
    pub name: String,
    pub title: String,
    pub caption: String,
    pub kind: Kind,
    /// Drawings: small triangles along a patch's side, and layers; 3 without.
    pub k: Option<u32>,
    pub layers: Option<u32>,
    /// Views: the benches of which the first that is flown is shown; any without.
    pub bench: Vec<String>,
    pub size_px: Option<[u32; 2]>,
    pub columns: Option<u32>,
    pub camera: Option<Place>,
    pub moment: Option<f64>,
    pub zoom: Option<f64>,
    pub aim: Option<[f64; 2]>,
    pub panels: Vec<Panel>,
}

/// What a figure is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// Pictures of one view, side by side
    #[default]
    Views,
    /// The patches of one cell, layer by layer
    HtpLayers,
    /// The plain patch and its matching blocks between their neighbours
    HtpBlocks,
    /// One index list in patches of both orientations
    HtpOrientations,
}

/// Where the camera stands and looks, in shares of the DEM: the same picture of any DEM.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Place {
    pub at: [f64; 2],
    /// Of the DEM's shorter side.
    pub above_ground_share: f64,
    pub look_at: [f64; 2],
    #[serde(default = "usual_fov_y_deg")]
    pub fov_y_deg: f64,
}

fn usual_fov_y_deg() -> f64 {
    60.0
}

/// One picture of a figure.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Panel {
    pub label: String,
    pub run: String,
    pub colour: Option<ColourName>,
    pub normals: Option<NormalsName>,
    pub wireframe: bool,
    pub haze: bool,
}

/// How much closer a view may be looked at.
const ZOOMS: RangeInclusive<f64> = 1.0..=1000.0;

impl Figure {
    /// Refuses what cannot be made.
    pub fn validate(&self) -> Result<(), String> {
        let refuse = |reason: &str| Err(format!("figure {:?}: {reason}", self.name));
        if !is_folder_name(&self.name) {
            return refuse("its name is a file's; expected letters, digits, dots, dashes and underscores");
        }
        if self.kind != Kind::Views {
            return match htp_lod::cell_patches(self.k(), self.layers()) {
                Err(error) => refuse(&error.to_string()),
                Ok(_) if self.layers() < 2 => refuse("layers = 1; expected 2 or more"),
                Ok(_) if self.panels.is_empty() => Ok(()),
                Ok(_) => refuse("panels; expected of kind = \"views\" alone"),
            };
        }
        if self.panels.is_empty() {
            return refuse("no panels; expected at least one");
        }
        if let Some(side) = self.size_px().iter().find(|side| !SIDE_PX.contains(*side)) {
            return refuse(&format!("size_px has {side}; expected {} to {}", SIDE_PX.start(), SIDE_PX.end()));
        }
        if self.columns == Some(0) {
            return refuse("columns = 0; expected 1 or more");
        }
        if !(0.0..=1.0).contains(&self.moment.unwrap_or_default()) {
            return refuse("moment; expected 0 to 1");
        }
        if !ZOOMS.contains(&self.zoom.unwrap_or(1.0)) {
            return refuse(&format!("zoom; expected {} to {}", ZOOMS.start(), ZOOMS.end()));
        }
        if let Some(place) = &self.camera
            && let Err(error) = place.flight(&self.name)
        {
            return refuse(&error.to_string());
        }
        self.panels.iter().try_for_each(|panel| match panel.pattern() {
            Err(error) => refuse(&format!("run {:?}: {error}", panel.run)),
            Ok(_) => Ok(()),
        })
    }

    pub fn k(&self) -> u32 {
        self.k.unwrap_or(3)
    }

    pub fn layers(&self) -> u32 {
        self.layers.unwrap_or(3)
    }

    pub fn size_px(&self) -> [u32; 2] {
        self.size_px.unwrap_or([640, 400])
    }

    /// Its place in the result folder.
    pub fn file(&self) -> String {
        let ending = if self.kind == Kind::Views { "png" } else { "svg" };
        format!("figures/{}.{ending}", self.name)
    }

    /// The view that the meshes are made for.
    pub fn plan_view(&self, bench: &Bench) -> Result<View, Fault> {
        let (camera, fov_y) = self.camera(bench)?;
        Ok(View::new(&camera, &Lens { fov_y, size_px: self.size_px(), near_m: FlightPath::NEAR_M })?)
    }

    /// The same view, closer and in another direction where the figure says so, in a picture of another size.
    pub fn drawn_view(&self, bench: &Bench, size_px: [u32; 2]) -> Result<View, Fault> {
        let (mut camera, fov_y) = self.camera(bench)?;
        if let Some(aim) = self.aim {
            look_at_ground(&mut camera, aim, &bench.dem.heightmap);
        }
        let fov_y = 2.0 * ((0.5 * fov_y).tan() / self.zoom.unwrap_or(1.0)).atan();
        Ok(View::new(&camera, &Lens { fov_y, size_px, near_m: FlightPath::NEAR_M })?)
    }

    /// The camera and its vertical field of view.
    fn camera(&self, bench: &Bench) -> Result<(Camera, f64), Fault> {
        let Some(place) = &self.camera else {
            let frame = (self.moment.unwrap_or(0.5) * f64::from(bench.path.len() - 1)).round() as u32;
            return Ok((bench.path.camera(frame), bench.path.fov_y()));
        };
        let path = FlightPath::new(&place.flight(&self.name)?, &bench.dem.heightmap, 1)?;
        Ok((path.camera(0), path.fov_y()))
    }
}

/// Turns a camera to the ground at shares of the DEM.
fn look_at_ground(camera: &mut Camera, shares: [f64; 2], heightmap: &Heightmap) {
    let (extent_m, last) = (heightmap.extent_m(), [heightmap.columns() - 1, heightmap.rows() - 1]);
    let [column, row] =
        [0, 1].map(|axis| (shares[axis] * f64::from(last[axis])).round().clamp(0.0, last[axis].into()) as u32);
    let up_m = f64::from(heightmap.height_m(Sample { column, row })) - camera.eye_world.y;
    let [east_m, south_m] =
        [shares[0] * extent_m[0] - camera.eye_world.x, shares[1] * extent_m[1] - camera.eye_world.z];
    camera.heading = east_m.atan2(-south_m);
    camera.pitch = up_m.atan2(east_m.hypot(south_m));
}

impl Place {
    /// A flight that stands here: what it refuses, it refuses as for any flight.
    fn flight(&self, name: &str) -> Result<Flight, Fault> {
        let Self { at, above_ground_share, look_at, fov_y_deg } = self;
        let key = |time_s: u32| {
            format!(
                "[[key]]\ntime_s = {time_s}\nat = {at:?}\nabove_ground_share = {above_ground_share:?}\nlook_at = {look_at:?}\n"
            )
        };
        let head = format!("name = {name:?}\nfov_y_deg = {fov_y_deg:?}\nallow_outside = true\n");
        Ok(Flight::parse("camera", &(head + &key(0) + &key(1)))?)
    }
}

impl Panel {
    fn pattern(&self) -> Result<Regex, String> {
        Regex::new(&self.run).map_err(|error| error.to_string().replace('\n', " "))
    }

    /// The run that is shown, if it is flown.
    pub fn run_of<'a>(&self, bench: &'a Bench) -> Option<&'a Run> {
        let pattern = self.pattern().ok()?;
        bench.runs.iter().find(|run| pattern.is_match(&run.title()))
    }

    pub fn look(&self) -> Look {
        Look {
            colour: self.colour.map(Colour::from).unwrap_or_default(),
            normals: self.normals.map(Normals::from).unwrap_or_default(),
            wireframe: self.wireframe,
            haze: self.haze,
            ..Look::default()
        }
    }
}
