//! Lenses by their published data, and a person's own in small TOML files.

use std::path::{Path, PathBuf};

use directories::ProjectDirs;
use serde::{Deserialize, Serialize};

use crate::field::LensShape;
use crate::within;

/// A lens as its maker describes it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownLens {
    /// What people call it.
    pub name: String,
    /// Focal length, in millimetres.
    pub focal_mm: f32,
    /// Widest and narrowest aperture.
    pub f_numbers: [f32; 2],
    /// Blades of its diaphragm; none where it is round.
    #[serde(default)]
    pub blades: Option<u8>,
    /// Nearest distance that it focuses on, in metres.
    #[serde(default)]
    pub nearest_m: Option<f32>,
}

/// The most that a lens file may hold.
const MOST_BYTES: u64 = 64 << 10;
/// The most files that are looked at.
const MOST_FILES: usize = 200;

/// Name, focal length, apertures, blades and nearest focus, as their makers print them.
const PUBLISHED: [(&str, f32, [f32; 2], u8, f32); 9] = [
    ("Helios 44-2 58 mm f/2", 58.0, [2.0, 16.0], 8, 0.5),
    ("Canon EF 35 mm f/1.4L II", 35.0, [1.4, 22.0], 9, 0.28),
    ("Canon EF 50 mm f/1.8 II", 50.0, [1.8, 22.0], 5, 0.45),
    ("Canon EF 85 mm f/1.2L II", 85.0, [1.2, 16.0], 8, 0.95),
    ("Canon EF 135 mm f/2L", 135.0, [2.0, 32.0], 8, 0.9),
    ("Leica Noctilux-M 50 mm f/0.95", 50.0, [0.95, 16.0], 11, 1.0),
    ("Leica Summilux-M 35 mm f/1.4", 35.0, [1.4, 16.0], 9, 0.7),
    ("Nikon AF-S 85 mm f/1.4G", 85.0, [1.4, 16.0], 9, 0.85),
    ("Sony FE 135 mm f/1.8 GM", 135.0, [1.8, 22.0], 11, 0.7),
];

/// Why a lens file cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("this lens cannot be used — {why} — a lens has name, focal_mm, f_numbers, and may have blades and nearest_m: {}", .path.display())]
pub struct LensFileError {
    why: String,
    path: PathBuf,
}

impl KnownLens {
    /// Reads a lens from a TOML file.
    ///
    /// # Errors
    /// A file that cannot be read or is too large; what is missing or cannot be.
    pub fn read(path: &Path) -> Result<Self, LensFileError> {
        let failed = |why: String| LensFileError { why, path: path.to_owned() };
        let text = within::text(path, MOST_BYTES).map_err(|e| failed(e.to_string()))?;
        let lens: Self = toml::from_str(&text).map_err(|e| failed(e.message().replace('\n', " ")))?;
        lens.check().map_err(|what| failed(format!("its {what} is out of range")))?;
        Ok(lens)
    }

    /// Names what no lens has.
    fn check(&self) -> Result<(), &'static str> {
        let [widest, narrowest] = self.f_numbers;
        let checks = [
            (
                "name",
                !self.name.trim().is_empty() && self.name.chars().count() <= 80 && !self.name.contains(within::is_odd),
            ),
            ("focal_mm", (1.0..=3000.0).contains(&self.focal_mm)),
            ("f_numbers", (0.5..=90.0).contains(&widest) && (widest..=90.0).contains(&narrowest)),
            ("blades", self.blades.is_none_or(|n| (3..=LensShape::BLADES[1]).contains(&n))),
            ("nearest_m", self.nearest_m.is_none_or(|m| (0.001..=100.0).contains(&m))),
        ];
        checks.iter().find(|(_, is_good)| !is_good).map_or(Ok(()), |(name, _)| Err(*name))
    }

    /// The shape of its opening: round where it is wide open, its blades where they close.
    pub fn shape(&self, f_number: f32) -> LensShape {
        match self.blades {
            Some(count) if f_number > self.f_numbers[0] * 1.05 => {
                LensShape::Blades { count, rotation_deg: 0.0, roundness: 0.2 }
            }
            _ => LensShape::Disc,
        }
    }

    /// How the command line calls it: small letters, digits and dashes.
    pub fn id(&self) -> String {
        let plain = self.name.to_lowercase().replace(" mm", "").replace("f/", "f");
        let words = plain.split(|c: char| !(c.is_alphanumeric() || c == '.')).filter(|word| !word.is_empty());
        words.collect::<Vec<_>>().join("-")
    }
}

/// The published ones, then those that lie as TOML files in the person's folder; and why some of those cannot be used.
pub fn all() -> (Vec<KnownLens>, Vec<LensFileError>) {
    let mut lenses = published();
    let (mut own, mut errors) = (Vec::new(), Vec::new());
    for path in own_files() {
        match KnownLens::read(&path) {
            Ok(lens) => own.push(lens),
            Err(error) => errors.push(error),
        }
    }
    lenses.extend(own);
    (lenses, errors)
}

/// The published ones.
pub fn published() -> Vec<KnownLens> {
    PUBLISHED.iter().map(of_data).collect()
}

fn of_data((name, focal_mm, f_numbers, blades, nearest_m): &(&str, f32, [f32; 2], u8, f32)) -> KnownLens {
    KnownLens {
        name: (*name).to_owned(),
        focal_mm: *focal_mm,
        f_numbers: *f_numbers,
        blades: Some(*blades),
        nearest_m: Some(*nearest_m),
    }
}

/// Where a person's own lenses lie; none where the system has no such place.
pub fn own_folder() -> Option<PathBuf> {
    ProjectDirs::from("", "", "plenoscope").map(|dirs| dirs.config_dir().join("lenses"))
}

/// TOML files of the person's folder of lenses, by name.
fn own_files() -> Vec<PathBuf> {
    let Some(folder) = own_folder() else { return Vec::new() };
    let files = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let is_toml = |path: &PathBuf| path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml"));
    let mut files: Vec<PathBuf> = files.map(|file| file.path()).filter(is_toml).take(MOST_FILES).collect();
    files.sort();
    files
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &[u8]) -> Result<KnownLens, String> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("lens.toml");
        std::fs::write(&path, text).unwrap();
        KnownLens::read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn a_lens_of_ones_own_is_read() {
        let lens = read(b"name = \"Biotar\"\nfocal_mm = 75\nf_numbers = [1.5, 16]\nblades = 10\n").unwrap();
        assert_eq!((lens.focal_mm, lens.f_numbers, lens.nearest_m), (75.0, [1.5, 16.0], None));
        assert_eq!(lens.shape(1.5), LensShape::Disc);
        assert!(matches!(lens.shape(4.0), LensShape::Blades { count: 10, .. }));
    }

    #[test]
    fn nonsense_is_one_sentence() {
        let whole = "name = \"x\"\nfocal_mm = 50\nf_numbers = [2, 16]\n";
        let with = |line: &str| format!("{whole}{line}").into_bytes();
        let wrong: Vec<(Vec<u8>, &str)> = vec![
            (b"name = ".to_vec(), "string"),
            (b"\xff\xfe\x00".to_vec(), "UTF-8"),
            (b"name = \"x\"".to_vec(), "focal_mm"),
            (whole.replace("50", "0").into(), "focal_mm"),
            (whole.replace("50", "nan").into(), "focal_mm"),
            (whole.replace("[2, 16]", "[16, 2]").into(), "f_numbers"),
            (whole.replace("\"x\"", "\"\"").into(), "name"),
            (with("blades = 200"), "blades"),
            (with("nearest_m = -1"), "nearest_m"),
            (with("nearest_m = inf"), "nearest_m"),
            (whole.replace("\"x\"", r#""\u001b[2Jx""#).into(), "name"),
            (with("sparkle = 3"), "sparkle"),
            (with(&"#".repeat(70_000)), "too large"),
        ];
        for (text, why) in wrong {
            let said = read(&text).unwrap_err();
            assert!(said.contains(why) && said.matches(" — ").count() == 2 && !said.contains('\n'), "{why}: {said}");
        }
    }

    #[test]
    fn the_published_ones_can_be_told_apart() {
        let mut ids: Vec<_> = published().iter().map(KnownLens::id).collect();
        assert!(ids.contains(&"helios-44-2-58-f2".to_owned()), "{ids:?}");
        assert!(published().iter().all(|lens| lens.check().is_ok()));
        ids.sort();
        ids.dedup();
        assert_eq!(ids.len(), PUBLISHED.len());
    }
}
