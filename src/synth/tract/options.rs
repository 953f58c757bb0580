//! How a net is to be run.

/// Which code does the convolutions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Path {
    /// The fastest that this processor has.
    #[default]
    Auto,
    /// The direct convolution with AVX-512.
    Avx512,
    /// The direct convolution with AVX2 and FMA.
    Avx2,
    /// The direct convolution in plain Rust: slow, for comparison.
    Portable,
    /// tract's own convolutions: what processors without AVX2 get.
    Stock,
}

/// How a net is to be run.
#[derive(Clone, Debug)]
pub struct Options {
    /// Which code does the convolutions.
    pub path: Path,
    /// Threads that compute; 0 means one per processor core.
    pub threads: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { path: Path::Auto, threads: 0 }
    }
}
