//! The light fields that were made of the open photo, by how they were made; and which source of depth is looked at in
//! place of the chosen one.

use super::inbox;
use super::open::Made;
use super::window::Window;
use super::words::message;
use crate::scene::{DepthFrom, Making};

/// Memory that light fields which are not shown may take.
const KEPT_BYTES: usize = 768 << 20;

/// What was made of the open photo, and what is compared.
#[derive(Default)]
pub struct Compare {
    /// The latest last.
    kept: Vec<Kept>,
    /// The source that is looked at, or on its way, in place of the chosen one.
    at: Option<DepthFrom>,
}

/// A light field that need not be made again.
#[derive(Clone)]
pub struct Kept {
    /// How it was made.
    making: Making,
    /// The light field.
    pub made: Made,
    /// Its number among the window's light fields.
    pub generation: u64,
}

impl Compare {
    /// Another file is open.
    pub fn forget(&mut self) {
        *self = Self::default();
    }

    /// What hangs on a source is another now.
    pub fn forget_source(&mut self, source: &DepthFrom) {
        self.kept.retain(|kept| kept.making.source != *source);
    }

    /// What is looked at in place of the chosen source.
    pub fn at(&self) -> Option<&DepthFrom> {
        self.at.as_ref()
    }

    /// Looks at another source; none is the chosen one.
    pub fn look_at(&mut self, source: Option<DepthFrom>) {
        self.at = source;
    }

    /// Keeps a light field; the longest unused ones go, but never that of the chosen source.
    pub fn keep(&mut self, making: Making, made: &Made, generation: u64, chosen: &DepthFrom) {
        self.kept.retain(|kept| kept.making != making);
        self.kept.push(Kept { making, made: made.clone(), generation });
        let mut bytes: usize = self.kept.iter().map(|kept| kept.made.bytes()).sum();
        while bytes > KEPT_BYTES {
            let last = self.kept.len() - 1;
            let Some(oldest) = self.kept[..last].iter().position(|kept| kept.making.source != *chosen) else { return };
            bytes -= self.kept.remove(oldest).made.bytes();
        }
    }

    /// What was made so before, which counts as used now.
    pub fn take(&mut self, making: &Making) -> Option<Kept> {
        let index = self.kept.iter().position(|kept| kept.making == *making)?;
        let kept = self.kept.remove(index);
        self.kept.push(kept.clone());
        Some(kept)
    }
}

/// A net goes: what hangs on it takes the automatic choice, once the net is gone.
pub fn lose_net(window: &mut Window, name: &str) {
    let is_it = |source: &DepthFrom| source.net_name() == Some(name);
    window.loses_net = is_it(&window.chosen()) || window.compare.at().is_some_and(is_it);
    for source in [&mut window.source, &mut window.settings.source] {
        if is_it(source) {
            *source = DepthFrom::Auto;
        }
    }
}

/// Makes the open photo's light field as it is chosen now; no other source is compared any longer.
pub fn make_again(window: &mut Window) {
    window.compare.look_at(None);
    let making = window.making();
    if let Some(kept) = window.make(making) {
        inbox::show_again(window, kept);
        inbox::mend_focus(window);
    }
}

/// Shows the next source of depth, round and round.
pub fn next(window: &mut Window) {
    let (all, at) = (window.sources(), window.looked_at());
    if all.len() < 2 {
        return window.toasts.info(message!("one-source"));
    }
    let next = all.iter().position(|(source, _)| *source == at).map_or(0, |index| (index + 1) % all.len());
    let next = all[next].0.clone();
    window.compare.look_at(Some(next).filter(|next| *next != window.chosen()));
    look_at_source(window);
}

/// Back to the chosen source of depth; nothing of the edit has changed.
pub fn back(window: &mut Window) {
    window.compare.look_at(None);
    look_at_source(window);
}

/// Shows a net that is new, or is another now, beside the one before.
pub fn try_net(window: &mut Window, source: DepthFrom) {
    window.compare.forget_source(&source);
    window.compare.look_at(Some(source));
    look_at_source(window);
}

fn look_at_source(window: &mut Window) {
    let source = window.compare.at().cloned().unwrap_or_else(|| window.source.clone());
    let making = Making { source, ..window.making() };
    if window.asked == making && window.loading.running().is_some() {
        return;
    }
    if let Some(kept) = window.make(making) {
        inbox::show_again(window, kept);
    }
}

/// The source that is compared becomes the chosen one.
pub fn keep(window: &mut Window) {
    if let Some(source) = window.compare.at().cloned() {
        window.compare.look_at(None);
        if source != DepthFrom::Map {
            window.settings.source = source.clone();
        }
        window.source = source;
        inbox::mend_focus(window);
    }
}
