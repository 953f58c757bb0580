//! Packed weights that a net has once, however many sizes of the picture it is ready for.

use std::sync::{Arc, Mutex, PoisonError};

use tract_onnx::prelude::TypedModel;

use super::chain::{Chain, Convolutions};
use super::dense::{Product, Weights};
use super::inverted::InvertedOp;
use super::op::DirectConv;
use super::patch_conv::PatchConv;
use crate::kernel::Packed;
use crate::kernel::product::Panels;

/// Weights of nets that are ready; those that no net has any more are given back when the next one comes.
#[derive(Clone, Debug, Default)]
pub struct SharedWeights(Arc<Mutex<Kinds>>);

#[derive(Debug, Default)]
struct Kinds {
    panels: Pool<Panels>,
    rows: Pool<[f32]>,
    packed: Pool<Packed>,
    chains: Pool<Convolutions>,
}

impl SharedWeights {
    /// Lets a model have the weights that are here already, and keeps its others.
    pub(super) fn share(&self, model: &mut TypedModel) {
        let mut kinds = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kinds.forget();
        for node in &mut model.nodes {
            if let Some(op) = node.op_as_mut::<Product>() {
                match &mut op.weights {
                    Weights::Rows(panels) => kinds.panels.share(panels),
                    Weights::Planes { weights, .. } => kinds.rows.share(weights),
                }
            } else if let Some(op) = node.op_as_mut::<PatchConv>() {
                kinds.rows.share(&mut op.weights);
            } else if let Some(op) = node.op_as_mut::<InvertedOp>() {
                let parts = [op.widen.as_mut(), Some(&mut op.depthwise), Some(&mut op.narrow)];
                parts.into_iter().flatten().for_each(|part| kinds.rows.share(&mut part.weights));
            } else if let Some(op) = node.op_as_mut::<DirectConv>() {
                kinds.packed.share(&mut op.weights);
            } else if let Some(op) = node.op_as_mut::<Chain>() {
                kinds.chains.share(&mut op.convolutions);
            }
        }
    }
}

impl Kinds {
    fn forget(&mut self) {
        self.panels.forget();
        self.rows.forget();
        self.packed.forget();
        self.chains.forget();
    }
}

/// Weights of one kind, each once.
#[derive(Debug)]
struct Pool<T: ?Sized>(Vec<Arc<T>>);

impl<T: ?Sized> Default for Pool<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T: ?Sized + PartialEq> Pool<T> {
    /// Puts equal weights that are here in place of fresh ones. Unequal ones differ early on.
    fn share(&mut self, fresh: &mut Arc<T>) {
        match self.0.iter().find(|held| ***held == **fresh) {
            Some(held) => *fresh = Arc::clone(held),
            None => self.0.push(Arc::clone(fresh)),
        }
    }

    /// Gives back what nobody else has.
    fn forget(&mut self) {
        self.0.retain(|held| Arc::strong_count(held) > 1);
    }
}
