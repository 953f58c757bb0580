//! Tests that walk the table of formats: what is written is read again, and keeps what the table says.

use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use super::layout::tests::scene;
use super::*;
use crate::field::{LightField, Picture, RayDepths, ViewIndex, ViewPoint};
use crate::io::save::{self, PictureOptions};
use crate::io::{Opened, open};
use crate::job::Cancel;

/// A job that nobody stops or listens to.
fn job() -> Job<'static> {
    static NEVER: LazyLock<Cancel> = LazyLock::new(Cancel::default);
    Job { cancel: &NEVER, sink: &() }
}

/// Opens a light field.
fn light_field(path: &Path) -> LightFieldFile {
    match open(path, &job()) {
        Ok(Opened::LightField(file)) => *file,
        other => panic!("{} is a light field: {other:?}", path.display()),
    }
}

fn depths(field: &LightField) -> RayDepths {
    let [w, h] = field.size();
    let count = field.grid().count() * w as usize * h as usize;
    // Any bits will do, as they must all come back.
    let value = |n: usize| (n as f32 * 0.37).sin() * 3.9;
    RayDepths::new(field.grid(), field.size(), (0..count).map(value).collect()).unwrap()
}

/// Writes a format of the table into a folder; the path that was written.
fn write(id: &str, dir: &Path, source: &FieldToWrite, job: &Job) -> PathBuf {
    let entry = by_id(id).unwrap();
    let path = match entry.suffix {
        Some(suffix) => dir.join(format!("{}.{suffix}", id.trim_start_matches('.'))),
        None => dir.join(id),
    };
    if let Some(Writer::Field(write)) = entry.writer {
        write(&path, source, job).unwrap();
        return path;
    }
    let reference = source.field.reference();
    let map = source.depths.unwrap().reference_map();
    let [w, h] = source.field.size();
    let plain =
        |point: ViewPoint| Picture { size: [w, h], rgb_linear: vec![point.0.du / 20.0 + 0.5; (w * h * 3) as usize] };
    let [left, right] = stereo::eyes(2.0).map(plain);
    match id {
        "quilt" => {
            let device = quilt::Device { id: "small", name: "small", grid: [4, 2], size: [64, 24], aspect: 1.5 };
            let path = device.path(&path);
            quilt::write(&path, &device, [-4.0, 3.0], &plain, job).unwrap();
            return path;
        }
        "refocus" => save::picture(&path, &left, &PictureOptions::default()),
        ".pfm" => depth_out::write_pfm(&path, &map),
        ".png" => depth_out::write_png16(&path, &map),
        "gdepth" => depth_out::write_gdepth(&path, depth_out::Seen::View(reference), &map, 90),
        "side-by-side" => stereo::write_side_by_side(&path, &left, &right),
        "anaglyph" => stereo::write_anaglyph(&path, &left, &right),
        "mpo" => mpo::write(&path, &left, &right),
        "spatial" => {
            let eyes = stereo_heic::Eyes { focal: 0.75, apart_m: 0.004 };
            stereo_heic::write(&path, [&left, &right], eyes, job)
        }
        "ply" => ply::write(&path, source),
        "html" => living::write(&path, &living::tests::living("rose")),
        other => panic!("the table has {other}, and no test writes it"),
    }
    .unwrap();
    path
}

#[test]
fn every_format_that_is_written_keeps_what_the_table_says() {
    let job = &job();
    let field = scene(8, 8, [40, 30]);
    let depths = depths(&field);
    let source = FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) };
    let dir = tempfile::tempdir().unwrap();
    for entry in TABLE.iter().filter(|entry| entry.writer.is_some()) {
        let path = write(entry.id, dir.path(), &source, job);
        let again = write(entry.id, dir.path(), &source, job);
        assert!(path == again && path.exists(), "{}: writing over works", entry.id);
        match entry.keeps {
            Keeps::OneMap => assert_eq!(pfm::read_pfm(&path).unwrap().disparity_px(), depths.reference()),
            Keeps::Made => {}
            Keeps::Views | Keeps::ViewsAndDepths => {
                let file = light_field(&path);
                assert!(*file.field == field, "{}: every view comes back: {:?}", entry.id, file.warnings);
                assert!(file.warnings.is_empty(), "{}: {:?}", entry.id, file.warnings);
                if entry.keeps == Keeps::ViewsAndDepths {
                    assert_eq!(file.depths.as_deref(), Some(&depths), "{}", entry.id);
                    let [low, high] = file.info.disparity_px.unwrap();
                    assert!(low < -3.8 && high > 3.8);
                }
            }
        }
    }
    let left = std::fs::read_dir(dir.path())
        .unwrap()
        .filter(|e| e.as_ref().unwrap().file_name().to_string_lossy().starts_with('.'));
    assert_eq!(left.count(), 0, "nothing written aside is left behind");
}

/// The lines of the README's table: name, whether it is read, how it is written.
fn readme_table() -> Vec<(String, bool, String)> {
    let readme = include_str!("../../../README.md");
    let lines = readme.split("\n## ").find(|part| part.starts_with("Formats")).unwrap().lines();
    let row = |line: &str| {
        let cells: Vec<&str> = line.trim_matches('|').split('|').map(str::trim).collect();
        (cells[0].to_owned(), !cells[1].is_empty(), cells[2].to_owned())
    };
    lines.filter(|line| line.starts_with('|')).skip(2).map(row).collect()
}

#[test]
fn the_readme_says_what_the_table_says() {
    let rows = readme_table();
    assert_eq!(
        rows.iter().map(|row| row.0.as_str()).collect::<Vec<_>>(),
        TABLE.iter().map(|entry| entry.name).collect::<Vec<_>>()
    );
    for ((name, read, written), entry) in rows.iter().zip(&TABLE) {
        assert_eq!(*read, entry.is_read(), "{name}: read");
        if let Some(Reader::Files(types)) = entry.reader {
            assert!(types.iter().all(|kind| name.contains(kind.name) || kind.name.starts_with("Lytro")), "{name}");
        }
        assert_eq!(!written.is_empty(), entry.writer.is_some(), "{name}: written");
        assert!(written.contains(entry.id), "{name}: {written:?} names {}", entry.id);
    }
}

#[test]
fn what_the_table_reads_and_makes_opens_too() {
    let job = &job();
    let field = scene(8, 8, [40, 30]);
    let depths = depths(&field);
    let source = FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) };
    let dir = tempfile::tempdir().unwrap();
    let quilt = light_field(&write("quilt", dir.path(), &source, job));
    assert_eq!((quilt.field.grid().rows(), quilt.field.grid().cols(), quilt.field.size()), (1, 8, [16, 12]));
    let Opened::Photo(photo) = open(&write("gdepth", dir.path(), &source, job), job).unwrap() else { panic!() };
    assert!(photo.depth.is_some());
    let Opened::Photo(photo) = open(&write("refocus", dir.path(), &source, job), job).unwrap() else { panic!() };
    assert_eq!(photo.info.size, field.size());
    let map = depth_map::read(&write(".png", dir.path(), &source, job)).unwrap();
    assert_eq!((map.size(), map.is_disparity), ([40, 30], false));
}

#[test]
fn other_grids_come_back_from_every_folder_format() {
    let job = &job();
    for (rows, cols) in [(1, 7), (9, 9), (3, 5), (17, 2)] {
        let field = scene(rows, cols, [24, 18]);
        let source = FieldToWrite::new(&field);
        let dir = tempfile::tempdir().unwrap();
        let paths = ["views", "hci", "eslf.png"].map(|name| dir.path().join(name));
        views::write(&paths[0], &source, job).unwrap();
        hci::write(&paths[1], &source, job).unwrap();
        eslf::write(&paths[2], &source, job).unwrap();
        for path in paths {
            let file = light_field(&path);
            assert!(*file.field == field, "{rows}×{cols}: {} {:?}", path.display(), file.warnings);
        }
    }
}

/// Half the number of views is the number of another view than ours where sides are even.
#[test]
fn the_benchmarks_tools_find_the_truth_of_the_view_that_they_show() {
    let job = &job();
    let dir = tempfile::tempdir().unwrap();
    for (side, center) in [(3, ViewIndex { v: 1, u: 1 }), (4, ViewIndex { v: 2, u: 0 })] {
        let field = scene(side, side, [16, 12]);
        let depths = depths(&field);
        let path = dir.path().join(side.to_string());
        hci::write(&path, &FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) }, job).unwrap();
        let truth = pfm::read_pfm(&path.join("gt_disp_lowres.pfm")).unwrap();
        assert_eq!(truth.disparity_px(), depths.view(center));
        assert!(light_field(&path).warnings.is_empty());
        field.grid().views().for_each(|at| {
            let number = field.grid().layer_from_view(at);
            std::fs::remove_file(path.join(format!("gt_disp_lowres_Cam{number:03}.pfm"))).unwrap();
        });
        let file = light_field(&path);
        let is_ours = center == field.grid().reference();
        assert_eq!(
            (file.reference_disparity.is_some(), file.warnings.is_empty()),
            (is_ours, is_ours),
            "{:?}",
            file.warnings
        );
    }
}

#[test]
fn a_persons_own_files_in_the_folder_stay() {
    let job = &job();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("out");
    views::write(&path, &FieldToWrite::new(&scene(3, 3, [16, 12])), job).unwrap();
    std::fs::write(path.join("letter.txt"), b"dear").unwrap();
    let smaller = scene(2, 2, [16, 12]);
    views::write(&path, &FieldToWrite::new(&smaller), job).unwrap();
    assert!(path.join("letter.txt").is_file() && !path.join("view_2_2.png").exists());
    let file = light_field(&path);
    assert!(*file.field == smaller);
}

#[test]
fn a_stopped_export_leaves_nothing() {
    let cancel = Cancel::default();
    cancel.cancel();
    let job = &Job { cancel: &cancel, sink: &() };
    let field = scene(2, 2, [16, 12]);
    let dir = tempfile::tempdir().unwrap();
    for write in [views::write, hci::write, stanford::write, eslf::write] {
        assert!(write(&dir.path().join("x"), &FieldToWrite::new(&field), job).is_err());
    }
    assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 0);
}

#[test]
fn foreign_views_that_lie_wrongly_are_turned_and_the_person_is_told() {
    let truth = scene(5, 5, [120, 90]);
    let upside_down = layout::Layout { flip_v: true, ..Default::default() }.apply(&truth);
    let dir = tempfile::tempdir().unwrap();
    for at in upside_down.grid().views() {
        let name = format!("flower_{:02}_{:02}.png", at.v, at.u);
        out::view_png(&dir.path().join(name), upside_down.view(at)).unwrap();
    }
    let file = light_field(dir.path());
    assert!(file.layout.flip_v && file.warnings.len() == 1, "{:?} {:?}", file.layout, file.warnings);
    assert!(*file.field == truth);
}

#[test]
fn missing_and_odd_views_are_named() {
    let job = &job();
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lf");
    views::write(&path, &FieldToWrite::new(&scene(3, 3, [16, 12])), job).unwrap();
    std::fs::remove_file(path.join("view_1_2.png")).unwrap();
    let text = open(&path, job).unwrap_err().to_string();
    assert!(text.contains("(v 1, u 2)") && text.ends_with("lf"), "{text}");
    std::fs::copy(path.join("view_0_0.png"), path.join("view_1_2.png")).unwrap();
    let odd = scene(1, 1, [9, 9]);
    out::view_png(&path.join("view_2_2.png"), odd.reference()).unwrap();
    let text = open(&path, job).unwrap_err().to_string();
    assert!(text.contains("9×9") && text.ends_with("view_2_2.png"), "{text}");
    std::fs::write(path.join("view_2_2.png"), b"\x89PNG\r\n").unwrap();
    let text = open(&path, job).unwrap_err().to_string();
    assert!(text.ends_with("view_2_2.png"), "{text}");
}

#[test]
fn broken_ray_depths_are_a_warning() {
    let job = &job();
    let field = scene(2, 2, [16, 12]);
    let depths = depths(&field);
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("lf");
    views::write(&path, &FieldToWrite { depths: Some(&depths), ..FieldToWrite::new(&field) }, job).unwrap();
    let broken: [&dyn Fn(&Path); 3] =
        [&|map| std::fs::write(map, b"Pf\n16 12\n-1\n").unwrap(), &|map| std::fs::remove_file(map).unwrap(), &|map| {
            out::map_pfm(map, [2, 2], &[0.0; 4]).unwrap()
        }];
    for break_it in broken {
        break_it(&path.join("disparity_1_1.pfm"));
        let file = light_field(&path);
        assert!(file.depths.is_none() && file.warnings.len() == 1 && *file.field == field, "{:?}", file.warnings);
    }
}
