//! AdamW on a net's arrays.

use rayon::prelude::*;

use crate::nets::Weights;

/// Decay rates of the moments and the guard of the root (Kingma and Ba, and the paper).
const BETA: (f32, f32) = (0.9, 0.999);
const EPSILON: f32 = 1e-8;

/// First and second moments of every trained array, and the number of steps taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AdamW {
    /// Steps taken.
    pub steps: u64,
    /// First moments, by array; empty for arrays that are not trained.
    pub first: Vec<Vec<f32>>,
    /// Second moments.
    pub second: Vec<Vec<f32>>,
}

/// What a step of the optimiser is told.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Learning rate.
    pub lr: f32,
    /// That of an encoder against it.
    pub encoder: f32,
    /// Decoupled decay of convolution weights.
    pub weight_decay: f32,
    /// Largest norm of the whole gradient; 0 = no limit.
    pub clip: f32,
}

impl AdamW {
    /// Zero moments for a net's arrays.
    pub fn new(weights: &Weights) -> Self {
        let zeros = || weights.tensors.iter().map(|t| vec![0.0; if t.trained { t.values.len() } else { 0 }]).collect();
        Self { steps: 0, first: zeros(), second: zeros() }
    }

    /// One step along `gradients` (array, values); returns the gradient's norm before it is clipped.
    pub fn step(&mut self, weights: &mut Weights, gradients: &[(usize, Vec<f32>)], step: Step) -> f32 {
        let squares = |piece: &[f32]| piece.iter().map(|v| f64::from(*v).powi(2)).sum::<f64>();
        // Collected before they are added up, so that the sum does not depend on the threads.
        let pieces: Vec<f64> = gradients.par_iter().flat_map(|(_, g)| g.par_chunks(8192).map(squares)).collect();
        let norm = pieces.iter().sum::<f64>().sqrt() as f32;
        if !norm.is_finite() {
            return norm;
        }
        let scale = if step.clip > 0.0 && norm > step.clip { step.clip / norm } else { 1.0 };
        self.steps += 1;
        let correct = |beta: f32| 1.0 - f64::from(beta).powf(self.steps as f64) as f32;
        let (c1, c2) = (correct(BETA.0), correct(BETA.1));
        for (at, gradient) in gradients {
            let array = &mut weights.tensors[*at];
            let lr = if array.is_of_encoder() { step.encoder * step.lr } else { step.lr };
            let decay = if array.shape.len() > 1 { lr * step.weight_decay } else { 0.0 };
            let arrays = (
                array.values.par_iter_mut(),
                gradient,
                self.first[*at].par_iter_mut(),
                self.second[*at].par_iter_mut(),
            );
            arrays.into_par_iter().with_min_len(8192).for_each(|(w, g, m, v)| {
                let g = g * scale;
                *m += (1.0 - BETA.0) * (g - *m);
                *v += (1.0 - BETA.1) * (g * g - *v);
                *w -= decay * *w + lr * (*m / c1) / ((*v / c2).sqrt() + EPSILON);
            });
        }
        norm
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nets::Tensor32;

    #[test]
    fn the_first_step_has_the_length_of_the_learning_rate() {
        let array = |name: &str| Tensor32 { name: name.into(), shape: vec![2], values: vec![1.0, 1.0], trained: true };
        let mut weights = Weights { tensors: vec![array("a"), array("lite.stem.beta")] };
        let mut adam = AdamW::new(&weights);
        let gradients = [(0, vec![3.0, -4.0]), (1, vec![0.0, 12.0])];
        let step = Step { lr: 0.1, encoder: 0.5, weight_decay: 0.5, clip: 1.0 };
        let norm = adam.step(&mut weights, &gradients, step);
        assert!((norm - 13.0).abs() < 1e-6);
        let [own, encoder] = [0, 1].map(|at| weights.tensors[at].values.clone());
        assert!((own[0] - 0.9).abs() < 1e-5 && (own[1] - 1.1).abs() < 1e-5);
        assert!(encoder[0] == 1.0 && (encoder[1] - 0.95).abs() < 1e-5, "an encoder goes half as far");
    }
}
