//! From a checkpoint to `model.onnx` and `manifest.toml`, checked by reading the file back.

mod onnx;
mod verify;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use plenoscope::synth::corners::{COLOUR_FILE, RANGE_PX as CORNER_RANGE_PX};
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
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    data_files: BTreeMap<&'a str, String>,
}

/// Largest difference between the exported and the trained net that is accepted: px for a depth net, units of −1 … 1
/// for the occlusion net. Weights of 16 bits are rounded by a 4,000th.
pub fn tolerance(arch: Arch, bits: Bits) -> f32 {
    let exact = if arch == Arch::Occlusion { 1e-5 } else { 1e-4 };
    match bits {
        Bits::ThirtyTwo => exact,
        Bits::Sixteen => 20.0 * exact,
        Bits::Eight => 1000.0 * exact,
    }
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

/// Checkpoints of one net become their mean, and those of the two nets of four corners the mean of each: the colour net comes
/// second.
///
/// # Errors
/// Nets that do not belong together.
pub fn parted(nets: Vec<Checkpoint>) -> Result<(Checkpoint, Option<Checkpoint>), TrainError> {
    let (colours, nets): (Vec<_>, Vec<_>) = nets.into_iter().partition(|net| net.arch == Arch::CornerColour);
    if nets.is_empty() {
        return Err(TrainError::HalfOfTwo);
    }
    let colour = if colours.is_empty() { None } else { Some(Checkpoint::mean(colours)?) };
    let net = Checkpoint::mean(nets)?;
    if colour.is_some() != (net.arch == Arch::CornerDisparity) {
        return Err(TrainError::HalfOfTwo);
    }
    Ok((net, colour))
}

/// Writes `models/<id>/model.onnx` and `manifest.toml`, and of the nets of four corners the colour net beside them. The files are
/// read back with tract and compared with the trained nets first; nothing is written if they differ. Returns the folder and the
/// largest difference found.
pub fn export(
    net: &Checkpoint,
    colour: Option<&Checkpoint>,
    about: &About,
    models: &Path,
) -> Result<(PathBuf, f32), TrainError> {
    if !matches!(net.arch.task(), Task::Depth | Task::Occlusion | Task::CornerDepth) {
        return Err(TrainError::NotUsable { arch: net.arch.name() });
    }
    let folder = models.join(&about.id);
    let (bytes, found) = checked(net, about, &folder.join("model.onnx"))?;
    let colour = colour.map(|colour| checked(colour, about, &folder.join(COLOUR_FILE))).transpose()?;
    let failed = |source| TrainError::File { action: "write the model", source, path: folder.clone() };
    std::fs::create_dir_all(&folder).map_err(failed)?;
    files::write(&folder.join("model.onnx"), &bytes, "write the model")?;
    if let Some((bytes, _)) = &colour {
        files::write(&folder.join(COLOUR_FILE), bytes, "write the model")?;
    }
    let data_files = colour.iter().map(|(bytes, _)| (COLOUR_FILE, sha256(bytes))).collect();
    let text = manifest(net, about, sha256(&bytes), data_files)?;
    files::write(&folder.join("manifest.toml"), text.as_bytes(), "write the manifest")?;
    Ok((folder, colour.map_or(found, |(_, other)| found.max(other))))
}

/// The file of a net, and by how much it differs from the trained one.
fn checked(net: &Checkpoint, about: &About, path: &Path) -> Result<(Vec<u8>, f32), TrainError> {
    let bytes = encode(&net.arch.graph(), net.best(), about.bits)?;
    let found = difference(net, &bytes, 64)?;
    let accepted = tolerance(net.arch, about.bits);
    if found.is_nan() || found > accepted {
        return Err(TrainError::Export { difference: found, tolerance: accepted, path: path.to_owned() });
    }
    Ok((bytes, found))
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

fn manifest(
    net: &Checkpoint,
    about: &About,
    sha256: String,
    data_files: BTreeMap<&str, String>,
) -> Result<String, TrainError> {
    let task = net.arch.task();
    let range_px = if task == Task::CornerDepth { CORNER_RANGE_PX } else { RANGE_PX };
    let manifest = Manifest {
        id: &about.id,
        task: match task {
            Task::Occlusion => "occlusion",
            Task::CornerDepth => "corners",
            _ => "ray-depth",
        },
        file: "model.onnx",
        sha256,
        licence: &about.licence,
        training_data: &about.training_data,
        views: [SIDE, SIDE],
        inputs: (task == Task::Depth).then_some(net.arch.inputs()),
        working_long_side: about.working_long_side,
        multiple_of: net.arch.graph().multiple_of,
        disparity_range_px: [-range_px, range_px],
        data_files,
    };
    toml::to_string(&manifest).map_err(|e| TrainError::Data { why: e.to_string() })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use plenoscope::field::View;
    use plenoscope::job::{Cancel, Job};
    use plenoscope::synth::ModelSource;
    use plenoscope::synth::corners::{CORNERS, CornerNets};

    use super::*;
    use crate::batch::Batch;
    use crate::config::Config;
    use crate::corners;
    use crate::loss::Maps;
    use crate::nets::VIEWS;
    use crate::rng::Rng;
    use crate::scenes::steps;

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
    fn weights_of_fewer_bits_are_a_smaller_file_and_nearly_the_same_net() {
        let folder = tempfile::tempdir().unwrap();
        let net = lived_in(Arch::Tiny);
        let written = |bits| {
            let (path, found) = export(&net, None, &about("tiny", bits), folder.path()).unwrap();
            (std::fs::metadata(path.join("model.onnx")).unwrap().len(), found)
        };
        let [(whole, _), (half, found), (quarter, farther)] =
            [Bits::ThirtyTwo, Bits::Sixteen, Bits::Eight].map(written);
        assert!(half * 2 < whole + 12_000, "{half} of {whole} bytes");
        assert!(found > 0.0 && found < 0.002, "{found}");
        // Three of four bytes of each weight go; a step a channel and a node a convolution come.
        let convolutions = net.weights.tensors.iter().filter(|tensor| tensor.shape.len() > 1);
        let weights = convolutions.map(|tensor| tensor.values.len() as u64).sum::<u64>();
        assert!(whole - quarter > 3 * weights * 9 / 10, "{whole} − {quarter} bytes of {weights} weights");
        assert!(farther > found && farther < 0.1, "{farther}");
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
            let text = export(&net, None, &about, folder.path()).unwrap_err().to_string();
            assert!(text.contains(&arch.name()) && text.contains("ray depths"), "{text}");
            let found = difference(&net, &encode(&arch.graph(), net.best(), about.bits).unwrap(), 20).unwrap();
            assert!(found <= 4.0 * tolerance(arch, about.bits), "{found}");
        }
    }

    #[test]
    fn exported_nets_compute_what_the_trained_ones_do() {
        let folder = tempfile::tempdir().unwrap();
        for (arch, id) in
            [(Arch::Tiny, "tiny"), (Arch::TinyDeep, "deep"), (Arch::TinyLite, "lite"), (Arch::Occlusion, "occlusion")]
        {
            let about = about(id, Bits::ThirtyTwo);
            let (path, found) = export(&lived_in(arch), None, &about, folder.path()).unwrap();
            assert!(found <= tolerance(arch, about.bits), "{found}");
            let text = std::fs::read_to_string(path.join("manifest.toml")).unwrap();
            assert!(text.contains("sha256") && text.contains(&format!("id = \"{id}\"")), "{text}");
        }
    }

    #[test]
    fn nets_of_four_corners_make_the_same_views_in_the_program() {
        let folder = tempfile::tempdir().unwrap();
        let nets = [lived_in(Arch::CornerDisparity), lived_in(Arch::CornerColour)];
        let (net, colour) = parted(nets.to_vec()).unwrap();
        let (path, _) = export(&net, colour.as_ref(), &about("four", Bits::ThirtyTwo), folder.path()).unwrap();
        assert!(path.join(COLOUR_FILE).exists());
        let models = [ModelSource::Folder(folder.path().to_owned())];
        let batch = textured([24, 16]);
        let (views, depths) = corners::infer(nets.each_ref(), &batch, &Config::default()).unwrap();
        let given = CORNERS.map(|layer| Arc::new(view(&batch, layer)));
        let cancel = Cancel::default();
        let ours = CornerNets::named("four", &models, 1).unwrap();
        let (field, rays) = ours.between(&given, &Job { cancel: &cancel, sink: &() }).unwrap();
        let p = batch.maps.plane();
        for layer in 0..VIEWS {
            let made = field.view(field.grid().view_from_layer(layer));
            for (i, pixel) in made.rgba().chunks_exact(4).enumerate() {
                for (c, byte) in pixel[..3].iter().enumerate() {
                    let off = (f32::from(*byte) / 255.0 - views[(layer * 3 + c) * p + i]).abs();
                    assert!(off < 0.6 / 255.0, "view {layer}, pixel {i}: {off}");
                }
            }
        }
        assert!(rays.disparity_px().iter().zip(&depths).all(|(a, b)| (a - b).abs() < 1e-3));

        std::fs::write(path.join(COLOUR_FILE), b"another").unwrap();
        let said = CornerNets::named("four", &models, 1).err().unwrap().to_string();
        assert!(said.contains("checksum") && said.contains(COLOUR_FILE), "{said}");
        let said = CornerNets::named("five", &models, 1).err().unwrap().to_string();
        assert!(said.contains("known are four"), "{said}");
    }

    #[test]
    fn one_net_of_four_corners_without_the_other_is_refused() {
        for nets in [vec![Arch::CornerDisparity], vec![Arch::CornerColour], vec![Arch::Tiny, Arch::CornerColour]] {
            let told = parted(nets.into_iter().map(lived_in).collect()).err().unwrap().to_string();
            assert!(told.contains("corner-colour.safetensors"), "{told}");
        }
    }

    /// All views of a textured plane, in steps of 8 bits.
    fn textured([width, height]: [usize; 2]) -> Batch {
        let maps = Maps { samples: 1, views: (0..VIEWS).collect(), height, width };
        let value = |x: f32, y: f32| 0.5 + 0.25 * (0.9 * x).sin() + 0.2 * (1.1 * y + 0.5 * x).cos();
        let of = |layer: usize| {
            let ((u, v), p) = (steps(layer), width * height);
            (0..3 * p).map(move |i| {
                let (x, y) = ((i % p % width) as f32, (i % p / width) as f32);
                (value(x + 0.4 * u, y + 0.4 * v) * 255.0).round() / 255.0
            })
        };
        Batch {
            first_sample: 0,
            views: (0..VIEWS).flat_map(of).collect(),
            truth: vec![f32::NAN; maps.len()],
            yx: vec![[-1.0, 1.0, -1.0, 1.0]],
            worth: vec![1.0],
            subjects: vec![Vec::new()],
            maps,
        }
    }

    fn view(batch: &Batch, layer: usize) -> View {
        let p = batch.maps.plane();
        let byte = |i: usize, c: usize| (batch.views[(layer * 3 + c) * p + i] * 255.0).round() as u8;
        let rgba = (0..p).flat_map(|i| [byte(i, 0), byte(i, 1), byte(i, 2), 255]).collect();
        View::new([batch.maps.width as u32, batch.maps.height as u32], rgba).unwrap()
    }
}
