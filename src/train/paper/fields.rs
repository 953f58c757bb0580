//! Which light fields are trained on, and which the methods are judged by.

use std::path::{Path, PathBuf};

use anyhow::{Result, ensure};
use serde::Serialize;

use crate::recorded;
use crate::rng::Rng;

/// Names of the paper's lists, as they were published, looked for beside the light fields.
const LISTS: [&str; 2] = ["flowers_lytro_train.txt", "flowers_lytro_test.txt"];
/// Share of the light fields that a seeded split keeps for judging.
const HELD_OUT: f32 = 0.1;

/// Both sides.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Split {
    /// How they were parted.
    pub how: String,
    /// To train on.
    #[serde(skip)]
    pub train: Vec<PathBuf>,
    /// To judge by.
    #[serde(skip)]
    pub test: Vec<PathBuf>,
}

/// Parts the light fields of a folder: by lists that are named or lie in it, where their names match, else by the seed.
///
/// # Errors
/// No light fields; only one.
pub fn split(data: &Path, lists: [Option<&Path>; 2], seed: u64) -> Result<Split> {
    let files = recorded::found(data)?;
    let beside = LISTS.map(|name| Some(data.join(name)).filter(|path| path.exists()));
    let paths =
        [lists[0].map(Path::to_owned).or(beside[0].clone()), lists[1].map(Path::to_owned).or(beside[1].clone())];
    if let [Some(train), Some(test)] = &paths {
        let sides = [recorded::named(data, train), recorded::named(data, test)];
        if let [Ok(train), Ok(test)] = sides {
            let how =
                format!("by the lists of names ({} to train on, {} to judge by are here)", train.len(), test.len());
            return Ok(Split { how, train, test });
        }
        let named = lists.iter().any(Option::is_some);
        ensure!(!named, "the lists name no light field of this folder: {}", data.display());
    }
    ensure!(
        files.len() > 1,
        "one light field is not enough, one is to be judged by: put more there: {}",
        data.display()
    );
    let mut order: Vec<usize> = (0..files.len()).collect();
    let mut rng = Rng::new(seed, 0x7370_6c69);
    (1..order.len()).rev().for_each(|i| order.swap(i, rng.below(i + 1)));
    let held_out = ((files.len() as f32 * HELD_OUT).round() as usize).clamp(1, files.len() - 1);
    let pick = |chosen: &[usize]| {
        let mut paths: Vec<PathBuf> = chosen.iter().map(|&i| files[i].clone()).collect();
        paths.sort();
        paths
    };
    let (test, train) = (pick(&order[..held_out]), pick(&order[held_out..]));
    let how = format!("by seed {seed} ({} to train on, {} to judge by)", train.len(), test.len());
    Ok(Split { how, train, test })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder(count: usize) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for i in 0..count {
            std::fs::write(folder.path().join(format!("IMG_{i:02}_eslf.png")), b"").unwrap();
        }
        folder
    }

    #[test]
    fn a_seed_parts_the_folder_the_same_every_time_and_a_list_before_it() {
        let folder = folder(30);
        let both = |seed| split(folder.path(), [None, None], seed).unwrap();
        assert_eq!(both(1), both(1));
        assert_ne!(both(1).test, both(2).test);
        assert_eq!((both(1).train.len(), both(1).test.len()), (27, 3));
        assert!(both(1).test.iter().all(|path| !both(1).train.contains(path)));
        std::fs::write(folder.path().join(LISTS[0]), "IMG_03_eslf.png\nIMG_99_eslf.png\n").unwrap();
        std::fs::write(folder.path().join(LISTS[1]), "IMG_04_eslf.png\n\n").unwrap();
        assert_eq!(both(1).test, [folder.path().join("IMG_04_eslf.png")]);
        assert!(both(1).how.contains("lists"));
        std::fs::write(folder.path().join(LISTS[1]), "elsewhere.png\n").unwrap();
        assert!(both(1).how.contains("seed"), "lists of other files part nothing");
    }

    #[test]
    fn a_folder_without_enough_light_fields_is_refused() {
        for count in [0, 1] {
            let folder = folder(count);
            let text = split(folder.path(), [None, None], 1).unwrap_err().to_string();
            assert!(text.ends_with(&*folder.path().to_string_lossy()) && !text.contains('\n'), "{text}");
        }
    }
}
