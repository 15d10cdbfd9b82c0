//! Values of options, read from text.

use std::str::FromStr;

use glam::Vec3;
use shadowgraph::frame::Selection;
use shadowgraph::techniques::voxel::MAX_RESOLUTION;

/// Greatest width and height of a picture.
pub const LARGEST: u32 = 16384;

/// Size of a picture in pixels: `1280x720`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub [u32; 2]);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = || format!("expected WIDTHxHEIGHT such as 1280x720, each from 1 to {LARGEST}");
        let (width, height) = text.split_once('x').ok_or_else(expected)?;
        let side = |text: &str| text.parse().ok().filter(|side| (1..=LARGEST).contains(side));
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Self([width, height])),
            _ => Err(expected()),
        }
    }
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.0[0], self.0[1])
    }
}

/// Voxels along x, y and z: `N`, or `X,Y,Z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Resolution(pub [u32; 3]);

impl FromStr for Resolution {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let counts: Option<Vec<u32>> = text
            .split(',')
            .map(|count| count.trim().parse().ok().filter(|count| (1..=MAX_RESOLUTION).contains(count)))
            .collect();
        match counts.as_deref() {
            Some(&[n]) => Ok(Self([n; 3])),
            Some(&[x, y, z]) => Ok(Self([x, y, z])),
            _ => Err(format!("expected N or X,Y,Z such as 128 or 64,32,64, each from 1 to {MAX_RESOLUTION}")),
        }
    }
}

/// Reads finite numbers between commas.
fn numbers(text: &str) -> Option<Vec<f32>> {
    text.split(',').map(|number| number.trim().parse().ok().filter(|number: &f32| number.is_finite())).collect()
}

/// Reads a point: `x,y,z`.
pub fn point(text: &str) -> Result<Vec3, String> {
    match numbers(text).as_deref() {
        Some(&[x, y, z]) => Ok(Vec3::new(x, y, z)),
        _ => Err("expected three finite numbers x,y,z such as 1,2.5,-3".into()),
    }
}

/// Reads a direction: `x,y,z`, not all 0. Gives unit length.
pub fn direction(text: &str) -> Result<Vec3, String> {
    unit(point(text)?).ok_or_else(|| "a direction must not be 0,0,0".into())
}

fn unit(vector: Vec3) -> Option<Vec3> {
    // Scaled first, so that squares of great and small numbers stay in range.
    let greatest = vector.abs().max_element();
    (greatest > 0.0).then(|| (vector / greatest).normalize())
}

/// A sun: `dx,dy,dz` or `dx,dy,dz,LUX`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// The way its light travels, of unit length.
    pub direction: Vec3,
    /// Lux.
    pub illuminance: f32,
}

impl Sun {
    /// Direct sunlight on a clear day, in lux.
    pub const CLEAR_DAY: f32 = 100_000.0;
}

impl FromStr for Sun {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (x, y, z, illuminance) = match numbers(text).as_deref() {
            Some(&[x, y, z]) => (x, y, z, Self::CLEAR_DAY),
            Some(&[x, y, z, lux]) => (x, y, z, lux),
            _ => return Err("expected dx,dy,dz or dx,dy,dz,LUX such as -0.3,-1,-0.2,100000".into()),
        };
        let direction = unit(Vec3::new(x, y, z)).ok_or("the direction must not be 0,0,0")?;
        if illuminance < 0.0 {
            return Err("LUX must not be negative".into());
        }
        Ok(Self { direction, illuminance })
    }
}

/// Reads an angle in degrees between 0 and 180, exclusive. Gives radians.
pub fn field_of_view(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(degrees) if degrees > 0.0 && degrees < 180.0 => Ok(degrees.to_radians()),
        _ => Err("expected degrees between 0 and 180, exclusive".into()),
    }
}

/// Reads a number that is finite and not negative.
pub fn not_negative(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(number) if number >= 0.0 && number.is_finite() => Ok(number),
        _ => Err("expected a finite number, 0 or more".into()),
    }
}

/// Reads a number that is finite and greater than 0.
pub fn positive(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(number) if number > 0.0 && number.is_finite() => Ok(number),
        _ => Err("expected a finite number greater than 0".into()),
    }
}

/// Reads a number of samples a pixel.
pub fn samples(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(samples @ (1 | 2 | 4 | 8)) => Ok(samples),
        _ => Err("expected 1, 2, 4 or 8".into()),
    }
}

/// Reads a list of layers: `all`, or names between commas.
pub fn layers(text: &str) -> Result<Selection, String> {
    let names: Vec<String> = text.split(',').map(|name| name.trim().to_string()).collect();
    if names.iter().any(String::is_empty) {
        return Err("expected `all`, or names of layers between commas such as color,Z,N".into());
    }
    Ok(if names.iter().any(|name| name == "all") { Selection::All } else { Selection::Only(names) })
}

/// Where a scene comes from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SceneSource {
    /// `builtin:NAME`.
    Builtin(String),
    /// A glTF file.
    File(std::path::PathBuf),
}

/// Reads the place of a scene. Which names and files exist is seen later.
pub fn scene(text: &str) -> Result<SceneSource, String> {
    match text.strip_prefix("builtin:") {
        Some(name) => Ok(SceneSource::Builtin(name.into())),
        None if text.is_empty() => Err("expected a path, or builtin:NAME".into()),
        None => Ok(SceneSource::File(text.into())),
    }
}

impl std::fmt::Display for SceneSource {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Builtin(name) => write!(f, "builtin:{name}"),
            Self::File(path) => write!(f, "{}", path.display()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn sizes() {
        assert_eq!("1280x720".parse::<Size>().unwrap().0, [1280, 720]);
        assert_eq!("1x16384".parse::<Size>().unwrap().0, [1, 16384]);
        for bad in ["", "1280", "x", "1280x", "0x720", "1280x0", "16385x1", "1280x720x1", "-1x5", "1.5x2", "9e9x1"] {
            assert!(bad.parse::<Size>().unwrap_err().contains("1280x720"), "{bad}");
        }
        let size: Size = "7x9".parse().unwrap();
        assert_eq!(size.to_string(), "7x9");
    }

    #[test]
    fn resolutions() {
        assert_eq!("64".parse::<Resolution>().unwrap().0, [64; 3]);
        assert_eq!("64, 1,2048".parse::<Resolution>().unwrap().0, [64, 1, 2048]);
        for bad in ["", "0", "2049", "1,2", "1,2,3,4", "-1", "1.5", "a"] {
            assert!(bad.parse::<Resolution>().unwrap_err().contains("64,32,64"), "{bad}");
        }
    }

    #[test]
    fn points_and_directions() {
        assert_eq!(point("1,-2.5,3e2").unwrap(), Vec3::new(1.0, -2.5, 300.0));
        assert_eq!(point(" 1, 2 ,3 ").unwrap(), Vec3::new(1.0, 2.0, 3.0));
        for bad in ["", "1,2", "1,2,3,4", "1,2,x", "1,2,inf", "1,2,NaN", "1,,3", "1e39,0,0"] {
            assert!(point(bad).is_err(), "{bad}");
            assert!(direction(bad).is_err(), "{bad}");
        }
        assert_eq!(direction("0,-3,0").unwrap(), Vec3::NEG_Y);
        assert_eq!(direction("0,1e-30,0").unwrap(), Vec3::Y);
        assert_eq!(direction("3e38,0,0").unwrap(), Vec3::X);
        assert!(direction("0,0,-0").is_err());
    }

    #[test]
    fn suns() {
        let sun: Sun = "0,-2,0".parse().unwrap();
        assert_eq!(sun, Sun { direction: Vec3::NEG_Y, illuminance: 100_000.0 });
        assert_eq!("1,0,0,5.5".parse::<Sun>().unwrap().illuminance, 5.5);
        for bad in ["0,0,0", "1,2", "1,0,0,-1", "1,0,0,inf", "1,0,0,5,6", "a,b,c"] {
            assert!(bad.parse::<Sun>().is_err(), "{bad}");
        }
    }

    #[test]
    fn angles() {
        assert_eq!(field_of_view("90").unwrap(), std::f32::consts::FRAC_PI_2);
        for bad in ["0", "180", "-5", "NaN", "inf", "ninety", ""] {
            assert!(field_of_view(bad).is_err(), "{bad}");
        }
        assert_eq!(not_negative("0").unwrap(), 0.0);
        for bad in ["-1", "NaN", "inf", ""] {
            assert!(not_negative(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn samples_a_pixel() {
        assert_eq!(["1", "2", "4", "8"].map(|text| samples(text).unwrap()), [1, 2, 4, 8]);
        for bad in ["0", "3", "16", "-4", "four", ""] {
            assert!(samples(bad).unwrap_err().contains("2, 4 or 8"), "{bad}");
        }
    }

    #[test]
    fn layer_lists() {
        assert_eq!(layers("all").unwrap(), Selection::All);
        assert_eq!(layers("Z, N").unwrap(), Selection::Only(vec!["Z".into(), "N".into()]));
        assert_eq!(layers("Z,all").unwrap(), Selection::All);
        for bad in ["", "Z,", ",Z"] {
            assert!(layers(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn scenes() {
        assert_eq!(scene("builtin:cornell").unwrap(), SceneSource::Builtin("cornell".into()));
        assert_eq!(scene("a/b.glb").unwrap(), SceneSource::File("a/b.glb".into()));
        assert_eq!(scene("builtin:cornell").unwrap().to_string(), "builtin:cornell");
        assert!(scene("").is_err());
    }
}
