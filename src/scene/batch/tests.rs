//! Batches of small photos on the nets in the program.

use std::fs;
use std::sync::atomic::AtomicU32;

use super::*;
use crate::field::FNumber;
use crate::job::Cancel;
use crate::scene::recipe::PictureSettings;
use crate::scene::{Edit, Making, Recipe};
use crate::shard::Shard;

/// Two photos of one name, and a file that is none.
fn inputs(dir: &Path) -> Vec<PathBuf> {
    let photo = image::RgbImage::from_fn(48, 32, |x, y| image::Rgb([x as u8 * 5, y as u8 * 7, 90]));
    let paths = ["a/x.png", "bad.jpg", "b/x.jpg"].map(|name| dir.join(name)).to_vec();
    for folder in ["a", "b"] {
        fs::create_dir_all(dir.join(folder)).unwrap();
    }
    photo.save(&paths[0]).unwrap();
    fs::write(&paths[1], "no photo").unwrap();
    photo.save(&paths[2]).unwrap();
    paths
}

fn order(out: &Path) -> Order {
    let making = Making { long_side: 48, ..Making::default() };
    let (recipe, out) = (Recipe::default(), out.to_owned());
    let (earlier, shard) = (Earlier::Keep, Shard::default());
    Order { recipe, out, memory_bytes: 1, jobs: 0, earlier, shard, making, own_map: None }
}

fn run_quietly(inputs: &[PathBuf], order: &Order) -> Result<Summary, BatchError> {
    let cancel = Cancel::default();
    run(inputs, order, &Maker::default(), &|_| Ok(()), &Job { cancel: &cancel, sink: &() })
}

#[test]
fn a_bad_photo_does_not_stop_the_others_and_a_second_run_does_nothing_again() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("new");
    let inputs = inputs(dir.path());
    let first = run_quietly(&inputs, &order(&out)).unwrap();
    assert_eq!(first.done, [out.join("x-f3.5.jpg"), out.join("x-f3.5-2.jpg")]);
    assert!(first.failed.len() == 1 && first.failed[0].0 == inputs[1] && first.failed[0].1.contains("bad.jpg"));
    let second = run_quietly(&inputs, &order(&out)).unwrap();
    assert_eq!((second.done.len(), second.skipped.len(), second.failed.len()), (0, 2, 1));
    assert_eq!(second.met, 0);
    let forced = run_quietly(&inputs, &Order { earlier: Earlier::Replace, ..order(&out) }).unwrap();
    assert_eq!(forced.done.len(), 2);
}

#[test]
fn what_is_resumed_makes_again_what_is_cut_off_or_of_another_recipe() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let inputs = [inputs(dir.path()).remove(0)];
    let resumed = |recipe: &Recipe| {
        let order = Order { earlier: Earlier::Resume, recipe: recipe.clone(), ..order(&out) };
        let summary = run_quietly(&inputs, &order).unwrap();
        (summary.done.len(), summary.skipped.len())
    };
    // The name does not tell the recipes apart.
    let export = PictureSettings { name: "{name}".to_owned(), ..PictureSettings::default() };
    let at = |f| Recipe::new(Edit { f_number: FNumber(f), ..Edit::default() }, export.clone());
    let picture = out.join("x.jpg");
    assert_eq!(resumed(&at(2.0)), (1, 0));
    assert_eq!(resumed(&at(2.0)), (0, 1));
    fs::write(&picture, "cut off").unwrap();
    assert_eq!(resumed(&at(2.0)), (1, 0));
    assert_eq!(resumed(&at(4.0)), (1, 0));
    assert_eq!(resumed(&at(4.0)), (0, 1));
}

#[test]
fn every_photo_is_made_by_one_of_the_parts_and_has_its_line() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let inputs = inputs(dir.path());
    let lines = Mutex::new(Vec::new());
    let report = |line: &Line| {
        lines.lock().unwrap().push(line.clone());
        Ok(())
    };
    let cancel = Cancel::default();
    for part in ["1/3", "2/3", "3/3"] {
        let order = Order { shard: part.parse().unwrap(), ..order(&out) };
        run(&inputs, &order, &Maker::default(), &report, &Job { cancel: &cancel, sink: &() }).unwrap();
    }
    let mut lines = lines.into_inner().unwrap();
    lines.sort_by(|a, b| a.path.cmp(&b.path));
    assert_eq!(lines.iter().map(|line| line.state).collect::<Vec<_>>(), [State::Made, State::Made, State::Failed]);
    let mut outputs: Vec<_> = lines.iter().filter_map(|line| line.output.clone()).collect();
    outputs.sort();
    assert_eq!(outputs, ["x-f3.5-2.jpg", "x-f3.5.jpg"].map(|name| out.join(name).to_string_lossy().into_owned()));
    assert!(lines[2].error.as_ref().is_some_and(|why| why.contains("bad.jpg")) && lines[2].output.is_none());
}

#[test]
fn a_picture_that_another_worker_made_meanwhile_stays_and_is_counted() {
    struct Meddler(PathBuf);
    impl Sink for Meddler {
        fn progress(&self, _: Progress) {}
        fn warning(&self, _: String) {
            fs::write(&self.0, "theirs").unwrap();
        }
    }
    let dir = tempfile::tempdir().unwrap();
    let inputs = [inputs(dir.path()).remove(0)];
    let target = dir.path().join("x-f3.5.jpg");
    let cancel = Cancel::default();
    // A photo without a phone's depth is warned of, while it is worked on.
    let making = Making { source: crate::scene::DepthFrom::Phone, ..order(dir.path()).making };
    let order = Order { making, ..order(dir.path()) };
    let job = Job { cancel: &cancel, sink: &Meddler(target.clone()) };
    let summary = run(&inputs, &order, &Maker::default(), &|_| Ok(()), &job).unwrap();
    assert_eq!((summary.done.len(), summary.skipped.len(), summary.met), (0, 1, 1));
    assert_eq!(fs::read_to_string(&target).unwrap(), "theirs");
}

#[test]
fn a_folder_that_goes_away_ends_the_work_in_one_sentence() {
    let dir = tempfile::tempdir().unwrap();
    let out = dir.path().join("out");
    let inputs = inputs(dir.path());
    let report = |_: &Line| fs::rename(&out, dir.path().join("unmounted"));
    let cancel = Cancel::default();
    let order = Order { jobs: 1, ..order(&out) };
    let ended = run(&inputs, &order, &Maker::default(), &report, &Job { cancel: &cancel, sink: &() });
    let said = ended.unwrap_err().to_string();
    assert!(said.contains("gone away") && said.ends_with("out") && !out.exists(), "{said}");
}

#[test]
fn a_report_that_cannot_be_written_ends_the_work() {
    let dir = tempfile::tempdir().unwrap();
    let inputs = inputs(dir.path());
    let full = |_: &Line| Err(io::Error::from(io::ErrorKind::StorageFull));
    let cancel = Cancel::default();
    let order = Order { jobs: 1, ..order(dir.path()) };
    let ended = run(&inputs, &order, &Maker::default(), &full, &Job { cancel: &cancel, sink: &() });
    assert!(matches!(ended, Err(BatchError::Report(_))));
}

#[test]
fn many_photos_of_one_name_get_names_of_their_own_soon() {
    let inputs: Vec<PathBuf> = (0..20_000).map(|n| PathBuf::from(format!("{n}/x.jpg"))).collect();
    let all = targets(&inputs, &order(Path::new("out")));
    assert_eq!(all[19_999], Path::new("out/x-f3.5-20000.jpg"));
    assert_eq!(all.iter().collect::<HashSet<_>>().len(), all.len());
}

#[test]
fn names_that_differ_in_capitals_alone_are_one_name() {
    let inputs = ["a/IMG_1.jpg", "b/img_1.jpg", "c/Img_1.jpg"].map(PathBuf::from);
    let wanted = ["IMG_1-f3.5.jpg", "img_1-f3.5-2.jpg", "Img_1-f3.5-3.jpg"].map(|name| Path::new("out").join(name));
    assert_eq!(targets(&inputs, &order(Path::new("out"))), wanted);
}

#[test]
fn a_stopped_batch_says_so_and_leaves_no_picture() {
    let dir = tempfile::tempdir().unwrap();
    let cancel = Cancel::default();
    cancel.cancel();
    let job = Job { cancel: &cancel, sink: &() };
    let summary = run(&["a.jpg".into()], &order(dir.path()), &Maker::default(), &|_| Ok(()), &job).unwrap();
    assert!(summary.stopped && summary.done.is_empty());
    assert_eq!(dir.path().read_dir().unwrap().count(), 0);
}

#[test]
fn work_waits_for_memory() {
    let budget = Budget::new(10);
    let (running, most) = (AtomicU32::new(0), AtomicU32::new(0));
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                budget.with(6, || {
                    most.fetch_max(running.fetch_add(1, Ordering::SeqCst) + 1, Ordering::SeqCst);
                    std::thread::sleep(std::time::Duration::from_millis(5));
                    running.fetch_sub(1, Ordering::SeqCst);
                });
            });
        }
    });
    assert_eq!(most.into_inner(), 1);
}
