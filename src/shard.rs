//! One of several parts of some work, cut the same on every machine without a word between them.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use sha2::{Digest, Sha256};

/// The K-th of N parts; by default all of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    part: u32,
    of: u32,
}

/// Why a text is no shard.
#[derive(Debug, PartialEq, Eq, thiserror::Error)]
#[error("a shard is K/N, the K-th of N parts — {0:?} is none — write 1/8 to 8/8 for eight workers")]
pub struct NoShard(String);

impl Shard {
    /// Whether a file belongs to this part. That hangs on its name alone: not on its folder, its place in a list, or
    /// the other files.
    pub fn takes_file(self, path: &Path) -> bool {
        let name = path.file_name().unwrap_or(path.as_os_str());
        let hash = Sha256::digest(name.to_string_lossy().as_bytes());
        let number = hash.iter().take(8).fold(0, |sum, byte| sum << 8 | u64::from(*byte));
        self.takes_number(number)
    }

    /// Whether a numbered thing belongs to this part: every N-th does.
    pub fn takes_number(self, number: u64) -> bool {
        number % u64::from(self.of) == u64::from(self.part - 1)
    }

    /// Whether this is all of the work.
    pub fn is_whole(self) -> bool {
        self.of == 1
    }
}

impl Default for Shard {
    fn default() -> Self {
        Self { part: 1, of: 1 }
    }
}

impl FromStr for Shard {
    type Err = NoShard;

    fn from_str(text: &str) -> Result<Self, NoShard> {
        let number = |text: &str| text.parse::<u32>().ok().filter(|n| *n > 0);
        let halves = text.split_once('/').and_then(|(part, of)| Some((number(part)?, number(of)?)));
        match halves {
            Some((part, of)) if part <= of => Ok(Self { part, of }),
            _ => Err(NoShard(text.to_owned())),
        }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.part, self.of)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_is_in_one_part_whatever_its_folder() {
        let shards: Vec<Shard> = (1..=7).map(|part| Shard { part, of: 7 }).collect();
        let mut taken = [0; 7];
        for n in 0..700 {
            let [here, there] = ["a", "b/c"].map(|folder| Path::new(folder).join(format!("IMG_{n:04}.jpg")));
            let parts: Vec<usize> = (0..7).filter(|part| shards[*part].takes_file(&here)).collect();
            assert_eq!(parts.len(), 1, "{}", here.display());
            assert!(shards[parts[0]].takes_file(&there));
            taken[parts[0]] += 1;
        }
        assert!(taken.iter().all(|n| (70..=130).contains(n)), "uneven: {taken:?}");
    }

    #[test]
    fn a_name_has_the_same_part_in_every_version() {
        // `sha256sum` of the name begins with 1538148bcf1d09d6, which is 2 of 4 counted from 0.
        let taken = |part| Shard { part, of: 4 }.takes_file(Path::new("IMG_0001.jpg"));
        assert_eq!([1, 2, 3, 4].map(taken), [false, false, true, false]);
    }

    #[test]
    fn numbers_are_dealt_out_in_turn() {
        let second: Vec<u64> = (0..7).filter(|n| Shard { part: 2, of: 3 }.takes_number(*n)).collect();
        assert_eq!(second, [1, 4]);
    }

    #[test]
    fn what_is_no_shard_is_refused() {
        for text in ["", "3", "0/3", "4/3", "1/0", "-1/2", "1/2/3", "a/b", "1/99999999999"] {
            assert_eq!(text.parse::<Shard>(), Err(NoShard(text.to_owned())));
        }
        assert_eq!("3/8".parse::<Shard>().map(|shard| shard.to_string()), Ok("3/8".to_owned()));
        assert!("1/1".parse::<Shard>().is_ok_and(Shard::is_whole));
    }
}
