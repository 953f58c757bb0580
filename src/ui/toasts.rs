//! What happened, in a corner: what is done goes by itself, what failed stays until it is read.

use std::path::{Path, PathBuf};

use egui::{Align2, Context, Frame, Margin, RichText};

use super::progress::now;
use super::words::{Message, capital, message, t};
use super::{theme, widgets};

/// How long what is done is shown.
const SHOWN_SECS: f64 = 6.0;
/// Room for a sentence.
const WIDTH: f32 = 460.0;
/// More than this are not shown at once.
const MOST: usize = 4;

#[derive(Clone, Debug)]
struct Toast {
    said: Message,
    is_error: bool,
    saved: Option<PathBuf>,
    since_secs: f64,
    shows_details: bool,
}

impl Toast {
    /// What is shown at once: of an error what, and what to do.
    fn short(&self) -> String {
        let text = self.said.text();
        let parts: Vec<&str> = text.split(" — ").collect();
        match parts.as_slice() {
            [what, .., advice] if self.is_error => format!("{} — {}", capital(what), without_path(advice)),
            _ if self.is_error => capital(&text),
            _ => text,
        }
    }
}

/// All that is shown.
#[derive(Debug, Default)]
pub struct Toasts {
    shown: Vec<Toast>,
}

impl Toasts {
    /// Something went well, or a person should know of it.
    pub fn info(&mut self, said: impl Into<Message>) {
        self.add(said.into(), false, None);
    }

    /// Something failed. The sentence is "what — why — what to do"; what and what to do are shown, all of it under
    /// t!("details").
    pub fn error(&mut self, sentence: impl Into<Message>) {
        let sentence = sentence.into();
        log::warn!("{}", sentence.in_english());
        self.add(sentence, true, None);
    }

    /// A file was written.
    pub fn saved(&mut self, path: PathBuf) {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        self.add(message!("saved", name = &*name), false, Some(path.clone()));
    }

    fn add(&mut self, said: Message, is_error: bool, saved: Option<PathBuf>) {
        self.shown.retain(|toast| toast.said != said);
        let since_secs = now();
        self.shown.push(Toast { said, is_error, saved, since_secs, shows_details: false });
        let over = self.shown.len().saturating_sub(MOST);
        self.shown.drain(..over);
    }

    /// What was told last, while it is shown.
    pub fn last(&self) -> Option<String> {
        self.shown.last().map(|toast| toast.short())
    }

    /// What was told about another picture goes.
    pub fn clear(&mut self) {
        self.shown.clear();
    }

    /// Draws them over everything, the last one with its lower left corner at a place.
    pub fn show(&mut self, ctx: &Context, place: egui::Pos2) {
        self.shown.retain(|toast| toast.is_error || now() - toast.since_secs < SHOWN_SECS);
        if self.shown.is_empty() {
            return;
        }
        ctx.request_repaint_after(std::time::Duration::from_millis(500));
        let area = egui::Area::new(egui::Id::unique("toasts")).pivot(Align2::LEFT_BOTTOM).fixed_pos(place);
        area.order(egui::Order::Foreground).show(ctx, |ui| {
            ui.set_max_width(WIDTH);
            let mut closed = None;
            for (index, toast) in self.shown.iter_mut().enumerate() {
                if one(ui, toast) {
                    closed = Some(index);
                }
            }
            if let Some(index) = closed {
                self.shown.remove(index);
            }
        });
    }
}

/// Draws one; true once it is closed.
fn one(ui: &mut egui::Ui, toast: &mut Toast) -> bool {
    let colors = theme::palette(ui.ctx());
    let mut is_closed = false;
    let edge = if toast.is_error { colors.error } else { colors.control };
    let frame = Frame::new()
        .fill(colors.panel)
        .stroke((1.0, edge))
        .corner_radius(8)
        .inner_margin(Margin::symmetric(14, 10))
        .shadow(egui::Shadow { offset: [0, 4], blur: 16, spread: 0, color: theme::HAIR_RIM });
    frame.show(ui, |ui| {
        ui.set_max_width(WIDTH);
        ui.label(RichText::new(toast.short()).color(colors.strong));
        if toast.shows_details {
            ui.label(RichText::new(capital(&toast.said.text())).small().color(colors.weak));
        }
        ui.horizontal(|ui| {
            if toast.is_error {
                let label = if toast.shows_details { t!("less") } else { t!("details") };
                if widgets::link(ui, label).clicked() {
                    toast.shows_details = !toast.shows_details;
                }
            }
            if let Some(path) = &toast.saved
                && widgets::link(ui, t!("show-in-folder")).clicked()
            {
                show_in_folder(path);
            }
            if widgets::link(ui, t!("close")).clicked() {
                is_closed = true;
            }
        });
    });
    ui.add_space(8.0);
    is_closed
}

/// Opens the file's folder in the system's file manager. Nothing is waited for.
pub fn show_in_folder(path: &Path) {
    let folder = path.parent().unwrap_or(path);
    let opener = if cfg!(target_os = "macos") {
        "open"
    } else if cfg!(windows) {
        "explorer"
    } else {
        "xdg-open"
    };
    let opened = std::process::Command::new(opener).arg(folder).spawn().and_then(|mut child| {
        // Whoever does not wait for a child leaves its shadow behind.
        let wait = move || child.wait().map(drop);
        std::thread::Builder::new().name("opener".to_owned()).spawn(wait).map(drop)
    });
    if let Err(error) = opened {
        log::warn!("could not show the folder: {error}");
    }
}

/// Advice without the path behind it, which is under t!("details").
fn without_path(advice: &str) -> &str {
    advice.split(": ").next().unwrap_or(advice)
}
