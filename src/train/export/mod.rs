//! From a checkpoint to `model.onnx` and `manifest.toml`, checked by reading the file back.

mod onnx;
mod verify;

use std::path::{Path, PathBuf};

use serde::Serialize;
use sha2::{Digest as _, Sha256};

use crate::TrainError;
use crate::checkpoint::Checkpoint;
use crate::files;
use crate::nets::{Arch, RANGE_PX, SIDE, Task};

pub use onnx::{Bits, encode};
pub use verify::difference;

/// What the manifest says beside what the net itself knows.
#[derive(Clone, Debug)]
pub struct About {
    /// Name of the model and of its folder.
    pub id: String,
    /// Licence of the weights.
    pub licence: String,
    /// What it was trained on.
    pub training_data: Vec<String>,
    /// Long side in px at which it works best.
    pub working_long_side: usize,
    /// What its weights are kept in.
    pub bits: Bits,
}

/// `manifest.toml`, in the order it is read.
#[derive(Serialize)]
struct Manifest<'a> {
    id: &'a str,
    task: &'a str,
    file: &'a str,
    sha256: String,
    licence: &'a str,
    training_data: &'a [String],
    views: [usize; 2],
    #[serde(skip_serializing_if = "Option::is_none")]
    inputs: Option<&'a [&'a str]>,
    working_long_side: usize,
    multiple_of: usize,
    disparity_range_px: [f32; 2],
}

/// Largest difference between the exported and the trained net that is accepted: px for a depth net, units of −1 … 1
/// for the occlusion net. Weights of 16 bits are rounded by a 4,000th.
pub fn tolerance(arch: Arch, bits: Bits) -> f32 {
    let exact = if arch == Arch::Occlusion { 1e-5 } else { 1e-4 };
    if bits == Bits::Sixteen { 20.0 * exact } else { exact }
}

/// Reads a factor of ray depths, as `--gain` is written.
pub fn gain(text: &str) -> Result<f32, String> {
    let factor = text.parse().ok().filter(|factor: &f32| factor.is_finite() && *factor > 0.0);
    factor.ok_or_else(|| "expected a number above 0, 1 for ray depths as they are".to_owned())
}

/// Multiplies a depth net's ray depths.
pub fn amplify(net: &mut Checkpoint, gain: f32) -> Result<(), TrainError> {
    if net.arch.task() != Task::Depth && gain != 1.0 {
        return Err(TrainError::NoRayDepths { arch: net.arch.name() });
    }
    net.weights.amplify(gain);
    Ok(())
}

/// Writes `models/<id>/model.onnx` and `manifest.toml`. The file is read back with tract and compared with the trained
/// net first; nothing is written if they differ. Returns the folder and the largest difference found.
pub fn export(net: &Checkpoint, about: &About, models: &Path) -> Result<(PathBuf, f32), TrainError> {
    if !matches!(net.arch.task(), Task::Depth | Task::Occlusion) {
        return Err(TrainError::NotUsable { arch: net.arch.name() });
    }
    let folder = models.join(&about.id);
    let path = folder.join("model.onnx");
    let bytes = encode(&net.arch.graph(), net.best(), about.bits)?;
    let found = difference(net, &bytes, 64)?;
    let accepted = tolerance(net.arch, about.bits);
    if found.is_nan() || found > accepted {
        return Err(TrainError::Export { difference: found, tolerance: accepted, path });
    }
    let failed = |source| TrainError::File { action: "write the model", source, path: folder.clone() };
    std::fs::create_dir_all(&folder).map_err(failed)?;
    files::write(&path, &bytes, "write the model")?;
    files::write(&folder.join("manifest.toml"), manifest(net, about, &bytes)?.as_bytes(), "write the manifest")?;
    Ok((folder, found))
}

fn manifest(net: &Checkpoint, about: &About, bytes: &[u8]) -> Result<String, TrainError> {
    let occlusion = net.arch == Arch::Occlusion;
    let manifest = Manifest {
        id: &about.id,
        task: if occlusion { "occlusion" } else { "ray-depth" },
        file: "model.onnx",
        sha256: Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect(),
        licence: &about.licence,
        training_data: &about.training_data,
        views: [SIDE, SIDE],
        inputs: (!occlusion).then_some(net.arch.inputs()),
        working_long_side: about.working_long_side,
        multiple_of: net.arch.graph().multiple_of,
        disparity_range_px: [-RANGE_PX, RANGE_PX],
    };
    toml::to_string(&manifest).map_err(|e| TrainError::Data { why: e.to_string() })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rng::Rng;

    /// A net whose normalisation is not the identity.
    fn lived_in(arch: Arch) -> Checkpoint {
        let mut net = Checkpoint::new(arch, 11);
        let mut rng = Rng::new(12, 0);
        for tensor in &mut net.weights.tensors {
            let vector = tensor.shape.len() == 1;
            for v in &mut tensor.values {
                *v += if vector { rng.range(-0.2, 0.2) } else { 0.0 };
            }
        }
        net
    }

    fn about(id: &str, bits: Bits) -> About {
        let training_data = vec!["none".into()];
        About { id: id.into(), licence: "MIT".into(), training_data, working_long_side: 128, bits }
    }

    #[test]
    fn weights_of_sixteen_bits_are_half_the_file_and_nearly_the_same_net() {
        let folder = tempfile::tempdir().unwrap();
        let net = lived_in(Arch::Tiny);
        let written = |bits| {
            let (path, found) = export(&net, &about("tiny", bits), folder.path()).unwrap();
            (std::fs::metadata(path.join("model.onnx")).unwrap().len(), found)
        };
        let [(whole, _), (half, found)] = [Bits::ThirtyTwo, Bits::Sixteen].map(written);
        assert!(half * 2 < whole + 12_000, "{half} of {whole} bytes");
        assert!(found > 0.0 && found < 0.002, "{found}");
    }

    #[test]
    fn a_gain_multiplies_small_ray_depths() {
        let input: Vec<f32> = (0..5 * 16 * 16).map(|i| (i as f32 * 0.37).sin()).collect();
        let depths = |net: &Checkpoint| verify::trained(net, input.clone(), [16, 16]).unwrap();
        let mut net = lived_in(Arch::Tiny);
        amplify(&mut net, 0.1).unwrap();
        let before = depths(&net);
        amplify(&mut net, 1.5).unwrap();
        assert!(before.iter().any(|d| d.abs() > 0.01));
        assert!(
            before
                .iter()
                .zip(depths(&net))
                .all(|(before, after)| (1.5 * before - after).abs() < 0.01 * before.abs() + 1e-6)
        );
    }

    #[test]
    fn a_gain_is_a_positive_number_and_for_ray_depths() {
        assert_eq!(gain("1.12"), Ok(1.12));
        for text in ["0", "-1", "NaN", "inf", "much"] {
            assert!(gain(text).is_err(), "{text}");
        }
        let mut net = lived_in(Arch::Occlusion);
        assert!(amplify(&mut net, 1.0).is_ok());
        assert!(amplify(&mut net, 1.5).unwrap_err().to_string().contains("--gain"));
    }

    #[test]
    fn comparisons_have_no_geometry_to_export_but_their_graphs_can_be_run() {
        let folder = tempfile::tempdir().unwrap();
        for arch in [Arch::AppearanceFlow, Arch::DirectRegression] {
            let net = lived_in(arch);
            let about = about("views", Bits::ThirtyTwo);
            let text = export(&net, &about, folder.path()).unwrap_err().to_string();
            assert!(text.contains(&arch.name()) && text.contains("ray depths"), "{text}");
            let found = difference(&net, &encode(&arch.graph(), net.best(), about.bits).unwrap(), 20).unwrap();
            assert!(found <= 4.0 * tolerance(arch, about.bits), "{found}");
        }
    }

    #[test]
    fn exported_nets_compute_what_the_trained_ones_do() {
        let folder = tempfile::tempdir().unwrap();
        for (arch, id) in [(Arch::Tiny, "tiny"), (Arch::Occlusion, "occlusion")] {
            let about = about(id, Bits::ThirtyTwo);
            let (path, found) = export(&lived_in(arch), &about, folder.path()).unwrap();
            assert!(found <= tolerance(arch, about.bits), "{found}");
            let text = std::fs::read_to_string(path.join("manifest.toml")).unwrap();
            assert!(text.contains("sha256") && text.contains(&format!("id = \"{id}\"")), "{text}");
        }
    }
}
