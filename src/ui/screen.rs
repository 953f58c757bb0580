//! A window that fits its screen.

use egui::{Context, Vec2, ViewportCommand};

/// What a window's title bar and a desktop's bar take of a screen's height, points.
const BARS_HEIGHT: f32 = 72.0;

/// Lets a window that is too large for its screen fill what the desktop leaves it, so that the status line is not behind
/// a bar. False while the screen is not known yet.
pub fn fit(ctx: &Context) -> bool {
    let (screen, is_full) = ctx.input(|input| (input.viewport().monitor_size, input.viewport().fullscreen));
    let Some(screen) = screen else { return false };
    if is_full != Some(true) && is_too_large(ctx.content_rect().size(), screen) {
        ctx.send_viewport_cmd(ViewportCommand::Maximized(true));
    }
    true
}

fn is_too_large(window: Vec2, screen: Vec2) -> bool {
    window.x > screen.x || window.y > screen.y - BARS_HEIGHT
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_needs_room_for_the_bars_above_and_below_it() {
        let window = Vec2::new(1440.0, 900.0);
        assert!(is_too_large(window, Vec2::new(1440.0, 900.0)));
        assert!(is_too_large(window, Vec2::new(1366.0, 1024.0)));
        assert!(!is_too_large(window, Vec2::new(1920.0, 1080.0)));
        assert!(!is_too_large(Vec2::new(1280.0, 800.0), Vec2::new(1440.0, 900.0)));
    }
}
