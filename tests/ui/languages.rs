//! A session in German with everything twice as large: what is said, and that nothing lies over anything else.

use egui::accesskit::Role;
use egui::{Key, Modifiers, Rect};
use egui_kittest::kittest::{NodeT as _, Queryable as _};

use crate::common::{Window, german_window, has_device, is_made, steps, wait};

/// What is read or pressed, and so must not be covered.
const SEEN: [Role; 7] =
    [Role::Button, Role::CheckBox, Role::ComboBox, Role::Label, Role::RadioButton, Role::SpinButton, Role::Slider];

/// Everything that lies over something else, by name. What the inspector's views hide is scrolled away, not covered; the
/// edges of what is kept sharp lie on the ruler.
fn overlaps(harness: &Window) -> Vec<String> {
    let views = harness.query_by_label("Alle Ansichten").map(|node| node.rect());
    let is_of_strip = |name: &str| name == "Alle Ansichten" || name.starts_with("Ansicht ");
    let is_scrolled_away = |name: &str, rect: &Rect| {
        !is_of_strip(name)
            && views.is_some_and(|views| rect.bottom() > views.top() && rect.right() > views.left() - 250.0)
    };
    let all: Vec<(Role, String, Rect)> = harness
        .root()
        .children_recursive()
        .filter(|node| SEEN.contains(&node.accesskit_node().role()))
        .map(|node| (node.accesskit_node().role(), node.accesskit_node().label().unwrap_or_default(), node.rect()))
        .filter(|(_, name, rect)| !is_scrolled_away(name, rect))
        .collect();
    let mut over = Vec::new();
    for (i, (role, name, rect)) in all.iter().enumerate() {
        for (other_role, other, theirs) in &all[i + 1..] {
            let is_ruler = (*role, *other_role) == (Role::Slider, Role::Slider);
            if !is_ruler && rect.intersect(*theirs).shrink(1.5).is_positive() {
                over.push(format!("{name} {rect} and {other} {theirs}"));
            }
        }
    }
    assert!(all.len() > 5, "something is there");
    over
}

/// All that is said.
fn said(harness: &Window) -> Vec<String> {
    harness.root().children_recursive().filter_map(|node| node.accesskit_node().label()).collect()
}

#[test]
fn a_session_in_german_at_200_per_cent() {
    if !has_device() {
        return;
    }
    let mut harness = german_window([2100.0, 1400.0]);
    harness.ctx.set_zoom_factor(2.0);
    steps(&mut harness, 4);
    assert_eq!(overlaps(&harness), Vec::<String>::new(), "nothing is open");
    harness.get_by_label("Beispiel ansehen").click();
    wait(&mut harness, "the sample's light field", is_made);
    steps(&mut harness, 10);
    assert_eq!(overlaps(&harness), Vec::<String>::new(), "the sample is open");
    harness.key_press(Key::F);
    steps(&mut harness, 4);
    assert_eq!(overlaps(&harness), Vec::<String>::new(), "the timeline is shown");

    let said = said(&harness);
    assert!(said.iter().any(|text| text.starts_with("Tiefenebene ") && text.ends_with(", f/3,5")), "{said:?}");
    for label in ["Exportieren…", "Blende", "Blickpunkt", "Schlüsselbild setzen", "Strahltiefen"] {
        assert!(said.iter().any(|text| text == label), "{label} is not among {said:?}");
    }
}

#[test]
fn another_language_is_spoken_at_once() {
    if !has_device() {
        return;
    }
    let mut harness = german_window([1000.0, 700.0]);
    steps(&mut harness, 3);
    harness.key_press_modifiers(Modifiers::COMMAND, Key::Comma);
    steps(&mut harness, 4);
    harness.get_by_label("Sprache: Deutsch").click();
    steps(&mut harness, 4);
    harness.get_by_label("English").click();
    steps(&mut harness, 4);
    assert!(harness.query_by_label("Language: English").is_some(), "{:?}", said(&harness));
    assert!(harness.query_by_label("Try the sample").is_some(), "what lies behind speaks it too");
}
