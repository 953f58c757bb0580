//! What is convolved with what.

/// Extent of the kernel. Stride and group are 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kernel {
    /// 1×1: mixes channels only.
    Point,
    /// 3×3 in each view.
    Plane,
    /// 3×3×3 over views, rows and columns; the dilation is that of rows and columns.
    Volume,
}

impl Kernel {
    /// Taps along (views, rows, columns).
    pub fn extent(self) -> [usize; 3] {
        match self {
            Self::Point => [1, 1, 1],
            Self::Plane => [1, 3, 3],
            Self::Volume => [3, 3, 3],
        }
    }

    /// Taps in all.
    pub fn taps(self) -> usize {
        self.extent().iter().product()
    }
}

/// What stands outside the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Padding {
    /// The nearest pixel of the picture (views too).
    #[default]
    Edge,
    /// Zero.
    Zero,
}

/// One convolution: sizes, kernel, padding. The result has the height, width and views of the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ConvShape {
    /// Pictures in the batch.
    pub batch: usize,
    /// Channels of the input.
    pub channels_in: usize,
    /// Channels of the result.
    pub channels_out: usize,
    /// Views; 1 for a plain picture.
    pub views: usize,
    /// Rows.
    pub height: usize,
    /// Columns.
    pub width: usize,
    /// Extent of the kernel.
    pub kernel: Kernel,
    /// Distance of neighbouring taps in rows and columns, ≥ 1.
    pub dilation: usize,
    /// What stands outside the picture.
    pub padding: Padding,
}

impl ConvShape {
    /// Values of one channel: views · rows · columns.
    pub fn plane(&self) -> usize {
        self.views * self.height * self.width
    }

    /// Values of the input.
    pub fn input_len(&self) -> usize {
        self.batch * self.channels_in * self.plane()
    }

    /// Values of the result.
    pub fn output_len(&self) -> usize {
        self.batch * self.channels_out * self.plane()
    }

    /// Number of weights.
    pub fn weights_len(&self) -> usize {
        self.channels_out * self.channels_in * self.kernel.taps()
    }

    /// Useful floating-point operations of a forward pass (two per multiply-add).
    pub fn flop(&self) -> f64 {
        2.0 * self.output_len() as f64 * (self.channels_in * self.kernel.taps()) as f64
    }

    /// How far the kernel reaches to either side along (views, rows, columns).
    pub(super) fn reach(&self) -> [usize; 3] {
        let [views, rows, columns] = self.kernel.extent();
        [views / 2, rows / 2 * self.dilation, columns / 2 * self.dilation]
    }

    /// (views, rows, columns) of the picture.
    pub(super) fn size(&self) -> [usize; 3] {
        [self.views, self.height, self.width]
    }
}
