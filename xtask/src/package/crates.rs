//! The crates in the program: their licences as a text, and an SBOM (CycloneDX 1.5).

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, bail};
use serde::Deserialize;
use serde_json::json;

use super::{Package, printed};

/// What `cargo metadata` says.
#[derive(Deserialize)]
struct Metadata {
    packages: Vec<Crate>,
    resolve: Resolve,
}

/// A crate.
#[derive(Clone, Deserialize)]
pub(super) struct Crate {
    id: String,
    name: String,
    version: String,
    license: Option<String>,
    license_file: Option<String>,
    repository: Option<String>,
    source: Option<String>,
    manifest_path: String,
}

#[derive(Deserialize)]
struct Resolve {
    nodes: Vec<Node>,
}

#[derive(Deserialize)]
struct Node {
    id: String,
    deps: Vec<Dependency>,
}

#[derive(Deserialize)]
struct Dependency {
    pkg: String,
    dep_kinds: Vec<Kind>,
}

/// Null is what ends up in the program; the others are for tests and build scripts.
#[derive(Deserialize)]
struct Kind {
    kind: Option<String>,
}

/// The crates of other people that the program is made of on this system, by name and version.
pub(super) fn of_program(package: &Package) -> Result<Vec<Crate>> {
    let version = printed(Command::new("rustc").arg("-vV"))?;
    let version = String::from_utf8_lossy(&version);
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc names no host")?;
    let mut cargo = Command::new(env!("CARGO"));
    cargo.current_dir(&package.root).args(["metadata", "--format-version=1", "--locked", "--filter-platform", host]);
    let found: Metadata = serde_json::from_slice(&printed(&mut cargo)?)?;
    let app = found.packages.iter().find(|one| one.name == "plenoscope-app").context("there is no plenoscope-app")?;
    let nodes: HashMap<&str, &Node> = found.resolve.nodes.iter().map(|node| (node.id.as_str(), node)).collect();
    let (mut reached, mut open) = (HashSet::new(), vec![app.id.as_str()]);
    while let Some(id) = open.pop() {
        if reached.insert(id) {
            let deps = nodes.get(id).into_iter().flat_map(|node| &node.deps);
            open.extend(deps.filter(|dep| dep.dep_kinds.iter().any(|k| k.kind.is_none())).map(|dep| dep.pkg.as_str()));
        }
    }
    let mut crates: Vec<Crate> =
        found.packages.iter().filter(|one| reached.contains(one.id.as_str())).cloned().collect();
    // Our own have no source.
    crates.retain(|one| one.source.is_some());
    crates.sort_by(|a, b| (&a.name, &a.version).cmp(&(&b.name, &b.version)));
    Ok(crates)
}

/// What is said of the nets, every crate with its licence, then every text once with the crates that bring it.
pub(super) fn licences(root: &Path, crates: &[Crate]) -> Result<Vec<u8>> {
    let nets = fs::read_to_string(root.join("models/NOTICE"))?;
    let mut text = format!(
        "Plenoscope is licensed under MIT or Apache-2.0, as you like.\n\n{nets}\nPlenoscope contains these crates:\n\n"
    );
    let mut texts: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for one in crates {
        let Some(licence) = one.license.as_ref().or(one.license_file.as_ref()) else {
            bail!("{} {} does not say its licence — leave it out, or ask its authors", one.name, one.version);
        };
        writeln!(text, "{} {}  {licence}  {}", one.name, one.version, one.repository.as_deref().unwrap_or_default())?;
        for found in texts_of(one)? {
            texts.entry(found).or_default().push(format!("{} {}", one.name, one.version));
        }
    }
    for (licence, names) in texts {
        write!(text, "\n{}\n{}\n\n{}\n", "=".repeat(80), names.join(", "), licence.trim_end())?;
    }
    Ok(text.into_bytes())
}

/// The texts that lie beside a crate's manifest.
fn texts_of(one: &Crate) -> Result<Vec<String>> {
    let folder = Path::new(&one.manifest_path).parent().unwrap_or(Path::new("."));
    let is_licence = |name: &str| {
        let name = name.to_lowercase();
        ["licen", "copying", "notice", "unlicense", "copyright"].iter().any(|start| name.starts_with(start))
    };
    let mut paths: Vec<_> = fs::read_dir(folder)?.flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.is_file() && is_licence(&path.file_name().unwrap_or_default().to_string_lossy()));
    paths.sort();
    Ok(paths.iter().filter_map(|path| fs::read_to_string(path).ok()).map(|text| text.replace("\r\n", "\n")).collect())
}

/// What the program is made of, for those who look for known weaknesses.
pub(super) fn sbom(package: &Package, crates: &[Crate]) -> String {
    let component = |one: &Crate| {
        let purl = format!("pkg:cargo/{}@{}", one.name, one.version);
        // Old manifests separate alternatives by a slash.
        let licence = one.license.as_ref().map(|text| text.replace(" / ", " OR ").replace('/', " OR "));
        let licences: Vec<_> = licence.into_iter().map(|text| json!({"expression": text})).collect();
        json!({
            "type": "library", "bom-ref": purl, "name": one.name, "version": one.version, "purl": purl, "licenses": licences,
        })
    };
    let own = format!("pkg:cargo/plenoscope-app@{}", package.version);
    let depends: Vec<_> = crates.iter().map(|one| format!("pkg:cargo/{}@{}", one.name, one.version)).collect();
    let bom = json!({
        "bomFormat": "CycloneDX", "specVersion": "1.5", "version": 1,
        "metadata": {"component": {
            "type": "application", "bom-ref": own, "name": "plenoscope", "version": package.version, "purl": own,
            "licenses": [{"expression": "MIT OR Apache-2.0"}],
        }},
        "components": crates.iter().map(component).collect::<Vec<_>>(),
        "dependencies": [{"ref": own, "dependsOn": depends}],
    });
    format!("{bom:#}\n")
}
