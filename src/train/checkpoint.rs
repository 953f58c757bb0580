//! Checkpoints: weights, moments and where the run stands, in one `.safetensors` file (a JSON header, then raw arrays).

use std::collections::BTreeMap;
use std::path::Path;

use half::f16;
use serde::{Deserialize, Serialize};

use crate::TrainError;
use crate::files;
use crate::nets::{Arch, Bytes, Tensor32, Weights};
use crate::optimizer::AdamW;

/// Where a run stands. Data and seeds are functions of the step, so that this is all a run needs to go on exactly.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Steps done.
    pub step: u64,
    /// Samples seen.
    pub samples: u64,
    /// Seconds of training so far.
    pub secs: f64,
}

/// A net in training.
#[derive(Clone, Debug, PartialEq)]
pub struct Checkpoint {
    /// Which net.
    pub arch: Arch,
    /// Its weights.
    pub weights: Weights,
    /// The optimiser's state.
    pub adam: AdamW,
    /// Running average of the weights and of their statistics, where one is kept: it knows more than the weights of
    /// any one step.
    pub average: Option<Weights>,
    /// Where the run stands.
    pub progress: Progress,
}

#[derive(Serialize, Deserialize)]
struct Entry {
    dtype: String,
    shape: Vec<usize>,
    data_offsets: [usize; 2],
}

/// A `.safetensors` file in memory.
struct Arrays<'a> {
    header: serde_json::Value,
    data: &'a [u8],
}

impl<'a> Arrays<'a> {
    fn of(bytes: &'a [u8]) -> Option<Self> {
        let length = usize::try_from(u64::from_le_bytes(bytes.get(..8)?.try_into().ok()?)).ok()?;
        let header = serde_json::from_slice(bytes.get(8..length.checked_add(8)?)?).ok()?;
        Some(Self { header, data: bytes.get(8 + length..)? })
    }

    fn read(&self, name: &str) -> Option<Vec<f32>> {
        let entry: Entry = serde_json::from_value(self.header.get(name)?.clone()).ok()?;
        let raw = self.data.get(entry.data_offsets[0]..entry.data_offsets[1])?;
        Some(match entry.dtype.as_str() {
            "F32" => raw.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
            "BF16" => {
                raw.chunks_exact(2).map(|b| f32::from_bits(u32::from(u16::from_le_bytes([b[0], b[1]])) << 16)).collect()
            }
            "F16" => raw.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect(),
            "I8" => {
                let values = raw.iter().map(|b| *b as i8).collect();
                Bytes { values, steps: self.read(&steps_of(name))? }.floats()
            }
            _ => return None,
        })
    }
}

/// The array of the steps of one that is kept in 8 bits.
fn steps_of(name: &str) -> String {
    format!("{name}.steps")
}

/// How moments are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moments {
    /// As they are: the run goes on exactly.
    Exact,
    /// As bf16: the run goes on to within rounding.
    Half,
    /// Not at all, and of the weights their average, convolutions in 8 bits: a sixteenth of the file. A run goes on from it, its
    /// moments anew.
    Without,
}

impl Checkpoint {
    /// A net at the start of a run.
    pub fn new(arch: Arch, seed: u64) -> Self {
        let weights = Weights::random(&arch.graph(), seed);
        Self { arch, adam: AdamW::new(&weights), weights, average: None, progress: Progress::default() }
    }

    /// A run's start from this net: as `arch` where that holds this net, else as it is.
    pub fn begin(&self, arch: Arch, seed: u64) -> Self {
        let grown = self.best().grown(&arch.graph(), seed).map(|weights| (arch, weights));
        let (arch, weights) = grown.unwrap_or_else(|| (self.arch, self.best().clone()));
        Self { arch, adam: AdamW::new(&weights), weights, average: None, progress: Progress::default() }
    }

    /// The weights to be used: their average, where one is kept.
    pub fn best(&self) -> &Weights {
        self.average.as_ref().unwrap_or(&self.weights)
    }

    /// Takes the weights of a step into the average, which keeps `part` of itself; fewer while it is young.
    pub fn follow(&mut self, part: f32) {
        if part <= 0.0 {
            return;
        }
        let Some(average) = &mut self.average else {
            self.average = Some(self.weights.clone());
            return;
        };
        let young = (1 + self.progress.step) as f32 / (10 + self.progress.step) as f32;
        average.approach(&self.weights, 1.0 - part.min(young));
    }

    /// The mean of nets of one architecture: of the ends of runs that went on from one another, it knows more than any of
    /// them (Izmailov et al. 2018). It has no average of its own and no moments.
    pub fn mean(nets: Vec<Self>) -> Result<Self, TrainError> {
        let Some(first) = nets.first() else { return Err(TrainError::Missing { name: "checkpoint".into() }) };
        let mut mean = Self { weights: first.best().clone(), ..Self::new(first.arch, 0) };
        mean.progress = first.progress.clone();
        for (i, net) in nets.iter().enumerate().skip(1) {
            if net.arch != mean.arch {
                return Err(TrainError::Architecture { wanted: mean.arch.name() });
            }
            mean.weights.approach(net.best(), 1.0 / (i + 1) as f32);
        }
        Ok(mean)
    }

    /// Writes the file aside, then renames it: an earlier checkpoint stays whole if this fails.
    pub fn save(&self, path: &Path, moments: Moments) -> Result<(), TrainError> {
        files::write(path, &self.encode(moments), "write the checkpoint")
    }

    /// Reads a file that [`save`](Self::save) wrote.
    pub fn load(path: &Path) -> Result<Self, TrainError> {
        let bytes = std::fs::read(path).map_err(|source| TrainError::File {
            action: "read the checkpoint",
            source,
            path: path.to_owned(),
        })?;
        let checkpoint = Self::decode(&bytes).ok_or_else(|| TrainError::Checkpoint {
            why: "its header or its arrays are damaged".into(),
            path: path.to_owned(),
        })?;
        checkpoint.weights.check(&checkpoint.arch.graph())?;
        Ok(checkpoint)
    }

    /// Takes the encoder's weights from a file of others, which holds them under the same names.
    ///
    /// # Errors
    /// A net without an encoder, a file that cannot be read, an array that it lacks.
    pub fn take_encoder(&mut self, path: &Path) -> Result<(), TrainError> {
        let failed = |source| TrainError::File { action: "read the encoder", source, path: path.to_owned() };
        let bytes = std::fs::read(path).map_err(failed)?;
        let refused = |why: String| TrainError::Encoder { why, path: path.to_owned() };
        let arrays = Arrays::of(&bytes).ok_or_else(|| refused("its header is damaged".into()))?;
        let mut own = self.weights.tensors.iter_mut().filter(|tensor| tensor.is_of_encoder()).peekable();
        if own.peek().is_none() {
            return Err(refused(format!("{} has no encoder to take it; --net context-lite has", self.arch.name())));
        }
        for tensor in own {
            let values = arrays.read(&tensor.name);
            let taken = values.and_then(|values| load_into(tensor, values));
            taken.ok_or_else(|| refused(format!("its {} is missing or of another size", tensor.name)))?;
        }
        Ok(())
    }

    fn encode(&self, moments: Moments) -> Vec<u8> {
        let (mut header, mut data) = (BTreeMap::new(), Vec::new());
        let mut put = |name: String, shape: &[usize], values: &[f32], dtype: &str| {
            let start = data.len();
            for v in values {
                match dtype {
                    // Round to nearest: bf16 is the upper half of an f32.
                    "BF16" => data.extend((((v.to_bits() + 0x8000) >> 16) as u16).to_le_bytes()),
                    "I8" => data.push(*v as i8 as u8),
                    _ => data.extend(v.to_le_bytes()),
                }
            }
            let dtype = dtype.to_owned();
            header.insert(
                name,
                serde_json::json!(Entry { dtype, shape: shape.to_vec(), data_offsets: [start, data.len()] }),
            );
        };
        let all = moments != Moments::Without;
        let weights = if all { &self.weights } else { self.best() };
        for tensor in self.average.iter().filter(|_| all).flat_map(|average| &average.tensors) {
            put(format!("average.{}", tensor.name), &tensor.shape, &tensor.values, "F32");
        }
        for (i, tensor) in weights.tensors.iter().enumerate() {
            if !all && tensor.shape.len() > 1 {
                // As the exported file has them.
                let bytes = Bytes::of(&tensor.values, tensor.shape[0]);
                let values: Vec<f32> = bytes.values.iter().map(|v| f32::from(*v)).collect();
                put(tensor.name.clone(), &tensor.shape, &values, "I8");
                put(steps_of(&tensor.name), &tensor.shape[..1], &bytes.steps, "F32");
                continue;
            }
            put(tensor.name.clone(), &tensor.shape, &tensor.values, "F32");
            if tensor.trained && all {
                for (which, moment) in [("first", &self.adam.first[i]), ("second", &self.adam.second[i])] {
                    let name = format!("adam.{which}.{}", tensor.name);
                    put(name, &tensor.shape, moment, if moments == Moments::Half { "BF16" } else { "F32" });
                }
            }
        }
        let text = |value: serde_json::Value| serde_json::Value::String(value.to_string());
        let metadata = serde_json::json!({
            "arch": self.arch.name(),
            "progress": text(serde_json::json!(self.progress)),
            "adam_steps": text(serde_json::json!(self.adam.steps)),
            "moments": if all { "all" } else { "none" },
            "average": if all && self.average.is_some() { "kept" } else { "none" },
        });
        header.insert("__metadata__".to_owned(), metadata);
        let header = serde_json::json!(header).to_string();
        let mut file = (header.len() as u64).to_le_bytes().to_vec();
        file.extend(header.as_bytes());
        file.extend(data);
        file
    }

    fn decode(bytes: &[u8]) -> Option<Self> {
        let arrays = Arrays::of(bytes)?;
        let metadata = arrays.header.get("__metadata__")?;
        let text = |key: &str| metadata.get(key)?.as_str();
        let arch: Arch = serde_json::from_value(metadata.get("arch")?.clone()).ok()?;
        let read = |name: &str| arrays.read(name);
        let mut weights = Weights::random(&arch.graph(), 0);
        let mut adam = AdamW::new(&weights);
        let with_moments = text("moments") != Some("none");
        let mut average = (text("average") == Some("kept")).then(|| weights.clone());
        for tensor in average.iter_mut().flat_map(|average| &mut average.tensors) {
            let values = read(&format!("average.{}", tensor.name))?;
            load_into(tensor, values)?;
        }
        for (i, tensor) in weights.tensors.iter_mut().enumerate() {
            load_into(tensor, read(&tensor.name)?)?;
            if tensor.trained && with_moments {
                let fits = |v: &Vec<f32>| v.len() == tensor.values.len();
                let moment = |which: &str| read(&format!("adam.{which}.{}", tensor.name)).filter(fits);
                (adam.first[i], adam.second[i]) = (moment("first")?, moment("second")?);
            }
        }
        if with_moments {
            adam.steps = serde_json::from_str(text("adam_steps")?).ok()?;
        }
        Some(Self { arch, weights, adam, average, progress: serde_json::from_str(text("progress")?).ok()? })
    }
}

fn load_into(tensor: &mut Tensor32, values: Vec<f32>) -> Option<()> {
    if values.len() != tensor.values.len() {
        return None;
    }
    tensor.values = values;
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights as a small file keeps them.
    fn in_bytes(weights: &Weights) -> Weights {
        let mut kept = weights.clone();
        for tensor in kept.tensors.iter_mut().filter(|tensor| tensor.shape.len() > 1) {
            let most = tensor.values.iter().fold(0.0f32, |most, v| most.max(v.abs()));
            let floats = Bytes::of(&tensor.values, tensor.shape[0]).floats();
            assert!(floats.iter().zip(&tensor.values).all(|(a, b)| (a - b).abs() <= most / 250.0), "{}", tensor.name);
            tensor.values = floats;
        }
        kept
    }

    #[test]
    fn a_checkpoint_survives_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.safetensors");
        let mut checkpoint = Checkpoint::new(Arch::Tiny, 3);
        checkpoint.progress = Progress { step: 17, samples: 68, secs: 1.25 };
        checkpoint.adam.first[0][0] = 0.125;
        checkpoint.save(&path, Moments::Exact).unwrap();
        assert_eq!(Checkpoint::load(&path).unwrap(), checkpoint);
        checkpoint.save(&path, Moments::Half).unwrap();
        assert_eq!(Checkpoint::load(&path).unwrap().adam.first[0][0], 0.125);
        checkpoint.save(&path, Moments::Without).unwrap();
        let loaded = Checkpoint::load(&path).unwrap();
        assert_eq!((&loaded.weights, loaded.adam), (&in_bytes(&checkpoint.weights), AdamW::new(&checkpoint.weights)));
    }

    #[test]
    fn a_run_begins_as_the_larger_net_that_is_asked_for_if_that_holds_its_start() {
        let mut small = Checkpoint::new(Arch::Tiny, 3);
        small.progress.step = 17;
        let larger = small.begin(Arch::TinyDeep, 4);
        assert_eq!((larger.arch, larger.progress.step), (Arch::TinyDeep, 0));
        for arch in [Arch::Tiny, Arch::Paper, Arch::Context] {
            let same = small.begin(arch, 4);
            assert_eq!((same.arch, &same.weights), (Arch::Tiny, &small.weights), "{arch:?} holds no other net");
        }
        assert_eq!(larger.begin(Arch::Tiny, 4).arch, Arch::TinyDeep, "a net never shrinks");
    }

    #[test]
    fn an_encoder_is_taken_from_a_file_of_others_and_nothing_else_is() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lite.safetensors");
        let (theirs, own) = (Checkpoint::new(Arch::TinyLite, 3), Checkpoint::new(Arch::TinyLite, 4));
        theirs.save(&path, Moments::Exact).unwrap();
        let mut taken = own.clone();
        taken.take_encoder(&path).unwrap();
        for ((array, theirs), own) in
            taken.weights.tensors.iter().zip(&theirs.weights.tensors).zip(&own.weights.tensors)
        {
            assert_eq!(array, if array.is_of_encoder() { theirs } else { own });
        }
        let refused = |mut net: Checkpoint, path: &Path| net.take_encoder(path).unwrap_err().to_string();
        assert!(refused(Checkpoint::new(Arch::TinyDeep, 3), &path).contains("context-lite"));
        Checkpoint::new(Arch::Tiny, 3).save(&path, Moments::Exact).unwrap();
        assert!(refused(own.clone(), &path).contains("lite.stem.weight is missing"), "{}", refused(own.clone(), &path));
        std::fs::write(&path, b"no arrays").unwrap();
        assert!(refused(own.clone(), &path).contains("damaged"));
        assert!(refused(own, &folder.path().join("none")).contains("read the encoder"));
    }

    #[test]
    fn the_average_lags_behind_the_weights_and_is_what_a_small_file_holds() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.safetensors");
        let mut checkpoint = Checkpoint::new(Arch::Tiny, 3);
        checkpoint.follow(0.0);
        assert_eq!(checkpoint.best(), &checkpoint.weights);
        checkpoint.progress.step = 1_000_000;
        for value in [0.0, 1.0] {
            checkpoint.weights.tensors[0].values[0] = value;
            checkpoint.follow(0.75);
        }
        assert_eq!(checkpoint.best().tensors[0].values[0], 0.25);
        checkpoint.save(&path, Moments::Exact).unwrap();
        assert_eq!(Checkpoint::load(&path).unwrap(), checkpoint);
        checkpoint.save(&path, Moments::Without).unwrap();
        assert_eq!(Checkpoint::load(&path).unwrap().weights, in_bytes(checkpoint.best()));
    }

    #[test]
    fn the_mean_of_nets_is_that_of_their_averages_and_of_one_architecture() {
        let net = |value: f32| {
            let mut net = Checkpoint::new(Arch::Tiny, 3);
            net.weights.tensors[0].values[0] = value;
            net
        };
        let averaged = Checkpoint { average: Some(net(5.0).weights), ..net(100.0) };
        let mean = Checkpoint::mean(vec![net(1.0), net(3.0), averaged]).unwrap();
        assert!((mean.weights.tensors[0].values[0] - 3.0).abs() < 1e-5);
        assert_eq!(mean.weights.tensors[1], net(0.0).weights.tensors[1]);
        let error = Checkpoint::mean(vec![net(1.0), Checkpoint::new(Arch::Occlusion, 3)]).unwrap_err().to_string();
        assert!(error.contains("tiny"), "{error}");
    }

    #[test]
    fn a_damaged_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.safetensors");
        Checkpoint::new(Arch::Tiny, 3).save(&path, Moments::Exact).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        for length in [0, 7, 100, bytes.len() - 1] {
            std::fs::write(&path, &bytes[..length]).unwrap();
            assert!(Checkpoint::load(&path).unwrap_err().to_string().contains("not a checkpoint"));
        }
    }
}
