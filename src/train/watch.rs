//! Whether a run still learns what holds elsewhere: the order of depth on pictures that it trains on, beside that on
//! pictures that it never sees.

use serde_json::{Value, json};

use crate::TrainError;
use crate::batch::Batch;
use crate::checkpoint::Checkpoint;
use crate::config::Config;
use crate::eval::metrics::{mean, spearman};
use crate::scenes::Kind;
use crate::step::infer_depths;

/// By how much the two sides may part from where they were nearest.
const PARTED: f32 = 0.04;

/// Kinds that are watched: photos with a map, and scenes in three dimensions.
pub const KINDS: [Kind; 2] = [Kind::Pseudo, Kind::Solid];

/// Fixed pictures of both sides.
pub struct Watch {
    /// By kind: what is trained on, what is not.
    sides: Vec<(Kind, [Vec<Batch>; 2])>,
    least: Vec<f32>,
}

impl Watch {
    /// Watches these batches.
    pub fn new(sides: Vec<(Kind, [Vec<Batch>; 2])>) -> Self {
        let least = vec![f32::INFINITY; sides.len()];
        Self { sides, least }
    }

    /// Mean Spearman of each side, and a sentence for each kind whose sides part.
    ///
    /// # Errors
    /// What the net says.
    pub fn look(&mut self, net: &Checkpoint, config: &Config) -> Result<(Value, Vec<String>), TrainError> {
        let (mut found, mut warnings) = (serde_json::Map::new(), Vec::new());
        for ((kind, sides), least) in self.sides.iter().zip(&mut self.least) {
            let mut means = [0.0f32; 2];
            for (mean, batches) in means.iter_mut().zip(sides) {
                *mean = order_of(net, batches, config)?;
            }
            let [seen, unseen] = means;
            *least = least.min(seen - unseen);
            if seen - unseen > *least + PARTED {
                warnings.push(format!(
                    "training and validation part on {kind:?} pictures: Spearman {seen:.3} against {unseen:.3}, {:.3} \
                     more than at best — it learns its pictures by heart; stop, or give it others",
                    seen - unseen - *least
                ));
            }
            found.insert(format!("{kind:?}").to_lowercase(), json!({"train": seen, "val": unseen}));
        }
        Ok((Value::Object(found), warnings))
    }
}

/// Mean Spearman of the reference views' ray depths with the truth.
fn order_of(net: &Checkpoint, batches: &[Batch], config: &Config) -> Result<f32, TrainError> {
    let mut figures = Vec::new();
    for batch in batches {
        let depth = infer_depths(net.best(), &net.arch.graph(), batch, config)?;
        let (plane, all) = (batch.maps.plane(), batch.maps.plane() * batch.maps.views.len());
        let here = batch.maps.reference() * plane..(batch.maps.reference() + 1) * plane;
        for (depth, truth) in depth.chunks(all).zip(batch.truth.chunks(all)) {
            let pairs = depth[here.clone()].iter().zip(&truth[here.clone()]).filter(|(_, t)| t.is_finite());
            let (depth, truth): (Vec<f32>, Vec<f32>) = pairs.unzip();
            figures.push(spearman(&depth, &truth));
        }
    }
    Ok(mean(figures.into_iter()).unwrap_or(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::batch::tests::toy;
    use crate::nets::Arch;

    #[test]
    fn both_sides_are_told_and_a_warning_where_they_part() {
        let draw = toy(2, (16, 8));
        let batches = || vec![draw(0).unwrap()];
        let config = Config { net: Arch::Tiny, ..Config::default() };
        let net = Checkpoint::new(Arch::Tiny, 1);
        let mut watch = Watch::new(vec![(Kind::Solid, [batches(), batches()])]);
        let (found, warnings) = watch.look(&net, &config).unwrap();
        assert_eq!(found["solid"]["train"], found["solid"]["val"]);
        assert!(warnings.is_empty());
        watch.least[0] = -0.1;
        let (_, warnings) = watch.look(&net, &config).unwrap();
        assert!(warnings[0].contains("training and validation part"), "{warnings:?}");
    }
}
