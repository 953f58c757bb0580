//! A graphics device that is lost, or has no memory left: the window closes, and the program starts anew.
//!
//! Drivers lose their device when they crash or are replaced, and when a computer wakes up. All that lay on it is gone;
//! what is open is read again, and its edit, which lies beside it.

use std::path::PathBuf;
use std::process::Command;
use std::sync::{Arc, Mutex, PoisonError};

use eframe::egui_wgpu::{NativeAdapterSelectorMethod, RenderState};

/// What became of the window's device.
#[derive(Clone, Default)]
pub struct Loss(Arc<Mutex<Told>>);

#[derive(Default)]
struct Told {
    why: Option<String>,
    open: Option<PathBuf>,
    is_closed: bool,
    device: Option<wgpu::Device>,
}

impl Loss {
    /// Hears of the device's end, on whatever thread; the window then draws once more, to hear of it too.
    pub fn watch(&self, render: &RenderState, ctx: &egui::Context) {
        let (loss, ctx) = (self.clone(), ctx.clone());
        let told = loss.clone();
        render.device.set_device_lost_callback(move |_, text| {
            told.tell(text);
            ctx.request_repaint();
        });
        render.device.on_uncaptured_error(Arc::new(move |error| match error {
            wgpu::Error::OutOfMemory { .. } => loss.tell("it has no memory left".to_owned()),
            // What was made of what could not be made.
            error if loss.why().is_some() => log::warn!("{error}"),
            error => panic!("{error}"),
        }));
        self.told().device = Some(render.device.clone());
        lose_on_demand(render);
    }

    /// After a panic of whoever draws: whether its device was gone. Some drivers tell only who asks.
    pub fn is_why(&self) -> bool {
        let device = self.told().device.clone();
        // What it answers is told to the callback.
        device.iter().for_each(|device| drop(device.poll(wgpu::PollType::Poll)));
        self.why().is_some()
    }

    fn tell(&self, why: String) {
        let why = if why.is_empty() { "its driver does not say why".to_owned() } else { why };
        let mut told = self.told();
        if !told.is_closed {
            log::error!("the graphics device is lost: {why}");
            told.why.get_or_insert(why);
        }
    }

    /// From now on the device may go: the window is closed.
    pub fn close(&self) {
        self.told().is_closed = true;
    }

    /// Why the device is gone; none while it is there.
    pub fn why(&self) -> Option<String> {
        self.told().why.clone()
    }

    /// What was open then.
    pub fn open(&self) -> Option<PathBuf> {
        self.told().open.clone()
    }

    /// Keeps in mind what is to be opened again.
    pub fn remember(&self, open: Option<PathBuf>) {
        self.told().open = open;
    }

    fn told(&self) -> std::sync::MutexGuard<'_, Told> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// How often the window has lost its device, and so which one it opens on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Tried {
    /// Never: the one that its system prefers.
    #[default]
    None,
    /// Once: the same, for a driver that was replaced is there again.
    Once,
    /// Twice: a processor that plays a graphics card, where there is one.
    Twice,
}

impl Tried {
    /// After one more; none where it is enough.
    pub fn next(self) -> Option<Self> {
        match self {
            Self::None => Some(Self::Once),
            Self::Once => Some(Self::Twice),
            Self::Twice => None,
        }
    }

    /// Who chooses the device; none is the system.
    pub fn selector(self) -> Option<NativeAdapterSelectorMethod> {
        let software = |adapters: &[wgpu::Adapter]| {
            adapters.iter().find(|adapter| adapter.get_info().device_type == wgpu::DeviceType::Cpu).cloned()
        };
        (self == Self::Twice).then(|| {
            Arc::new(move |adapters: &[wgpu::Adapter], _: Option<&wgpu::Surface<'_>>| {
                let found = software(adapters).or_else(|| adapters.last().cloned());
                found.ok_or_else(|| "no graphics device is left".to_owned())
            }) as NativeAdapterSelectorMethod
        })
    }
}

/// Times that the device was lost, and what was open then, for the program that takes this one's place.
const TIMES: &str = "PLENOSCOPE_DEVICES_LOST";
const OPEN: &str = "PLENOSCOPE_LOST_FILE";

impl Tried {
    /// What the program before this one had tried, and what it had open.
    pub fn before() -> (Self, Option<PathBuf>) {
        let tried = match std::env::var(TIMES).as_deref() {
            Ok("1") => Self::Once,
            Ok("2") => Self::Twice,
            _ => Self::None,
        };
        (tried, std::env::var_os(OPEN).filter(|_| tried != Self::None).map(PathBuf::from))
    }

    /// Starts this program anew with what was open: a driver that lost its device can be useless to the process that it
    /// served.
    ///
    /// # Errors
    /// The program cannot be started.
    pub fn again(self, open: Option<PathBuf>) -> std::io::Result<()> {
        let mut program = Command::new(std::env::current_exe()?);
        program.args(std::env::args_os().skip(1)).env(TIMES, if self == Self::Once { "1" } else { "2" });
        match open {
            Some(open) => program.env(OPEN, open),
            None => program.env_remove(OPEN),
        };
        start(program)
    }
}

/// In this one's place, so that whoever waits for it goes on waiting.
#[cfg(unix)]
fn start(mut program: Command) -> std::io::Result<()> {
    use std::os::unix::process::CommandExt as _;
    Err(program.exec())
}

#[cfg(not(unix))]
fn start(mut program: Command) -> std::io::Result<()> {
    program.status().map(|_| ())
}

/// To try all this: a debug build loses its device so many seconds after it has it as `PLENOSCOPE_LOSE_DEVICE` says.
fn lose_on_demand(render: &RenderState) {
    let secs = std::env::var("PLENOSCOPE_LOSE_DEVICE").ok().and_then(|secs| secs.parse().ok());
    if let Some(secs) = secs.filter(|_| cfg!(debug_assertions)) {
        let device = render.device.clone();
        let lose = move || {
            std::thread::sleep(std::time::Duration::from_secs_f32(secs));
            device.destroy();
            // Without an ear for it, what draws is the next to find out.
            if std::env::var_os("PLENOSCOPE_LOSE_SILENTLY").is_none() {
                drop(device.poll(wgpu::PollType::Poll));
            }
        };
        drop(std::thread::Builder::new().name("lose".into()).spawn(lose));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_reason_is_the_one_that_is_told() {
        let loss = Loss::default();
        assert_eq!(loss.why(), None);
        loss.tell("a reset".to_owned());
        loss.clone().tell("what came of it".to_owned());
        loss.remember(Some("a.jpg".into()));
        let closed = Loss::default();
        closed.close();
        closed.tell("it goes with its window".to_owned());
        assert_eq!(closed.why(), None);
        assert_eq!((loss.why().as_deref(), loss.open()), (Some("a reset"), Some("a.jpg".into())));
    }

    #[test]
    fn a_device_is_tried_again_then_another_then_none() {
        let tried: Vec<_> = std::iter::successors(Some(Tried::None), |tried| tried.next()).collect();
        assert_eq!(tried, [Tried::None, Tried::Once, Tried::Twice]);
        assert_eq!(tried.iter().filter(|tried| tried.selector().is_some()).collect::<Vec<_>>(), [&Tried::Twice]);
    }
}
