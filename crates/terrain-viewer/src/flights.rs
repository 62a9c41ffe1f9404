//! Flights: played frame by frame, and recorded as the TOML that the bench takes.

use std::fmt::Write;

use terrain_core::{Flight, FlightError, FlightPath, Heightmap};

use crate::camera::Rig;

/// Seconds between the keys of a recorded flight.
const KEY_S: f64 = 0.25;

/// A flight over the ground that is there, and the frame that it is at.
#[derive(Clone, Debug)]
pub struct Playback {
    pub name: String,
    path: FlightPath,
    /// Frames from the start; a whole number where it is stepped.
    at: f64,
    pub is_playing: bool,
}

impl Playback {
    /// At the flight's own frames a second, standing at its first.
    pub fn new(flight: &Flight, heightmap: &Heightmap) -> Result<Self, FlightError> {
        let path = FlightPath::new(flight, heightmap, flight.default_frames())?;
        Ok(Self { name: flight.name().into(), path, at: 0.0, is_playing: false })
    }

    pub fn frame(&self) -> u32 {
        self.at as u32
    }

    pub fn last(&self) -> u32 {
        self.path.len() - 1
    }

    pub fn scrub(&mut self, frame: u32) {
        (self.at, self.is_playing) = (f64::from(frame.min(self.last())), false);
    }

    pub fn step(&mut self, frames: i32) {
        self.scrub(self.frame().saturating_add_signed(frames));
    }

    /// Plays on from here, or from the start where it has ended.
    pub fn toggle(&mut self) {
        self.is_playing = !self.is_playing;
        if self.is_playing && self.frame() == self.last() {
            self.at = 0.0;
        }
    }

    /// Lets the clock run, and puts the camera where the flight is.
    pub fn fly(&mut self, rig: &mut Rig, dt_s: f64) {
        if self.is_playing {
            self.at = (self.at + dt_s / self.path.step_s()).min(f64::from(self.last()));
            self.is_playing = self.frame() < self.last();
        }
        self.place(rig);
    }

    /// Puts the camera where the flight is.
    pub fn place(&self, rig: &mut Rig) {
        rig.camera = self.path.camera(self.frame());
        rig.fov_y = self.path.fov_y();
        rig.orbit = None;
    }
}

/// What the camera did since the recording began: one key in a while.
#[derive(Clone, Debug, Default)]
pub struct Recorder {
    time_s: f64,
    keys: Vec<Key>,
    fov_y: f64,
}

#[derive(Clone, Copy, Debug)]
struct Key {
    time_s: f64,
    position_m: [f64; 3],
    /// Not wrapped: a full turn to the right ends 360 higher.
    heading_deg: f64,
    pitch_deg: f64,
}

impl Recorder {
    pub fn start(rig: &Rig) -> Self {
        let mut recorder = Self { fov_y: rig.fov_y, ..Self::default() };
        recorder.push(rig);
        recorder
    }

    pub fn seconds(&self) -> f64 {
        self.time_s
    }

    /// Lets the clock run, and keeps the camera where a key is due.
    pub fn fly(&mut self, rig: &Rig, dt_s: f64) {
        self.time_s += dt_s;
        if self.keys.last().is_none_or(|key| self.time_s - key.time_s >= KEY_S) {
            self.push(rig);
        }
    }

    fn push(&mut self, rig: &Rig) {
        let heading_deg = rig.camera.heading.to_degrees();
        let before_deg = self.keys.last().map_or(heading_deg, |key| key.heading_deg);
        let turns = ((before_deg - heading_deg) / 360.0).round();
        self.keys.push(Key {
            time_s: self.time_s,
            position_m: rig.camera.eye_world.into(),
            heading_deg: heading_deg + 360.0 * turns,
            pitch_deg: rig.camera.pitch.to_degrees(),
        });
    }

    /// The flight as a file, from the first key to where the camera is now; `None` where no time has passed.
    pub fn finish(mut self, rig: &Rig, name: &str) -> Option<String> {
        if self.keys.last().is_none_or(|key| self.time_s > key.time_s) {
            self.push(rig);
        }
        if self.keys.len() < 2 {
            return None;
        }
        let fov_y_deg = self.fov_y.to_degrees().clamp(1.0, 170.0);
        let mut text =
            format!("name = \"{name}\"\nfov_y_deg = {fov_y_deg:.4}\nallow_outside = true\nallow_below_ground = true\n");
        for Key { time_s, position_m: [x, y, z], heading_deg, pitch_deg } in &self.keys {
            let _ = write!(
                text,
                "\n[[key]]\ntime_s = {time_s:.4}\nposition_m = [{x:.3}, {y:.3}, {z:.3}]\nheading_deg = \
                 {heading_deg:.4}\npitch_deg = {pitch_deg:.4}\n"
            );
        }
        Some(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Motion;

    fn plane() -> Heightmap {
        Heightmap::new(101, 101, [10.0; 2], vec![100.0; 101 * 101]).unwrap()
    }

    /// A turn over north is where headings wrap.
    #[test]
    fn a_recorded_flight_passes_where_the_camera_was() {
        let dem = plane();
        let mut rig = Rig { speed_m_s: 30.0, ..Rig::over(&dem) };
        rig.camera.heading = 350_f64.to_radians();
        let mut recorder = Recorder::start(&rig);
        let mut flown = vec![rig.camera];
        let motion = Motion { forward: 1.0, turn: [0.5, 0.0], ..Default::default() };
        for _ in 0..180 {
            rig.fly(&dem, &motion, 1.0 / 60.0);
            recorder.fly(&rig, 1.0 / 60.0);
            flown.push(rig.camera);
        }
        let text = recorder.finish(&rig, "recorded").unwrap();
        let flight = Flight::parse("recorded.toml", &text).unwrap();
        let mut playback = Playback::new(&flight, &dem).unwrap();
        assert_eq!(playback.last(), 180);
        for (frame, camera) in (0..).zip(&flown) {
            playback.scrub(frame);
            let mut played = rig.clone();
            playback.place(&mut played);
            let apart_m = played.camera.eye_world.distance(camera.eye_world);
            let turned = (played.camera.heading - camera.heading).to_degrees().rem_euclid(360.0);
            assert!(apart_m < 1.0 && turned.min(360.0 - turned) < 1.0, "frame {frame}: {apart_m} m, {turned} degrees");
        }
    }

    #[test]
    fn a_flight_is_played_in_its_own_time_and_stops_at_its_end() {
        let (dem, flight) = (plane(), Flight::built_in("fly-over").unwrap());
        let mut rig = Rig::over(&dem);
        let mut playback = Playback::new(&flight, &dem).unwrap();
        playback.toggle();
        playback.fly(&mut rig, 0.5 * flight.duration_s());
        assert!(playback.frame().abs_diff(playback.last() / 2) <= 1 && playback.is_playing);
        playback.fly(&mut rig, flight.duration_s());
        assert!(playback.frame() == playback.last() && !playback.is_playing);
        playback.step(-1);
        assert_eq!(playback.frame(), playback.last() - 1);
        playback.step(-1_000_000);
        assert_eq!(playback.frame(), 0);
    }

    #[test]
    fn a_recording_of_no_time_is_none() {
        let rig = Rig::over(&plane());
        assert_eq!(Recorder::start(&rig).finish(&rig, "empty"), None);
    }
}
