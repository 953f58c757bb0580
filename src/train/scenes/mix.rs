//! How often which kind of sample is made.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::SceneError;

/// Shares of the kinds of sample; they need not add up to 1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Mix {
    /// Masked photos of two layers.
    pub lifted: f32,
    /// Compositions of cut-outs and plants.
    pub collage: f32,
    /// Lifted nearness maps.
    pub pseudo: f32,
    /// Real light fields.
    pub real: f32,
    /// Scenes in three dimensions.
    pub solid: f32,
}

impl Default for Mix {
    fn default() -> Self {
        Self { lifted: 0.18, collage: 0.1, pseudo: 0.37, real: 0.05, solid: 0.3 }
    }
}

impl FromStr for Mix {
    type Err = SceneError;

    /// Shares such as `lifted=0.3,collage=0.3`; kinds that are not named get none, empty text means the usual mix.
    fn from_str(text: &str) -> Result<Self, SceneError> {
        let wrong = |why: String| SceneError::Config {
            what: "mix",
            got: format!("{text:?}, where {why}"),
            expected: "shares by kind such as lifted=0.3,collage=0.1,pseudo=0.3,real=0.1,solid=0.2",
        };
        if text.trim().is_empty() {
            return Ok(Self::default());
        }
        let mut mix = Self { lifted: 0.0, collage: 0.0, pseudo: 0.0, real: 0.0, solid: 0.0 };
        for part in text.split(',') {
            let (name, share) = part.split_once('=').ok_or_else(|| wrong(format!("{part:?} has no share")))?;
            let share: f32 = share.trim().parse().map_err(|error| wrong(format!("{share:?} is no number: {error}")))?;
            match name.trim() {
                "lifted" => mix.lifted = share,
                "collage" => mix.collage = share,
                "pseudo" => mix.pseudo = share,
                "real" => mix.real = share,
                "solid" => mix.solid = share,
                other => return Err(wrong(format!("{other:?} is no kind"))),
            }
        }
        Ok(mix)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mix_is_read_from_text() {
        let mix = |text: &str| text.parse::<Mix>();
        assert_eq!(mix("").unwrap(), Mix::default());
        assert_eq!(
            mix("lifted=1, real=0.5").unwrap(),
            Mix { lifted: 1.0, collage: 0.0, pseudo: 0.0, real: 0.5, solid: 0.0 }
        );
        for (text, word) in [("lifted", "no share"), ("lifted=much", "much"), ("flowers=1", "flowers")] {
            let error = mix(text).unwrap_err().to_string();
            assert!(error.contains(word) && error.contains("lifted=0.3"), "{error}");
        }
    }
}
