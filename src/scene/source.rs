//! Where ray depths come from: what a person asks for, and how a recipe says it.

use serde::{Deserialize, Serialize};

use super::OnePhoto;
use crate::synth::ModelTag;

/// Where ray depths come from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum DepthFrom {
    /// The best there is for the photo: what the phone measured, else the net that the person prefers, else the depth net.
    #[default]
    Auto,
    /// The depth net.
    Network,
    /// What the phone measured.
    Phone,
    /// The phone's order on the depth net's scale, edges from both.
    Fused,
    /// A map of one's own.
    Map,
    /// Another depth net, by the name that it has here.
    Model(String),
    /// Another depth net, by its checksum; where it is not here, [`DepthFrom::Auto`] takes its place.
    Net(ModelTag),
}

impl DepthFrom {
    /// The source that a name on the command line stands for.
    pub fn named(name: &str) -> Self {
        match name {
            "auto" => Self::Auto,
            "network" => Self::Network,
            "phone" => Self::Phone,
            "fused" => Self::Fused,
            model => Self::Model(model.to_owned()),
        }
    }

    /// What is left of the choice at the next start. A map belongs to one photo and another model to the photos that
    /// it is good for: one that knows flowers alone takes a wall for near.
    #[must_use]
    pub fn lasting(self) -> Self {
        match self {
            Self::Map | Self::Model(_) | Self::Net(_) => Self::Auto,
            source => source,
        }
    }

    /// The name of the net, where it is one that was asked for by name or checksum.
    pub fn net_name(&self) -> Option<&str> {
        match self {
            Self::Model(name) => Some(name),
            Self::Net(tag) => Some(&tag.id),
            _ => None,
        }
    }
}

impl OnePhoto {
    /// Measured depth before the net that the person prefers before our own.
    pub fn best_source(&self, preferred: Option<DepthFrom>) -> DepthFrom {
        match self.phone {
            Some(_) => DepthFrom::Phone,
            None if self.splats.is_some() => DepthFrom::Auto,
            None => preferred.unwrap_or(DepthFrom::Network),
        }
    }
}

/// A source as it stands in a recipe: a word, or a net with its name for people and its checksum.
#[derive(Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Stored {
    Auto,
    Network,
    Phone,
    Fused,
    Net {
        name: String,
        /// Empty where a person wrote the name alone.
        #[serde(default)]
        sha256: String,
    },
}

impl Stored {
    /// None for a map of one's own, which the recipe does not hold.
    pub(super) fn of(source: &DepthFrom) -> Option<Self> {
        Some(match source {
            DepthFrom::Auto => Self::Auto,
            DepthFrom::Network => Self::Network,
            DepthFrom::Phone => Self::Phone,
            DepthFrom::Fused => Self::Fused,
            DepthFrom::Map => return None,
            DepthFrom::Model(name) => Self::Net { name: name.clone(), sha256: String::new() },
            DepthFrom::Net(ModelTag { id, sha256 }) => Self::Net { name: id.clone(), sha256: sha256.clone() },
        })
    }

    pub(super) fn source(self) -> DepthFrom {
        match self {
            Self::Auto => DepthFrom::Auto,
            Self::Network => DepthFrom::Network,
            Self::Phone => DepthFrom::Phone,
            Self::Fused => DepthFrom::Fused,
            Self::Net { name, sha256 } if sha256.is_empty() => DepthFrom::Model(name),
            Self::Net { name, sha256 } => DepthFrom::Net(ModelTag { id: name, sha256: sha256.to_lowercase() }),
        }
    }
}
