//! What is done with results on their way out of a layer, and with values on their way in.

/// What values are kept within; NaN stays NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// The least value.
    pub low: f32,
    /// The largest.
    pub high: f32,
}

impl Limits {
    /// None.
    pub const NONE: Self = Self { low: f32::NEG_INFINITY, high: f32::INFINITY };

    /// Whether any number changes.
    pub fn are_some(self) -> bool {
        self != Self::NONE
    }

    /// The value within them.
    #[inline(always)]
    pub fn of(self, value: f32) -> f32 {
        let raised = if value < self.low { self.low } else { value };
        if raised > self.high { self.high } else { raised }
    }

    /// These, and then others; none where no interval is left.
    pub fn then(self, next: Self) -> Option<Self> {
        let (low, high) = (self.low.max(next.low), self.high.min(next.high));
        (low <= high).then_some(Self { low, high })
    }
}

impl Default for Limits {
    fn default() -> Self {
        Self::NONE
    }
}

/// `limits(result + summand)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ending<'a> {
    /// A tensor laid out as the result.
    pub summand: Option<&'a [f32]>,
    /// What the sum is kept within.
    pub limits: Limits,
}

impl Ending<'_> {
    /// Whether it changes anything.
    pub(super) fn is_some(&self) -> bool {
        self.summand.is_some() || self.limits.are_some()
    }
}
