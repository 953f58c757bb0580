//! The window's own export, without a display: a file is opened, an edit pasted, and the dialog's button pressed.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use egui::accesskit::Role;
use egui_kittest::Harness;
use egui_kittest::kittest::Queryable as _;
use plenoscope::scene::recipe::PictureSettings;
use plenoscope::scene::{Edit, Recipe};
use plenoscope::synth::ModelSource;
use plenoscope::ui::{App, Options};

/// Frames after which a job must have ended; each waits a little, so this is minutes on a slow machine.
const MANY_FRAMES: usize = 20_000;

/// A window with something open; so tall that all of its inspector is seen, as what is hidden cannot be clicked.
pub struct WindowExport(Harness<'static, App>);

impl WindowExport {
    /// Opens a file, its depth taken from a source of the inspector. None where there is no device to draw with.
    pub fn open(input: &Path, long_side: u32, source: Option<&str>) -> Option<Self> {
        let device = pollster::block_on(wgpu::Instance::default().request_adapter(&Default::default()));
        if device.is_err() {
            assert!(std::env::var_os("PLENOSCOPE_NEED_GPU").is_none(), "no device, and PLENOSCOPE_NEED_GPU is set");
            eprintln!("SKIPPED: no device here, so the window's export is not compared");
            return None;
        }
        let options = Options {
            files: Vec::new(),
            models: ModelSource::Embedded,
            shelf: None,
            trainer: None,
            crashes: None,
            long_side: Some(long_side),
            threads: 1,
            restores_last: false,
            language: Some("en".to_owned()),
        };
        let harness = Harness::builder().with_size(egui::vec2(1200.0, 1900.0)).with_max_steps(16).wgpu().build_eframe(
            move |creation| App::new(options, &creation.egui_ctx, creation.wgpu_render_state.as_ref(), None),
        );
        let mut window = Self(harness);
        window.0.state_mut().open_file(input);
        window.wait("the light field", |app| app.light_field().is_some() && !app.is_busy());
        if let Some(source) = source {
            window.0.get_by_label(source).click();
            window.steps(4);
            window.wait("its depth", |app| !app.is_busy());
        }
        Some(window)
    }

    /// Exports what is open with an edit into a new folder, and says which file that made.
    pub fn export(&mut self, edit: &Edit, folder: &Path) -> PathBuf {
        fs::remove_dir_all(folder).ok();
        fs::create_dir_all(folder).unwrap();
        self.0.state_mut().set_export_folder(folder);
        self.0.event(egui::Event::Paste(Recipe::new(edit.clone(), PictureSettings::default()).to_json()));
        self.steps(3);
        assert_eq!(self.0.state().edit(), edit, "the edit was pasted");
        self.0.get_by_label("Export…").click();
        // A dialog that scrolls takes a few frames to find its size.
        self.steps(6);
        self.0.get_by_role_and_label(Role::Button, "Export").click();
        self.steps(3);
        self.wait("the export", |app| !app.is_busy());
        let files: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
        assert_eq!(files.len(), 1, "{files:?}");
        files[0].clone()
    }

    fn steps(&mut self, count: usize) {
        (0..count).for_each(|_| self.0.step());
    }

    fn wait(&mut self, what: &str, holds: impl Fn(&App) -> bool) {
        for _ in 0..MANY_FRAMES {
            self.0.step();
            if holds(self.0.state()) {
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("{what}: not within {MANY_FRAMES} frames");
    }
}
