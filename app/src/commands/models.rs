//! `models`: depth nets of other people.

use std::io::Write as _;
use std::path::Path;

use anyhow::{Result, anyhow};
use plenoscope::job::Job;
use plenoscope::render::cpu::{self, Colormap};
use plenoscope::scene::models;
use plenoscope::synth::adopt::{Adopted, Shelf, Shelved};
use serde_json::json;

use super::output::{output, picture};
use crate::cli::{Models, ModelsCommand};

/// Does what was asked for.
pub fn run(args: &Models, job: &Job) -> Result<()> {
    let no_place = "there is no folder for nets — the system names none — set HOME or XDG_DATA_HOME";
    let shelf = Shelf::user().ok_or_else(|| anyhow!(no_place))?;
    match &args.what {
        ModelsCommand::Add { file, name, force, depth } => {
            let net = models::add(file, name.as_deref(), &shelf, *force, job)?;
            if let Some(path) = depth {
                write_depth(&net, path)?;
            }
            say(&added(&net))
        }
        ModelsCommand::List { json: true } => say(&format!("{:#}", as_json(&shelf))),
        ModelsCommand::List { json: false } => say(&as_text(&shelf)),
        ModelsCommand::Remove { name } => Ok(shelf.remove(name)?),
        ModelsCommand::Use { name } => Ok(shelf.prefer(Some(name.as_str()).filter(|name| *name != "network"))?),
    }
}

fn added(net: &Adopted) -> String {
    let (id, summary) = (&net.manifest.id, net.summary());
    format!(
        "{summary}\n\
         It orders the sample's depth with a correlation of {:.2}.\n\
         Use it with --source {id}, or for all photos with `plenoscope models use {id}`.",
        net.correlation
    )
}

/// What the net says of the sample, in colours.
fn write_depth(net: &Adopted, path: &Path) -> Result<()> {
    let seen = cpu::depth_map(&net.depth.disparity(), Colormap::default());
    picture(&output(path, path, true), &seen, None, 8)
}

fn as_text(shelf: &Shelf) -> String {
    let nets = shelf.nets();
    if nets.is_empty() {
        return "No net was added. `plenoscope models add FILE.onnx` adds one.".to_owned();
    }
    nets.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn line(net: &Shelved) -> String {
    let used = if net.is_preferred { " (used for all photos)" } else { "" };
    let megabytes = net.bytes as f64 / 1e6;
    match &net.manifest {
        Ok(manifest) if manifest.licence.is_empty() => format!("{}: {megabytes:.0} MB{used}", net.name),
        Ok(manifest) => format!("{}: {megabytes:.0} MB, {}{used}", net.name, manifest.licence),
        Err(error) => format!("{}: cannot be used: {error}", net.name),
    }
}

fn as_json(shelf: &Shelf) -> serde_json::Value {
    let net = |net: &Shelved| {
        let manifest = net.manifest.as_ref();
        json!({
            "name": net.name, "bytes": net.bytes, "used": net.is_preferred,
            "licence": manifest.ok().map(|manifest| &manifest.licence),
            "sha256": manifest.ok().map(|manifest| &manifest.sha256),
            "fault": manifest.err().map(ToString::to_string),
        })
    };
    json!({ "folder": shelf.folder(), "nets": shelf.nets().iter().map(net).collect::<Vec<_>>() })
}

fn say(text: &str) -> Result<()> {
    Ok(writeln!(std::io::stdout(), "{text}")?)
}
