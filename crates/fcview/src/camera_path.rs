//! A recorded way of the camera: its file, and the smooth curve through its keys.
//!
//! ```json
//! { "version": 1, "origin": [0, 0, 0],
//!   "keys": [ { "seconds": 0.0, "eye": [0, 1, 5], "forward": [0, 0, -1], "up": [0, 1, 0], "fov": 40.0 }, ... ] }
//! ```
//! Times rise from key to key; `forward` and `up` need be neither of unit length nor at right angles; `fov` is the
//! vertical field of view in degrees. `eye` and `origin` together are coordinates of the input; without `origin`, `eye`
//! is in those of the scene. Other members are ignored.

use crate::Error;
use crate::camera::Camera;
use crate::headless::outputs;
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};
use std::io::Read as _;
use std::path::Path;

/// The only version of the file there is.
const VERSION: u32 = 1;

/// The most bytes of a file: some three hundred thousand keys, hours of recording.
const MOST_BYTES: u64 = 64 << 20;

/// Larger coordinates and times, and their squares, come near the end of the range of numbers.
const MOST: f64 = 1e100;

/// A camera at a time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(expecting = "an object with `seconds`, `eye`, `forward`, `up` and `fov`")]
pub struct PathKey {
    /// When, seconds from any start.
    pub seconds: f64,
    /// Where the camera stands.
    pub eye: [f64; 3],
    /// Where it looks.
    pub forward: [f64; 3],
    /// What is up in the picture.
    pub up: [f64; 3],
    /// Vertical field of view, degrees.
    pub fov: f64,
}

/// The file.
#[derive(Serialize, Deserialize)]
#[serde(expecting = "an object with `version` and `keys`")]
struct PathFile {
    version: u32,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    origin: Option<[f64; 3]>,
    keys: Vec<PathKey>,
}

/// A way of the camera through one or more keys.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraPath {
    keys: Vec<PathKey>,
    /// The keys as points of a curve: eye, rotation as a quaternion, field of view.
    points: Vec<[f64; 8]>,
    /// To be added to the eyes for coordinates of the input; unknown where they are in those of any scene.
    origin: Option<DVec3>,
}

impl PathKey {
    /// The key of a camera.
    pub fn new(seconds: f64, camera: &Camera) -> PathKey {
        PathKey {
            seconds,
            eye: camera.eye.to_array(),
            forward: camera.forward.to_array(),
            up: camera.up.to_array(),
            fov: camera.fov.to_degrees(),
        }
    }

    /// The key as a point of the curve, or what is wrong with it.
    fn point(&self) -> Result<[f64; 8], &'static str> {
        let eye = DVec3::from_array(self.eye);
        let numbers = eye.to_array().into_iter().chain(self.forward).chain(self.up).chain([self.seconds]);
        if numbers.into_iter().any(|x| !x.is_finite()) {
            return Err("a number that is not finite");
        }
        if eye.abs().max_element() > MOST || self.seconds.abs() > MOST {
            return Err("a number beyond 1e100");
        }
        // Scaled first, since squares of large numbers are infinite.
        let direction = |v: [f64; 3]| {
            let v = DVec3::from_array(v);
            (v / v.abs().max_element()).try_normalize()
        };
        let Some(forward) = direction(self.forward) else {
            return Err("a `forward` that is zero");
        };
        let up = direction(self.up).unwrap_or(DVec3::ZERO);
        let Some(right) = forward.cross(up).try_normalize() else {
            return Err("an `up` that is zero or along `forward`");
        };
        if !(1.0..=170.0).contains(&self.fov) {
            return Err("a `fov` outside 1 to 170 degrees");
        }
        let [x, y, z, w] =
            DQuat::from_mat3(&DMat3::from_cols(right, right.cross(forward), -forward)).to_array();
        Ok([eye.x, eye.y, eye.z, x, y, z, w, self.fov])
    }
}

impl CameraPath {
    /// A way through keys.
    ///
    /// # Errors
    /// What is wrong, in words, where there is no key, the times do not rise or a key makes no view.
    pub fn new(keys: Vec<PathKey>) -> Result<CameraPath, String> {
        if keys.is_empty() {
            return Err("there are no keys".to_owned());
        }
        let mut points: Vec<[f64; 8]> = Vec::with_capacity(keys.len());
        for (number, key) in keys.iter().enumerate() {
            let mut point = key.point().map_err(|what| format!("key {number} has {what}"))?;
            // Of the two quaternions of a rotation the one nearer to the last, so that no turn goes the long way.
            if let Some(last) = points.last()
                && (3..7).map(|k| last[k] * point[k]).sum::<f64>() < 0.0
            {
                point[3..7].iter_mut().for_each(|q| *q = -*q);
            }
            points.push(point);
        }
        // Differences over shorter times would leave the range of numbers.
        if let Some(number) = keys.windows(2).position(|pair| pair[1].seconds - pair[0].seconds < 1.0 / MOST)
        {
            return Err(format!("key {} is not later than the one before it", number + 1));
        }
        Ok(CameraPath { keys, points, origin: None })
    }

    /// The same way, of eyes that are in the coordinates of a scene with this origin.
    ///
    /// # Errors
    /// What is wrong, in words, where the origin is no place for a camera.
    pub fn with_origin(self, origin: DVec3) -> Result<CameraPath, String> {
        if !origin.is_finite() || origin.abs().max_element() > MOST {
            return Err("its origin is beyond 1e100 or not finite".to_owned());
        }
        Ok(CameraPath { origin: Some(origin), ..self })
    }

    /// The same way in the coordinates of a scene with this origin, if it is known where it is; else as it is.
    #[must_use]
    pub fn about(mut self, origin: DVec3) -> CameraPath {
        let Some(own) = self.origin.replace(origin) else {
            return self;
        };
        let step = own - origin;
        for (key, point) in self.keys.iter_mut().zip(&mut self.points) {
            key.eye = (DVec3::from_array(key.eye) + step).to_array();
            let [x, y, z, ..] = point;
            [*x, *y, *z] = key.eye;
        }
        self
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`Error::Read`] if it cannot be read, [`Error::CameraPath`] if it is no path.
    pub fn read(path: &Path) -> Result<CameraPath, Error> {
        let failed = |source| Error::Read { path: path.to_path_buf(), source };
        let refused = |reason| Error::CameraPath { path: path.to_path_buf(), reason };
        let file = std::fs::File::open(path).map_err(failed)?;
        if file.metadata().map_err(failed)?.is_dir() {
            return Err(failed(std::io::ErrorKind::IsADirectory.into()));
        }
        let mut bytes = Vec::new();
        file.take(MOST_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
        if bytes.len() as u64 > MOST_BYTES {
            return Err(refused(format!("it has more than {MOST_BYTES} bytes")));
        }
        if bytes.trim_ascii_start().starts_with(b"[") {
            return Err(refused("it is a list, and a path is an object, whose `keys` are a list".to_owned()));
        }
        let file: PathFile = serde_json::from_slice(&bytes).map_err(|error| refused(error.to_string()))?;
        if file.version != VERSION {
            return Err(refused(format!("its version is {}, this program reads {VERSION}", file.version)));
        }
        let path = CameraPath::new(file.keys).map_err(refused)?;
        match file.origin {
            Some(origin) => path.with_origin(DVec3::from_array(origin)).map_err(refused),
            None => Ok(path),
        }
    }

    /// Writes the file; one that is there is replaced.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write(&self, path: &Path) -> Result<(), Error> {
        let origin = self.origin.map(|origin| origin.to_array());
        let file = PathFile { version: VERSION, origin, keys: self.keys.clone() };
        outputs::write_json(path, &file)
    }

    /// Seconds from the first key to the last.
    pub fn seconds(&self) -> f64 {
        match (self.keys.first(), self.keys.last()) {
            (Some(first), Some(last)) => last.seconds - first.seconds,
            _ => 0.0,
        }
    }

    /// The number of keys.
    pub fn key_count(&self) -> usize {
        self.keys.len()
    }

    /// The camera after a part of the way, 0 to 1 in time; at a key it is that key's camera.
    ///
    /// Position and rotation have no kink, and a camera that two keys hold in one place stays there.
    pub fn camera(&self, part: f64) -> Camera {
        let start = self.keys.first().map_or(0.0, |key| key.seconds);
        let now = start + part.clamp(0.0, 1.0) * self.seconds();
        let after = self.keys.partition_point(|key| key.seconds <= now);
        let segment = after.saturating_sub(1).min(self.keys.len().saturating_sub(2));
        let mut point = self.points.get(segment).copied().unwrap_or([0.0; 8]);
        if let (Some(from), Some(to), Some(end)) =
            (self.keys.get(segment), self.keys.get(segment + 1), self.points.get(segment + 1))
        {
            let span = to.seconds - from.seconds;
            let u = ((now - from.seconds) / span).clamp(0.0, 1.0);
            let [leaving, arriving] = [self.tangent(segment), self.tangent(segment + 1)];
            let begin = point;
            for k in 0..8 {
                let (p, q) = (begin[k], end[k]);
                let (m, n) = (span * leaving[k], span * arriving[k]);
                // The cubic with these ends and slopes, as a step from p.
                let c2 = 3.0 * (q - p) - 2.0 * m - n;
                let c3 = m + n - 2.0 * (q - p);
                point[k] = p + u * (m + u * (c2 + u * c3));
            }
            if u >= 1.0 {
                point = *end;
            }
        }
        let [ex, ey, ez, x, y, z, w, fov] = point;
        let rotation = glam::DVec4::new(x, y, z, w).try_normalize().unwrap_or(glam::DVec4::W);
        let rotation = DQuat::from_vec4(rotation);
        Camera {
            eye: DVec3::new(ex, ey, ez),
            forward: rotation * DVec3::NEG_Z,
            up: rotation * DVec3::Y,
            fov: fov.clamp(1.0, 170.0).to_radians(),
        }
    }

    /// The change per second at a key: between those of its two sides, and none where one side stands still.
    fn tangent(&self, number: usize) -> [f64; 8] {
        let side = |number: usize| {
            let (from, to) = (self.keys.get(number)?, self.keys.get(number + 1)?);
            let (p, q) = (self.points.get(number)?, self.points.get(number + 1)?);
            let span = to.seconds - from.seconds;
            Some((span, std::array::from_fn::<f64, 8, _>(|k| (q[k] - p[k]) / span)))
        };
        let before = number.checked_sub(1).and_then(side);
        match (before, side(number)) {
            (Some((a, p)), Some((b, q))) => std::array::from_fn(|k| {
                if p[k] == 0.0 || q[k] == 0.0 { 0.0 } else { (b * p[k] + a * q[k]) / (a + b) }
            }),
            (Some((_, slope)), None) | (None, Some((_, slope))) => slope,
            (None, None) => [0.0; 8],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    fn key(seconds: f64, random: &mut Random) -> PathKey {
        let camera = Camera {
            eye: 5.0 * random.direction(),
            forward: random.direction(),
            up: random.direction(),
            fov: 0.3 + random.unit(),
        };
        PathKey::new(seconds, &camera)
    }

    fn path(count: usize, random: &mut Random) -> CameraPath {
        let mut seconds = -1.0;
        let keys = (0..count).map(|_| {
            seconds += 0.05 + random.unit();
            key(seconds, random)
        });
        CameraPath::new(keys.collect()).unwrap()
    }

    /// How far two cameras are apart.
    fn apart(a: &Camera, b: &Camera) -> f64 {
        a.eye.distance(b.eye) + a.forward.distance(b.forward) + a.up.distance(b.up) + (a.fov - b.fov).abs()
    }

    #[test]
    fn the_way_goes_through_its_keys() {
        let mut random = Random::new(1);
        for count in [1, 2, 3, 9] {
            let path = path(count, &mut random);
            for key in &path.keys {
                let part =
                    if count > 1 { (key.seconds - path.keys[0].seconds) / path.seconds() } else { 0.0 };
                let camera = path.camera(part);
                let view = camera.view([64, 64], 0.1).unwrap();
                let forward = DVec3::from_array(key.forward);
                assert!(camera.eye.distance(DVec3::from_array(key.eye)) < 1e-9);
                assert!(view.forward.distance(forward) < 1e-9, "{} {forward}", view.forward);
                let right = forward.cross(DVec3::from_array(key.up)).try_normalize().unwrap();
                assert!(view.right.distance(right) < 1e-9);
                assert!((camera.fov.to_degrees() - key.fov).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn between_keys_there_is_always_a_view_and_never_a_jump_or_a_kink() {
        let mut random = Random::new(2);
        for _ in 0..20 {
            let path = path(6, &mut random);
            const STEPS: usize = 20_000;
            let cameras: Vec<Camera> =
                (0..=STEPS).map(|step| path.camera(step as f64 / STEPS as f64)).collect();
            for camera in &cameras {
                assert!(camera.view([64, 64], 0.1).is_ok(), "{camera:?}");
            }
            let step = path.seconds() / STEPS as f64;
            for three in cameras.windows(3) {
                let [a, b, c] = three else { unreachable!() };
                assert!(apart(a, b) < 1e4 * step, "a jump");
                // The speed changes little from step to step; at a kink it would change at once.
                let change = ((c.eye - b.eye) - (b.eye - a.eye)).length();
                assert!(change < 1e5 * step * step, "a kink of {}", change / step);
            }
        }
    }

    #[test]
    fn a_camera_that_two_keys_hold_stays() {
        let mut random = Random::new(3);
        let mut keys: Vec<PathKey> = (0..4).map(|n| key(f64::from(n), &mut random)).collect();
        keys[2] = PathKey { seconds: 2.0, ..keys[1] };
        let path = CameraPath::new(keys).unwrap();
        for step in 0..=10 {
            let camera = path.camera((1.0 + 0.1 * f64::from(step)) / 3.0);
            assert!(apart(&camera, &path.camera(1.0 / 3.0)) < 1e-9);
        }
    }

    #[test]
    fn a_turn_goes_the_short_way() {
        let looking = |seconds, degrees: f64| {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let camera =
                Camera { eye: DVec3::ZERO, forward: DVec3::new(sin, 0.0, cos), up: DVec3::Y, fov: 0.7 };
            PathKey::new(seconds, &camera)
        };
        let path = CameraPath::new(vec![looking(0.0, 350.0), looking(1.0, 10.0)]).unwrap();
        assert!(path.camera(0.5).forward.distance(DVec3::Z) < 1e-9);
    }

    #[test]
    fn what_is_written_is_read_again() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.json");
        let path = path(5, &mut Random::new(4));
        path.write(&file).unwrap();
        let read = CameraPath::read(&file).unwrap();
        assert_eq!(read.key_count(), 5);
        // Numbers in decimal come back to the last digit but one.
        assert!((read.seconds() - path.seconds()).abs() < 1e-12);
        for part in [0.0, 0.3, 0.7, 1.0] {
            assert!(apart(&read.camera(part), &path.camera(part)) < 1e-9);
        }
    }

    /// What was recorded beside one tile is seen from there beside another, and a path that does not say where it is stays
    /// as it is.
    #[test]
    fn a_path_with_an_origin_is_one_of_the_input() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.json");
        let [here, there] = [DVec3::new(4.5e6, 5.6e5, 300.0), DVec3::new(4.5e6 + 8.0, 5.6e5, 298.0)];
        let path = path(5, &mut Random::new(6));
        path.clone().with_origin(here).unwrap().write(&file).unwrap();
        let read = CameraPath::read(&file).unwrap().about(there);
        path.write(&file).unwrap();
        let unknown = CameraPath::read(&file).unwrap().about(there);
        for part in [0.0, 0.3, 0.7, 1.0] {
            let camera = path.camera(part);
            assert!(apart(&unknown.camera(part), &camera) < 1e-9);
            let moved = Camera { eye: camera.eye + here - there, ..camera };
            assert!(apart(&read.camera(part), &moved) < 1e-8, "{part}");
        }
    }

    #[test]
    fn a_file_that_is_no_path_is_refused_with_the_reason() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.json");
        let good = r#"{"seconds":0,"eye":[0,0,0],"forward":[0,0,-1],"up":[0,1,0],"fov":40}"#;
        let one = |key: &str| format!(r#"{{"version":1,"keys":[{key}]}}"#);
        for (text, part) in [
            (String::new(), "EOF"),
            ("[]".to_owned(), "it is a list, and a path is an object"),
            (format!(" [{good}]"), "`Paths of the camera` in docs/viewer.md"),
            ("7".to_owned(), "expected an object with `version` and `keys`"),
            (one("7"), "expected an object with `seconds`, `eye`"),
            (r#"{"keys":[]}"#.to_owned(), "version"),
            (one(good).replace(":1", ":2"), "version is 2"),
            (one(""), "no keys"),
            (one(&good.replace("[0,0,-1]", "[0,0,0]")), "forward"),
            (one(&good.replace("[0,0,-1]", "[0,0]")), "invalid length"),
            (one(&good.replace("[0,1,0]", "[0,0,3]")), "up"),
            (one(&good.replace("40", "0")), "fov"),
            (one(&good.replace("40", "1e999")), "out of range"),
            (one(&format!("{good},{good}")), "key 1 is not later"),
            (one(&good.replace("eye\":[0", "eye\":[1e300")), "beyond 1e100"),
            (one(&good.replace("\"seconds\":0", "\"seconds\":-1e300")), "beyond 1e100"),
            (one(&format!("{good},{}", good.replace("\"seconds\":0", "\"seconds\":1e-300"))), "not later"),
            (one(good).replace("\"keys", "\"origin\":[1e300,0,0],\"keys"), "origin is beyond 1e100"),
            (one(good).replace("\"keys", "\"origin\":[0,0],\"keys"), "invalid length"),
        ] {
            std::fs::write(&file, &text).unwrap();
            let error = CameraPath::read(&file).expect_err(&text);
            assert_eq!((error.code(), error.exit_code()), ("FC224", 3), "{error}");
            assert!(error.to_string().contains(part) && error.to_string().contains("a.json"), "{error}");
        }
        for good in [good, &good.replace("[0,0,-1]", "[0,0,-1e300]").replace("[0,1,0]", "[0,1e-300,0]")] {
            std::fs::write(&file, one(good)).unwrap();
            let camera = CameraPath::read(&file).unwrap().camera(0.0);
            assert!(camera.forward.distance(DVec3::NEG_Z) < 1e-9, "{camera:?}");
        }
        assert_eq!(CameraPath::read(&folder.path().join("gone.json")).unwrap_err().exit_code(), 4);
        assert_eq!(CameraPath::read(folder.path()).unwrap_err().exit_code(), 4);
    }
}
