//! The rules that can be meant by a file, before it has been tried.

use super::error::AdoptError;
use super::family::{Colours, Family, Side};
use crate::synth::tract::{Port, Scale, Signs};
use crate::synth::{ColourOrder, Layout, RelativeOutput, RelativeRules};

/// All but the colours and the sense of its numbers.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Draft {
    pub rules: RelativeRules,
    pub long_side: u32,
    pub multiple_of: u32,
    /// The colours that can be meant, the likeliest first.
    pub colours: Vec<(Colours, ColourOrder)>,
}

/// The picture's side where neither file nor family says it.
const SIDE: u32 = 384;
/// Tokens that a net with such an input gets: the middle of what its authors use.
const TOKENS: f64 = 1800.0;
/// Words in the names of outputs that hold something else than depth.
const NOT_DEPTH: [&str; 10] =
    ["sky", "mask", "normal", "conf", "focal", "fov", "field_of_view", "scale", "intrinsics", "extrinsics"];

/// What can be meant by a file with these signs.
///
/// # Errors
/// No input for a picture, or several; inputs that nobody here knows; no output that can be a map.
pub(super) fn draft(signs: &Signs, family: Option<&Family>) -> Result<Draft, AdoptError> {
    let picture = picture(signs)?;
    let output = map(signs, family)?;
    let (layout, sides) = layout(picture);
    let side = family.map_or(Side::Long(SIDE), |family| family.side);
    let multiple_of = family.map_or(signs.patch.map_or(32, |[patch, _]| patch as u32), |family| family.multiple);
    let mut rules = RelativeRules { layout, output_name: output.name.clone(), ..RelativeRules::default() };
    rules.extra_inputs = extra_inputs(signs, picture)?;
    rules.output = family.map_or(RelativeOutput::Nearness, |family| family.output);
    rules.sky_output = named(signs, |name| name == "sky");
    rules.focal_output = named(signs, |name| name.replace('_', "").contains("focallength"));
    let mut long_side = SIDE;
    match (sides, side) {
        ([Some(h), Some(w)], _) => rules.input_size = [w as u32, h as u32],
        (_, Side::Exactly(w, h)) => rules.input_size = [w, h],
        (_, Side::Long(side)) => long_side = side,
        (_, Side::Short(side)) => rules.short_side = side,
    }
    Ok(Draft { rules, long_side, multiple_of, colours: colours(signs, family) })
}

fn picture(signs: &Signs) -> Result<&Port, AdoptError> {
    let mut pictures = signs.pictures();
    match (pictures.next(), pictures.next()) {
        (Some(picture), None) => Ok(picture),
        (None, _) => Err(AdoptError::NoPicture { inputs: names(&signs.inputs) }),
        (Some(_), Some(_)) => Err(AdoptError::Pictures { inputs: names(&signs.inputs) }),
    }
}

fn extra_inputs(signs: &Signs, picture: &Port) -> Result<std::collections::BTreeMap<String, f64>, AdoptError> {
    let others = signs.inputs.iter().filter(|port| *port != picture);
    let number = |port: &Port| match port.name.as_str() {
        "num_tokens" => Ok((port.name.clone(), TOKENS)),
        _ => Err(AdoptError::ExtraInput { name: port.name.clone() }),
    };
    others.map(number).collect()
}

/// The output that holds the map: the one called depth, else the first that can be.
fn map<'a>(signs: &'a Signs, family: Option<&Family>) -> Result<&'a Port, AdoptError> {
    let points = family.is_some_and(|family| family.output == RelativeOutput::Points);
    let wanted = |port: &&Port| match points {
        true => port.name == "points",
        false => port.is_float && !NOT_DEPTH.iter().any(|word| port.name.to_lowercase().contains(word)),
    };
    let may_be = |port: &&Port| wanted(port) && port.dims.len() != 1;
    let candidates = || signs.outputs.iter().filter(may_be);
    let named = candidates().find(|port| port.name.to_lowercase().contains("depth"));
    named.or_else(|| candidates().next()).ok_or_else(|| AdoptError::NoMap { outputs: names(&signs.outputs) })
}

/// Order of the axes, and height and width as far as they are fixed.
fn layout(picture: &Port) -> (Layout, [Option<usize>; 2]) {
    match picture.dims[..] {
        [_, _, _, h, w] => (Layout::Nvchw, [h, w]),
        [_, h, w, Some(3)] => (Layout::Nhwc, [h, w]),
        [_, _, h, w] => (Layout::Nchw, [h, w]),
        _ => (Layout::Nchw, [None; 2]),
    }
}

/// What the family's authors do comes first; what the net takes off by itself need not be tried.
fn colours(signs: &Signs, family: Option<&Family>) -> Vec<(Colours, ColourOrder)> {
    let all = [Colours::IMAGENET, Colours::HALF, Colours::UNIT, Colours::BYTES];
    let can = match signs.normalises {
        Some(Scale::Unit) => vec![Colours::UNIT, Colours::IMAGENET],
        Some(Scale::Bytes) => vec![Colours::BYTES],
        None => all.to_vec(),
    };
    let mut colours: Vec<_> = family.map(|family| family.colours).into_iter().collect();
    colours.extend(can.into_iter().filter(|can| family.is_none_or(|family| *can != family.colours)));
    let reversed: Vec<_> = colours.iter().take(1).map(|colours| (*colours, ColourOrder::Bgr)).collect();
    colours.into_iter().map(|colours| (colours, ColourOrder::Rgb)).chain(reversed).collect()
}

fn named(signs: &Signs, is: impl Fn(&str) -> bool) -> String {
    let found = signs.outputs.iter().find(|port| is(&port.name.to_lowercase()));
    found.map(|port| port.name.clone()).unwrap_or_default()
}

fn names(ports: &[Port]) -> String {
    let names: Vec<_> = ports.iter().map(|port| port.name.as_str()).collect();
    if names.is_empty() { "none".to_owned() } else { names.join(", ") }
}
