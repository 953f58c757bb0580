//! The arguments of what goes into a picture beside its pixels.

use clap::{Args, ValueEnum};
use plenoscope::scene::{Embed, Part};

/// What goes into a picture.
#[derive(Clone, Debug, Args)]
pub struct EmbedArgs {
    /// What goes into the picture, so that it knows how it was made (XMP): recipe, depth (GDepth), photo, with commas; by
    /// default what the recipe says, else nothing
    #[arg(long, value_name = "WHAT", value_delimiter = ',')]
    embed: Vec<What>,
}

/// One part of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// The edit with its repairs, and which photo it is of: --recipe embedded finds both again
    Recipe,
    /// The depth map, as phones write it
    Depth,
    /// The photo's file itself, with the edit
    Photo,
    /// Nothing, whatever the recipe says
    None,
}

impl EmbedArgs {
    /// What was asked for, if anything was.
    pub fn asked(&self) -> Option<Embed> {
        let part = |what: &What| match what {
            What::Recipe => Some(Part::Recipe),
            What::Depth => Some(Part::Depth),
            What::Photo => Some(Part::Photo),
            What::None => None,
        };
        (!self.embed.is_empty()).then(|| Embed::from(self.embed.iter().filter_map(part).collect::<Vec<_>>()))
    }
}
