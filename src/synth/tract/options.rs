//! How a net is to be run.

use super::weights::SharedWeights;
use crate::job::Cancel;
use crate::kernel::{Halves, Isa};

/// Which code does the convolutions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Path {
    /// The fastest that this processor has.
    #[default]
    Auto,
    /// The direct convolution with AVX-512, without tiles.
    Avx512,
    /// The direct convolution with AVX2 and FMA.
    Avx2,
    /// The direct convolution in plain Rust: slow, for comparison.
    Portable,
    /// tract's own convolutions: what processors without AVX2 get.
    Stock,
}

impl Path {
    /// The instructions of the direct convolution; `None` for tract's own.
    ///
    /// A set that the processor does not have falls back to the next slower one, so that one choice in the settings
    /// serves every machine.
    pub(super) fn isa(self) -> Option<Isa> {
        match self {
            Self::Auto => Some(Isa::best()).filter(|isa| *isa != Isa::portable()),
            Self::Avx512 => Some(Isa::best()),
            Self::Avx2 => Isa::avx2().or(Some(Isa::portable())),
            Self::Portable => Some(Isa::portable()),
            Self::Stock => None,
        }
    }
}

/// How a net is to be run.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Which code does the convolutions.
    pub path: Path,
    /// Convolutions one by one, without Winograd's algorithm: slower, results within 1e-5 of any other engine's.
    pub exact: bool,
    /// Threads that compute; 0 means one per processor core.
    pub threads: usize,
    /// Where packed weights are looked for before they are kept once more.
    pub weights: SharedWeights,
    /// What stops the preparation, which takes seconds for large nets.
    pub cancel: Cancel,
}

impl Options {
    /// What multiplies planes of many channels in tiles, where the processor can and nothing exact is asked for.
    pub(crate) fn halves(&self) -> Option<Halves> {
        if self.path == Path::Auto && !self.exact { Halves::best() } else { None }
    }
}
