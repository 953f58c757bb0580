//! What is told once: look, focus, export, one after the other, and never again.

use egui::vec2;
use egui_kittest::kittest::Queryable as _;

use crate::common::{button, click, has_device, steps, with_sample};

const ALL: [&str; 3] =
    ["Drag the picture to look round", "Click what should be sharp", "Export saves the picture as you see it"];

#[test]
fn each_hint_goes_once_its_thing_was_done() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([1200.0, 800.0]);
    let is_told = |harness: &mut crate::common::Window, wanted: Option<usize>| {
        steps(harness, 3);
        for (index, text) in ALL.iter().enumerate() {
            assert_eq!(harness.query_by_label(text).is_some(), wanted == Some(index), "{text}");
        }
    };
    is_told(&mut harness, Some(0));
    let at = harness.get_by_label("Picture canvas").rect().center();
    harness.hover_at(at);
    harness.step();
    button(&harness, at, true);
    harness.step();
    for step in 1..=4 {
        harness.hover_at(at + vec2(10.0 * step as f32, 0.0));
        harness.step();
    }
    button(&harness, at + vec2(40.0, 0.0), false);
    is_told(&mut harness, Some(1));
    click(&mut harness, at + vec2(0.0, 160.0));
    is_told(&mut harness, Some(2));
    harness.get_by_label("Export…").click();
    steps(&mut harness, 5);
    harness.key_press(egui::Key::Escape);
    is_told(&mut harness, None);
}

#[test]
fn a_hint_that_is_put_away_does_not_come_back() {
    if !has_device() {
        return;
    }
    let mut harness = with_sample([1000.0, 700.0]);
    for text in ALL {
        steps(&mut harness, 3);
        assert!(harness.query_by_label(text).is_some(), "{text}");
        harness.get_by_label("Got it").click();
        steps(&mut harness, 3);
        assert!(harness.query_by_label(text).is_none(), "{text}");
    }
}
