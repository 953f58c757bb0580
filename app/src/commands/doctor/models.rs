//! The nets that there are, each against its checksum.

use plenoscope::synth::adopt::Shelf;
use plenoscope::synth::{ModelError, ModelSource, Task};

use super::{Section, size};

/// Reads every net and compares it with its manifest.
pub(super) fn look() -> Section {
    let mut section = Section::new("models");
    match ModelSource::Embedded.index() {
        Ok(index) => {
            one(&mut section, &ModelSource::Embedded, &index.depth, Task::RayDepth);
            index.occlusion.iter().for_each(|id| one(&mut section, &ModelSource::Embedded, id, Task::Occlusion));
            for id in ModelSource::Embedded.further_models() {
                one(&mut section, &ModelSource::Embedded, &id, Task::RayDepth);
            }
        }
        Err(error) => section.wrong.push(error.to_string()),
    }
    if let Some(shelf) = Shelf::user() {
        for net in shelf.nets() {
            one(&mut section, &shelf.source(), &net.name, Task::RelativeDepth);
        }
        section.say("used for all photos", shelf.preferred().unwrap_or_else(|| "the program's own".to_owned()));
    }
    section
}

fn one(section: &mut Section, source: &ModelSource, id: &str, task: Task) {
    match check(source, id, task) {
        Ok((sha256, bytes)) => section.say(id, format!("{}, sha256 {sha256}", size(bytes))),
        Err(error) => {
            section.say(id, "cannot be used");
            section.wrong.push(error.to_string());
        }
    }
}

/// Checksum and bytes of a net that is as its manifest says.
fn check(source: &ModelSource, id: &str, task: Task) -> Result<(String, u64), ModelError> {
    let file = source.model(id, task).or_else(|error| match task {
        // What lies beside the pair may be of either kind.
        Task::RayDepth => source.model(id, Task::RelativeDepth).map_err(|_other| error),
        _ => Err(error),
    })?;
    Ok((file.manifest.tag().sha256, file.bytes))
}
