//! Three things that a person is told once: how to look round, to focus and to export. Each is told where it applies, and
//! never again once it was done or put away.

use super::words::t;
use serde::{Deserialize, Serialize};

/// What was done already, or put away.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct Hints {
    looked: bool,
    focused: bool,
    exported: bool,
}

/// One thing to know.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Hint {
    /// Dragging looks round.
    Look,
    /// A click focuses.
    Focus,
    /// Export keeps the picture.
    Export,
}

impl Hint {
    /// What a person reads.
    pub fn text(self) -> &'static str {
        match self {
            Self::Look => t!("hint-look"),
            Self::Focus => t!("hint-focus"),
            Self::Export => t!("hint-export"),
        }
    }
}

impl Hints {
    /// What is told next.
    pub fn next(&self) -> Option<Hint> {
        let all = [(self.looked, Hint::Look), (self.focused, Hint::Focus), (self.exported, Hint::Export)];
        all.into_iter().find(|(is_known, _)| !is_known).map(|(_, hint)| hint)
    }

    /// It was done, or put away.
    pub fn learn(&mut self, hint: Hint) {
        match hint {
            Hint::Look => self.looked = true,
            Hint::Focus => self.focused = true,
            Hint::Export => self.exported = true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_is_told_until_it_is_done_and_never_again() {
        let mut hints = Hints::default();
        hints.learn(Hint::Focus);
        for hint in [Hint::Look, Hint::Export] {
            assert_eq!(hints.next(), Some(hint));
            hints.learn(hint);
        }
        assert_eq!(hints.next(), None);
    }
}
