//! What happened, in a corner: what is done goes by itself, what failed stays until it is read.

use std::path::{Path, PathBuf};

use egui::{Align2, Context, Frame, Margin, RichText};

use super::progress::now;
use super::{theme, widgets};

/// How long what is done is shown.
const SHOWN_SECS: f64 = 6.0;
/// Room for a sentence.
const WIDTH: f32 = 460.0;
/// More than this are not shown at once.
const MOST: usize = 4;

#[derive(Clone, Debug)]
struct Toast {
    text: String,
    details: Option<String>,
    is_error: bool,
    saved: Option<PathBuf>,
    since_secs: f64,
    shows_details: bool,
}

/// All that is shown.
#[derive(Debug, Default)]
pub struct Toasts {
    shown: Vec<Toast>,
}

impl Toasts {
    /// Something went well, or a person should know of it.
    pub fn info(&mut self, text: &str) {
        self.add(text, None, false, None);
    }

    /// Something failed. The sentence is "what — why — what to do"; what and what to do are shown, all of it under
    /// "Details".
    pub fn error(&mut self, sentence: &str) {
        log::warn!("{sentence}");
        let parts: Vec<&str> = sentence.split(" — ").collect();
        let short = match parts.as_slice() {
            [what, .., advice] => format!("{} — {}", capital(what), without_path(advice)),
            _ => capital(sentence),
        };
        self.add(&short, Some(capital(sentence)), true, None);
    }

    /// A file was written.
    pub fn saved(&mut self, path: PathBuf) {
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        self.add(&format!("Saved {name}"), None, false, Some(path.clone()));
    }

    fn add(&mut self, text: &str, details: Option<String>, is_error: bool, saved: Option<PathBuf>) {
        let is_said = |toast: &Toast| toast.text == text;
        self.shown.retain(|toast| !is_said(toast));
        let since_secs = now();
        self.shown.push(Toast { text: text.to_owned(), details, is_error, saved, since_secs, shows_details: false });
        let over = self.shown.len().saturating_sub(MOST);
        self.shown.drain(..over);
    }

    /// What was told last, while it is shown.
    pub fn last(&self) -> Option<&str> {
        self.shown.last().map(|toast| toast.text.as_str())
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
        ui.label(RichText::new(&toast.text).color(colors.strong));
        if toast.shows_details
            && let Some(details) = &toast.details
        {
            ui.label(RichText::new(details).small().color(colors.weak));
        }
        ui.horizontal(|ui| {
            if toast.details.is_some() {
                let label = if toast.shows_details { "Less" } else { "Details" };
                if widgets::link(ui, label).clicked() {
                    toast.shows_details = !toast.shows_details;
                }
            }
            if let Some(path) = &toast.saved
                && widgets::link(ui, "Show in folder").clicked()
            {
                show_in_folder(path);
            }
            if widgets::link(ui, "Close").clicked() {
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

fn capital(text: &str) -> String {
    let mut chars = text.chars();
    chars.next().map(|first| first.to_uppercase().chain(chars).collect()).unwrap_or_default()
}

/// Advice without the path behind it, which is under "Details".
fn without_path(advice: &str) -> &str {
    advice.split(": ").next().unwrap_or(advice)
}
