//! The window. `app` draws a frame of it, `window` is all that it holds, `panels` draw and ask, `apply` does.
//!
//! Rules: the UI thread never waits; events come in through one bounded channel, actions go out through
//! `action::Action`; what is open lies in `open`, how it is looked at in `look`. What
//! pictures are made of, and how, is the business of [`crate::scene`].

mod action;
mod added;
mod adding;
mod app;
mod apply;
mod ask;
mod command;
mod compare;
mod dialog;
mod dialogs;
mod document;
mod event;
mod field_pictures;
mod film;
mod finals;
pub mod graphics;
mod hints;
mod history;
pub mod icon;
mod inbox;
mod input;
mod jobs;
mod keys;
mod look;
mod lost;
mod mending;
mod near_end;
mod neighbours;
mod open;
mod panels;
mod peaking;
mod points;
mod progress;
mod queue;
mod rays;
mod recents;
mod rest;
mod saver;
mod screen;
mod settings;
mod sharp;
mod sources;
mod spoken;
mod strength;
mod theme;
mod tiles;
mod toasts;
mod training;
mod trust;
mod widgets;
mod window;
mod words;
mod worker;
mod workers;

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;

use lost::{Loss, Tried};

pub use app::App;
pub use window::Options;

/// The window could not be opened.
#[derive(Debug, thiserror::Error)]
pub enum WindowError {
    /// No desktop answers.
    #[error(
        "could not open the window: there is no display — start it on a desktop, or use the command line (plenoscope --help)"
    )]
    Display,
    /// The desktop is there, and what draws is not.
    #[error(
        "could not open the window — {0} — install a graphics driver (Vulkan, Metal or DirectX 12), or use the command line"
    )]
    Graphics(String),
    /// The device went away again and again.
    #[error(
        "the graphics device was lost three times — {0} — your edit is kept; update its driver, or use the command line"
    )]
    Lost(String),
}

impl From<eframe::Error> for WindowError {
    fn from(error: eframe::Error) -> Self {
        match error {
            // Their words name lines of a source file.
            eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => Self::Display,
            other => Self::Graphics(other.to_string()),
        }
    }
}

/// Opens the window and returns when it is closed.
///
/// # Errors
/// Where there is no display, or no graphics driver.
pub fn run(mut options: Options) -> Result<(), WindowError> {
    // The clock begins here.
    progress::now();
    // Exports go beside the file, and the next run, from wherever it is started, finds it again.
    for file in &mut options.files {
        *file = std::path::absolute(&*file).unwrap_or_else(|_| file.clone());
    }
    let (tried, open_before) = Tried::before();
    if tried != Tried::None {
        options.files = open_before.into_iter().collect();
        options.restores_last = false;
        // What broke was the renderer without its device; its report stays in its folder.
        drop(options.crashes.as_deref().and_then(crate::crash::take_unseen));
    }
    let loss = Loss::default();
    open(options, tried, &loss)?;
    let Some(why) = loss.why() else { return Ok(()) };
    let next = tried.next().ok_or_else(|| WindowError::Lost(why.clone()))?;
    next.again(loss.open()).map_err(|error| WindowError::Lost(error.to_string()))
}

/// Opens the window once, and returns when it is closed or has lost its device.
fn open(options: Options, tried: Tried, loss: &Loss) -> Result<(), WindowError> {
    let native = native_options(tried);
    let told = loss.clone();
    let start = Box::new(move |creation: &eframe::CreationContext<'_>| {
        let (ctx, render) = (&creation.egui_ctx, creation.wgpu_render_state.as_ref());
        let app = App::new(options, ctx, render, creation.storage).after(tried, told, render, ctx);
        Ok(Box::new(app) as Box<dyn eframe::App>)
    });
    // egui's renderer panics where a buffer cannot be had.
    match catch_unwind(AssertUnwindSafe(|| eframe::run_native("plenoscope", native, start))) {
        Ok(done) => Ok(done?),
        Err(_) if loss.is_why() => Ok(()),
        Err(panic) => resume_unwind(panic),
    }
}

fn native_options(tried: Tried) -> eframe::NativeOptions {
    let mut native = eframe::NativeOptions {
        renderer: eframe::Renderer::Wgpu,
        // It would put noise on the photo.
        dithering: false,
        viewport: egui::ViewportBuilder::default()
            .with_app_id("plenoscope")
            .with_title("Plenoscope")
            .with_inner_size([1440.0, 900.0])
            .with_min_inner_size([640.0, 480.0])
            .with_drag_and_drop(true)
            .with_icon(icon()),
        ..Default::default()
    };
    if let egui_wgpu::WgpuSetup::CreateNew(setup) = &mut native.wgpu_options.wgpu_setup {
        // OpenGL is no driver that the window needs, and looking for it takes a fifth of the start.
        setup.instance_descriptor.backends = backends();
        setup.native_adapter_selector = tried.selector();
        // The adapter's own limits: large photos and 17×17 views need more than the least that is promised everywhere.
        setup.device_descriptor = Arc::new(|adapter: &wgpu::Adapter| wgpu::DeviceDescriptor {
            label: Some("plenoscope"),
            required_limits: adapter.limits(),
            ..Default::default()
        });
    }
    native
}

/// The interfaces of drivers that the window uses.
fn backends() -> wgpu::Backends {
    wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY)
}

fn icon() -> egui::IconData {
    const SIDE: u32 = 128;
    egui::IconData { rgba: icon::rgba(SIDE), width: SIDE, height: SIDE }
}
