//! Colours, type and spacing: no colour literal stands anywhere else in the window.
//!
//! Neutral greys, so that colours can be judged; one accent, amber, for focus, the current view and the main action.

use std::sync::Arc;

use egui::{Color32, CornerRadius, FontData, FontDefinitions, FontFamily, FontId, Stroke, TextStyle, Theme, Visuals};

/// The steps of one theme.
#[derive(Clone, Copy, Debug)]
pub struct Palette {
    /// Around the picture.
    pub surround: Color32,
    /// Panels.
    pub panel: Color32,
    /// Buttons, tracks.
    pub control: Color32,
    /// A control under the pointer, the chosen part of a segmented control.
    pub hovered: Color32,
    /// Wells: what controls lie in.
    pub well: Color32,
    /// Text.
    pub text: Color32,
    /// Numbers and headings that are read first.
    pub strong: Color32,
    /// Labels, hints.
    pub weak: Color32,
    /// Focus, current view, main action.
    pub accent: Color32,
    /// Text on the accent.
    pub on_accent: Color32,
    /// Accent for text and thin lines on a panel.
    pub accent_text: Color32,
    /// Something failed.
    pub error: Color32,
    /// Bars of the histogram.
    pub bar: Color32,
    /// Knobs of switches.
    pub knob: Color32,
}

const AMBER: Color32 = Color32::from_rgb(0xE8, 0xA3, 0x3D);

/// Dark theme.
pub const DARK: Palette = Palette {
    surround: Color32::from_rgb(0x14, 0x15, 0x18),
    panel: Color32::from_rgb(0x1B, 0x1D, 0x21),
    control: Color32::from_rgb(0x2A, 0x2D, 0x33),
    hovered: Color32::from_rgb(0x3A, 0x3E, 0x46),
    well: Color32::from_rgb(0x10, 0x11, 0x13),
    text: Color32::from_rgb(0xD6, 0xD8, 0xDC),
    strong: Color32::from_rgb(0xF4, 0xF5, 0xF6),
    weak: Color32::from_rgb(0xA8, 0xAD, 0xB5),
    accent: AMBER,
    on_accent: Color32::from_rgb(0x1B, 0x1D, 0x21),
    accent_text: AMBER,
    error: Color32::from_rgb(0xF5, 0x8E, 0x80),
    bar: Color32::from_rgb(0x5A, 0x60, 0x6A),
    knob: Color32::from_rgb(0xD6, 0xD8, 0xDC),
};

/// Light theme, with the same steps.
pub const LIGHT: Palette = Palette {
    surround: Color32::from_rgb(0xDD, 0xDF, 0xE2),
    panel: Color32::from_rgb(0xF1, 0xF2, 0xF4),
    control: Color32::from_rgb(0xE0, 0xE2, 0xE6),
    hovered: Color32::from_rgb(0xFF, 0xFF, 0xFF),
    well: Color32::from_rgb(0xD3, 0xD6, 0xDA),
    text: Color32::from_rgb(0x2A, 0x2D, 0x33),
    strong: Color32::from_rgb(0x0E, 0x0F, 0x11),
    weak: Color32::from_rgb(0x56, 0x5B, 0x64),
    accent: AMBER,
    on_accent: Color32::from_rgb(0x1B, 0x1D, 0x21),
    accent_text: Color32::from_rgb(0x7F, 0x4E, 0x00),
    error: Color32::from_rgb(0xA8, 0x29, 0x1B),
    bar: Color32::from_rgb(0x9A, 0xA0, 0xAA),
    knob: Color32::from_rgb(0xFF, 0xFF, 0xFF),
};

/// Veil behind text that lies on a picture, and behind dialogs.
pub const VEIL: Color32 = Color32::from_black_alpha(190);
/// Text on a veil.
pub const ON_VEIL: Color32 = Color32::from_rgb(0xF4, 0xF5, 0xF6);
/// Cross-hairs over a picture: light with a dark rim, so that they show on anything.
pub const HAIR: Color32 = Color32::from_rgba_premultiplied(150, 150, 150, 150);
/// The rim of cross-hairs.
pub const HAIR_RIM: Color32 = Color32::from_black_alpha(90);
/// Edges in focus: a colour that flowers seldom have.
pub const PEAK: Color32 = Color32::from_rgb(0x35, 0xE0, 0xFF);
/// Red, green and blue of a histogram, told apart on dark and on light.
pub const CHANNELS: [Color32; 3] =
    [Color32::from_rgb(0xE0, 0x5A, 0x4E), Color32::from_rgb(0x3F, 0xA9, 0x5C), Color32::from_rgb(0x4C, 0x8D, 0xE8)];
/// Only red, and only green and blue, added to what is there: the pictures of an anaglyph.
pub const EYES: [Color32; 2] =
    [Color32::from_rgba_premultiplied(255, 0, 0, 255), Color32::from_rgba_premultiplied(0, 255, 255, 0)];
/// A picture as it is: egui's tint that changes nothing.
pub const AS_IS: Color32 = Color32::WHITE;

/// Spacing unit, in points.
pub const GRID: f32 = 4.0;
/// Corner radius.
pub const RADIUS: u8 = 6;
/// Corner radius of pictures.
pub const PICTURE_RADIUS: u8 = 3;
/// Width of the inspector.
pub const INSPECTOR_WIDTH: f32 = 312.0;
/// Thickness of the epipolar images.
pub const EPI_THICKNESS: f32 = 76.0;
/// Narrower than this the inspector is a drawer and the epipolar images fold.
pub const NARROW_WIDTH: f32 = 1000.0;

const TEXT_POINTS: f32 = 13.0;
const SMALL_POINTS: f32 = 11.0;

/// The colours of the theme in use.
pub fn palette(ctx: &egui::Context) -> &'static Palette {
    match ctx.theme() {
        Theme::Dark => &DARK,
        Theme::Light => &LIGHT,
    }
}

/// The colours that go with egui's.
pub fn of(visuals: &egui::Visuals) -> &'static Palette {
    if visuals.dark_mode { &DARK } else { &LIGHT }
}

/// 13 px text.
pub fn text() -> FontId {
    FontId::new(TEXT_POINTS, FontFamily::Proportional)
}

/// 11 px text.
pub fn small() -> FontId {
    FontId::new(SMALL_POINTS, FontFamily::Proportional)
}

/// 13 px, medium weight.
pub fn medium() -> FontId {
    FontId::new(TEXT_POINTS, medium_family())
}

/// Section heads.
pub fn head() -> FontId {
    FontId::new(SMALL_POINTS, semibold_family())
}

/// The window's own name, dialog titles.
pub fn title(points: f32) -> FontId {
    FontId::new(points, semibold_family())
}

fn medium_family() -> FontFamily {
    FontFamily::Name("medium".into())
}

fn semibold_family() -> FontFamily {
    FontFamily::Name("semibold".into())
}

/// Sets fonts, spacing and both themes.
pub fn install(ctx: &egui::Context) {
    ctx.set_fonts(fonts());
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (TextStyle::Small, small()),
            (TextStyle::Body, text()),
            (TextStyle::Button, text()),
            (TextStyle::Heading, title(15.0)),
            (TextStyle::Monospace, FontId::new(TEXT_POINTS - 1.0, FontFamily::Monospace)),
        ]
        .into();
        style.animation_time = 0.1;
        style.drag_value_text_style = TextStyle::Body;
        let spacing = &mut style.spacing;
        spacing.item_spacing = egui::vec2(2.0 * GRID, GRID);
        spacing.button_padding = egui::vec2(3.0 * GRID, GRID);
        spacing.interact_size = egui::vec2(28.0, 24.0);
        spacing.menu_margin = egui::Margin::same(6);
        spacing.scroll = egui::style::ScrollStyle::thin();
        style.interaction.tooltip_delay = 0.4;
        style.interaction.selectable_labels = false;
    });
    ctx.set_visuals_of(Theme::Dark, visuals(Visuals::dark(), &DARK));
    ctx.set_visuals_of(Theme::Light, visuals(Visuals::light(), &LIGHT));
}

fn visuals(mut visuals: Visuals, colors: &Palette) -> Visuals {
    let radius = CornerRadius::same(RADIUS);
    let widgets = &mut visuals.widgets;
    let states = [
        (&mut widgets.noninteractive, colors.panel, colors.text),
        (&mut widgets.inactive, colors.control, colors.text),
        (&mut widgets.hovered, colors.hovered, colors.strong),
        (&mut widgets.active, colors.hovered, colors.strong),
        (&mut widgets.open, colors.hovered, colors.strong),
    ];
    for (state, fill, text) in states {
        state.bg_fill = fill;
        state.weak_bg_fill = fill;
        state.bg_stroke = Stroke::NONE;
        state.fg_stroke = Stroke::new(1.0, text);
        state.corner_radius = radius;
        state.expansion = 0.0;
    }
    visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, colors.control);
    visuals.panel_fill = colors.panel;
    visuals.window_fill = colors.panel;
    visuals.window_stroke = Stroke::new(1.0, colors.control);
    visuals.window_corner_radius = CornerRadius::same(10);
    visuals.menu_corner_radius = CornerRadius::same(8);
    visuals.extreme_bg_color = colors.well;
    visuals.faint_bg_color = colors.control;
    visuals.weak_text_color = Some(colors.weak);
    visuals.error_fg_color = colors.error;
    visuals.warn_fg_color = colors.accent_text;
    visuals.hyperlink_color = colors.accent_text;
    visuals.selection.bg_fill = colors.accent.gamma_multiply(0.45);
    visuals.selection.stroke = Stroke::new(1.0, colors.accent_text);
    visuals.text_cursor.stroke.color = colors.accent_text;
    visuals
}

/// Inter with tabular figures; egui's own faces behind it for signs that it lacks.
fn fonts() -> FontDefinitions {
    let mut fonts = FontDefinitions::default();
    let faces: [(&str, &'static [u8]); 3] = [
        ("inter", include_bytes!("fonts/Inter-Regular.otf")),
        ("inter-medium", include_bytes!("fonts/Inter-Medium.otf")),
        ("inter-semibold", include_bytes!("fonts/Inter-SemiBold.otf")),
    ];
    for (name, bytes) in faces {
        fonts.font_data.insert(name.to_owned(), Arc::new(FontData::from_static(bytes)));
    }
    let fallback = fonts.families.get(&FontFamily::Proportional).cloned().unwrap_or_default();
    let families =
        [(FontFamily::Proportional, "inter"), (medium_family(), "inter-medium"), (semibold_family(), "inter-semibold")];
    for (family, face) in families {
        let mut names = vec![face.to_owned()];
        names.extend(fallback.iter().cloned());
        fonts.families.insert(family, names);
    }
    fonts
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Relative luminance (WCAG 2.2).
    fn luminance(color: Color32) -> f32 {
        let linear = |value: u8| match f32::from(value) / 255.0 {
            c if c <= 0.04045 => c / 12.92,
            c => ((c + 0.055) / 1.055).powf(2.4),
        };
        0.2126 * linear(color.r()) + 0.7152 * linear(color.g()) + 0.0722 * linear(color.b())
    }

    fn contrast(a: Color32, b: Color32) -> f32 {
        let (a, b) = (luminance(a), luminance(b));
        (a.max(b) + 0.05) / (a.min(b) + 0.05)
    }

    #[test]
    fn every_text_can_be_read_on_every_ground() {
        for colors in [DARK, LIGHT] {
            let grounds = [colors.surround, colors.panel, colors.control, colors.hovered, colors.well];
            let texts = [colors.text, colors.strong, colors.weak, colors.accent_text, colors.error];
            for (text, ground) in texts.into_iter().flat_map(|text| grounds.map(|ground| (text, ground))) {
                assert!(contrast(text, ground) >= 4.5, "{text:?} on {ground:?}: {}", contrast(text, ground));
            }
            assert!(contrast(colors.on_accent, colors.accent) >= 4.5);
        }
        // The brightest that a veil leaves of a picture.
        let veiled = Color32::from_gray(255 - VEIL.a());
        assert!(contrast(ON_VEIL, veiled) >= 4.5, "{}", contrast(ON_VEIL, veiled));
    }
}
