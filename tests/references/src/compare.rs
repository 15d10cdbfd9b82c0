//! Comparisons that count: how many values were compared, how many left out and why, how many differ, which is worst.
//!
//! A comparison that compared nothing fails.

use std::collections::BTreeMap;
use std::fmt;
use std::path::PathBuf;

use glam::DVec3;

/// Errors of the pixels of a picture against a tolerance.
pub struct Comparison {
    name: String,
    size: [u32; 2],
    tolerance: f64,
    outcomes: Vec<Outcome>,
    reasons: BTreeMap<&'static str, usize>,
}

#[derive(Clone, Copy, PartialEq)]
enum Outcome {
    /// Nobody said anything about it.
    Absent,
    LeftOut,
    /// Infinite for values that are not numbers.
    Error(f64),
}

/// What a [`Comparison`] found.
#[derive(Clone, Debug)]
pub struct Tally {
    /// What was compared.
    pub name: String,
    /// Largest error that agrees.
    pub tolerance: f64,
    /// Values compared.
    pub compared: usize,
    /// Values left out, by reason.
    pub left_out: BTreeMap<&'static str, usize>,
    /// Values with an error above the tolerance.
    pub mismatching: usize,
    /// Largest error, and its pixel.
    pub worst: Option<(f64, [u32; 2])>,
}

impl Comparison {
    /// A comparison of pictures of `size`; errors up to and including `tolerance` agree.
    pub fn new(name: impl Into<String>, size: [u32; 2], tolerance: f64) -> Self {
        let outcomes = vec![Outcome::Absent; (size[0] * size[1]) as usize];
        Self { name: name.into(), size, tolerance, outcomes, reasons: BTreeMap::new() }
    }

    /// Pixel `index` (rows from the top) is left out.
    pub fn leave_out(&mut self, index: usize, reason: &'static str) {
        self.put(index, Outcome::LeftOut);
        *self.reasons.entry(reason).or_default() += 1;
    }

    /// Pixel `index` has an error.
    pub fn error(&mut self, index: usize, error: f64) {
        self.put(index, Outcome::Error(if error.is_nan() { f64::INFINITY } else { error.abs() }));
    }

    /// Pixel `index` agrees exactly or not at all.
    pub fn same(&mut self, index: usize, same: bool) {
        self.error(index, if same { 0.0 } else { f64::INFINITY });
    }

    fn put(&mut self, index: usize, outcome: Outcome) {
        assert!(self.outcomes[index] == Outcome::Absent, "{}: pixel {index} was given twice", self.name);
        self.outcomes[index] = outcome;
    }

    /// Counts.
    pub fn tally(&self) -> Tally {
        let errors = || {
            self.outcomes.iter().enumerate().filter_map(|(i, o)| match o {
                Outcome::Error(e) => Some((*e, i)),
                _ => None,
            })
        };
        let place = |i: usize| [i as u32 % self.size[0], i as u32 / self.size[0]];
        Tally {
            name: self.name.clone(),
            tolerance: self.tolerance,
            compared: errors().count(),
            left_out: self.reasons.clone(),
            mismatching: errors().filter(|&(e, _)| e > self.tolerance).count(),
            worst: errors().max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1))).map(|(e, i)| (e, place(i))),
        }
    }

    /// Prints the counts and fails where nothing was compared, where less than the share `least_agreement` of the
    /// compared values agrees, or where more than the share `most_left_out` was left out. A failure leaves a picture
    /// in `target/test-pictures/`; so does every comparison where `SHADOWGRAPH_TEST_PICTURES` is set.
    pub fn check(&self, least_agreement: f64, most_left_out: f64) -> Tally {
        let tally = self.tally();
        println!("{tally}");
        let failure = tally.failure(least_agreement, most_left_out);
        if failure.is_some() || std::env::var_os("SHADOWGRAPH_TEST_PICTURES").is_some() {
            match self.write_picture() {
                Ok(path) => println!("  picture: {}", path.display()),
                Err(error) => println!("  no picture: {error}"),
            }
        }
        if let Some(why) = failure {
            panic!("{tally}\n  {why}");
        }
        tally
    }

    /// Writes the errors as a picture: grey where left out, black where nothing was said, dark green where equal to
    /// yellow at the tolerance, red above it.
    pub fn write_picture(&self) -> std::io::Result<PathBuf> {
        let color = |outcome: &Outcome| match *outcome {
            Outcome::Absent => [0, 0, 0],
            Outcome::LeftOut => [110, 110, 110],
            Outcome::Error(e) if e > self.tolerance => [255, 0, 0],
            Outcome::Error(0.0) => [0, 80, 0],
            Outcome::Error(e) => [(e / self.tolerance * 255.0) as u8, 190, 0],
        };
        let pixels: Vec<u8> = self.outcomes.iter().flat_map(color).collect();
        write_png(&self.name, self.size, &pixels)
    }
}

impl Tally {
    /// Share of the compared values that agrees; 0 where there is none.
    pub fn agreement(&self) -> f64 {
        if self.compared == 0 { 0.0 } else { 1.0 - self.mismatching as f64 / self.compared as f64 }
    }

    /// Share of the values that was left out.
    pub fn left_out_share(&self) -> f64 {
        let left_out: usize = self.left_out.values().sum();
        left_out as f64 / (left_out + self.compared).max(1) as f64
    }

    /// Why a comparison fails, a sentence; see [`Comparison::check`].
    pub fn failure(&self, least_agreement: f64, most_left_out: f64) -> Option<String> {
        if self.compared == 0 {
            return Some("nothing was compared".into());
        }
        if self.agreement() < least_agreement {
            return Some(format!("at least {:.3} % must agree", least_agreement * 100.0));
        }
        (self.left_out_share() > most_left_out)
            .then(|| format!("at most {:.3} % may be left out", most_left_out * 100.0))
    }
}

impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(
            f,
            "{}: {} compared, {} differ by more than {:e}",
            self.name, self.compared, self.mismatching, self.tolerance
        )?;
        write!(f, " ({:.4} % agree)", self.agreement() * 100.0)?;
        if let Some((error, [x, y])) = self.worst {
            write!(f, ", worst {error:.3e} at ({x}, {y})")?;
        }
        if !self.left_out.is_empty() {
            write!(f, "; {:.3} % left out:", self.left_out_share() * 100.0)?;
            for (reason, count) in &self.left_out {
                write!(f, " {count} {reason}")?;
            }
        }
        Ok(())
    }
}

/// |found − expected| over |expected|, which counts as at least `floor`. Equal infinities have no error.
pub fn relative(found: f64, expected: f64, floor: f64) -> f64 {
    if found == expected { 0.0 } else { (found - expected).abs() / expected.abs().max(floor) }
}

/// Angle between two vectors in degrees, exact for small angles too.
pub fn degrees(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// Writes 8-bit RGB, rows from the top, to `target/test-pictures/NAME.png`; characters that a file name may not have
/// become dashes.
pub fn write_png(name: &str, size: [u32; 2], rgb: &[u8]) -> std::io::Result<PathBuf> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../target/test-pictures"));
    std::fs::create_dir_all(&folder)?;
    let plain: String = name.chars().map(|c| if c.is_alphanumeric() || "._".contains(c) { c } else { '-' }).collect();
    let path = folder.join(plain + ".png");
    image::save_buffer(&path, rgb, size[0], size[1], image::ColorType::Rgb8).map_err(std::io::Error::other)?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_what_agrees_what_differs_and_what_is_left_out() {
        let mut c = Comparison::new("counts", [3, 2], 0.1);
        c.error(0, 0.1);
        c.error(1, -0.2);
        c.error(2, f64::NAN);
        c.leave_out(3, "near an edge");
        c.same(4, true);
        let t = c.tally();
        assert_eq!((t.compared, t.mismatching, t.worst), (4, 2, Some((f64::INFINITY, [2, 0]))));
        assert_eq!((t.agreement(), t.left_out_share()), (0.5, 0.2));
        assert_eq!(t.left_out["near an edge"], 1);
        assert!(t.failure(0.5, 0.2).is_none());
        assert!(t.failure(0.51, 0.2).is_some_and(|why| why.contains("51.000 % must agree")));
        assert!(t.failure(0.5, 0.19).is_some_and(|why| why.contains("19.000 % may be left out")));
    }

    #[test]
    #[should_panic(expected = "nothing was compared")]
    fn a_comparison_of_nothing_fails() {
        let mut c = Comparison::new("nothing", [2, 1], 1.0);
        c.leave_out(0, "all");
        c.leave_out(1, "all");
        c.check(0.0, 1.0);
    }

    #[test]
    #[should_panic(expected = "given twice")]
    fn a_pixel_counts_once() {
        let mut c = Comparison::new("twice", [2, 1], 1.0);
        c.error(0, 0.0);
        c.error(0, 0.0);
    }

    #[test]
    fn pictures_show_what_differs() {
        let mut c = Comparison::new("a picture/of: three", [4, 1], 1.0);
        c.error(0, 2.0);
        c.leave_out(1, "for the test");
        c.same(2, true);
        let path = c.write_picture().unwrap();
        assert!(path.ends_with("a-picture-of--three.png"), "{path:?}");
        let picture = image::open(&path).unwrap().to_rgb8();
        let pixels: Vec<_> = picture.pixels().map(|p| p.0).collect();
        assert_eq!(pixels, [[255, 0, 0], [110; 3], [0, 80, 0], [0; 3]]);
    }

    #[test]
    fn errors_are_relative_and_angles_exact() {
        assert_eq!(relative(1.5, 1.0, 0.0), 0.5);
        assert_eq!(relative(0.1, 0.0, 0.2), 0.5);
        assert_eq!(relative(f64::INFINITY, f64::INFINITY, 0.0), 0.0);
        assert!(relative(f64::NAN, 1.0, 0.0).is_nan());
        assert!((degrees(DVec3::X, DVec3::new(1.0, 1e-9, 0.0)) - 1e-9_f64.to_degrees()).abs() < 1e-20);
        assert!((degrees(DVec3::X, DVec3::NEG_X) - 180.0).abs() < 1e-12);
    }
}
