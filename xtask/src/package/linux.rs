//! `.deb`, AppImage and `tar.gz`.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use super::stage::Stage;
use super::{Package, printed};
use crate::run;

/// What opens the window; the command line needs none of it. Loaded when the window opens, so that nothing links to them.
const RECOMMENDS: &str = "libvulkan1, mesa-vulkan-drivers | vulkan-icd, libx11-6, libx11-xcb1, libxcursor1, libxi6, \
    libxkbcommon0, libxkbcommon-x11-0, libwayland-client0";

/// All three; of the AppImage only a sentence where what it needs is not there.
pub(super) fn make(package: &Package, stage: &Stage) -> Result<Vec<PathBuf>> {
    let mut made = vec![tar(package, stage)?];
    match deb(package, stage) {
        Ok(file) => made.push(file),
        Err(error) => eprintln!("\nxtask: NOT MADE: the .deb: {error:#}\n"),
    }
    match app_image(package, stage) {
        Ok(file) => made.push(file),
        Err(error) => eprintln!("\nxtask: NOT MADE: the AppImage: {error:#}\n"),
    }
    if made.len() < 2 && std::env::var_os("CI").is_some() {
        bail!("without dpkg there is no .deb, and CI must make it");
    }
    Ok(made)
}

/// To unpack anywhere: `bin` and `share` in one folder.
fn tar(package: &Package, stage: &Stage) -> Result<PathBuf> {
    let name = format!("plenoscope-{}-{}-linux", package.version, std::env::consts::ARCH);
    let file = package.out.join(format!("{name}.tar.gz"));
    let mut tar = Command::new("tar");
    tar.args(["--create", "--gzip", "--sort=name", "--owner=0", "--group=0", "--numeric-owner"]);
    tar.args([format!("--transform=s,^usr,{name},"), format!("--file={}", file.display())]);
    run(tar.arg("-C").arg(parent(&stage.usr)).arg("usr"))?;
    Ok(file)
}

/// By Debian's own tools; what it depends on dpkg-shlibdeps reads from the program.
fn deb(package: &Package, stage: &Stage) -> Result<PathBuf> {
    let tree = package.out.join("deb");
    copy(&stage.usr, &tree.join("usr"))?;
    let doc = tree.join("usr/share/doc/plenoscope");
    fs::write(doc.join("copyright"), copyright(package)?)?;
    // Debian has the Apache licence itself, and the others stand in `copyright`.
    for name in ["LICENSE-MIT", "LICENSE-APACHE", "fonts-OFL.txt"] {
        fs::remove_file(doc.join(name))?;
    }
    fs::copy(package.root.join("CHANGELOG.md"), doc.join("changelog"))?;
    let pages = fs::read_dir(tree.join("usr/share/man/man1"))?.collect::<std::io::Result<Vec<_>>>()?;
    let pages = pages.iter().map(fs::DirEntry::path);
    let texts = pages.chain(["changelog", "licences-of-crates.txt"].map(|name| doc.join(name)));
    run(Command::new("gzip").args(["-9", "--no-name"]).args(texts))?;
    let architecture = text(Command::new("dpkg").arg("--print-architecture"))?;
    let size_kib = text(Command::new("du").args(["-sk", "--apparent-size"]).arg(tree.join("usr")))?;
    let size_kib = size_kib.split_whitespace().next().unwrap_or("0").to_owned();
    let control = format!(
        "Package: plenoscope\nVersion: {}\nArchitecture: {architecture}\nMaintainer: {MAINTAINER}\n\
         Installed-Size: {size_kib}\nDepends: {}\nRecommends: {RECOMMENDS}\nSection: graphics\nPriority: optional\n\
         Description: look into a photo and refocus it\n Plenoscope turns one photo into a light field, to look round in \
         it, to set\n another focus, and to open the lens further. Window and command line.\n",
        package.version,
        linked_libraries(&tree)?
    );
    fs::create_dir_all(tree.join("DEBIAN"))?;
    fs::write(tree.join("DEBIAN/control"), control)?;
    set_modes(&tree)?;
    let file = package.out.join(format!("plenoscope_{}_{architecture}.deb", package.version));
    run(Command::new("dpkg-deb").args(["--root-owner-group", "-Zxz", "--build"]).arg(&tree).arg(&file))?;
    Ok(file)
}

const MAINTAINER: &str = "Plenoscope contributors <plenoscope@users.noreply.invalid>";

/// Debian's packages of the libraries that the program is linked with, with the versions that it needs.
fn linked_libraries(tree: &Path) -> Result<String> {
    let debian = tree.with_extension("shlibdeps").join("debian");
    fs::create_dir_all(&debian)?;
    fs::write(debian.join("control"), "Source: plenoscope\n\nPackage: plenoscope\nArchitecture: any\n")?;
    let program = tree.join("usr/bin/plenoscope");
    let said = text(Command::new("dpkg-shlibdeps").current_dir(parent(&debian)).arg("-O").arg(program))
        .context("install dpkg-dev")?;
    let found = said.lines().find_map(|line| line.strip_prefix("shlibs:Depends="));
    found.map(str::to_owned).with_context(|| format!("dpkg-shlibdeps says no Depends: {said}"))
}

/// The licences, in the form that Debian reads.
fn copyright(package: &Package) -> Result<String> {
    let indented = |name: &str| -> Result<String> {
        let text = fs::read_to_string(package.root.join(name))?;
        let lines = text.lines().map(|line| if line.trim().is_empty() { " .".to_owned() } else { format!(" {line}") });
        Ok(lines.collect::<Vec<_>>().join("\n"))
    };
    Ok(format!(
        "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/\nUpstream-Name: Plenoscope\n\
         Comment: The crates in the program, with their licences: licences-of-crates.txt.gz beside this file.\n\n\
         Files: *\nCopyright: the Plenoscope contributors\nLicense: Expat or Apache-2.0\n\n\
         Files: models/everyday/*\nCopyright: the Plenoscope contributors; the TensorFlow Authors (its encoder)\n\
         License: Apache-2.0\n\n\
         Files: src/ui/fonts/*\nCopyright: the Inter Project Authors\nLicense: OFL-1.1\n\n\
         License: Expat\n{}\n\nLicense: Apache-2.0\n See /usr/share/common-licenses/Apache-2.0.\n\nLicense: OFL-1.1\n{}\n",
        indented("LICENSE-MIT")?,
        indented("src/ui/fonts/OFL.txt")?
    ))
}

/// One file that runs where it lies. The runtime that mounts it is the AppImage project's own binary.
fn app_image(package: &Package, stage: &Stage) -> Result<PathBuf> {
    let arch = std::env::consts::ARCH;
    let file = package.out.join(format!("Plenoscope-{}-{arch}.AppImage", package.version));
    let runtime = runtime(package, arch)?;
    let tree = package.out.join("AppDir");
    copy(&stage.usr, &tree.join("usr"))?;
    for (link, to) in [
        ("AppRun", "usr/bin/plenoscope"),
        ("plenoscope.desktop", "usr/share/applications/plenoscope.desktop"),
        ("plenoscope.png", "usr/share/icons/hicolor/256x256/apps/plenoscope.png"),
        (".DirIcon", "plenoscope.png"),
    ] {
        symlink(to, tree.join(link))?;
    }
    set_modes(&tree)?;
    let image = package.out.join("AppDir.squashfs");
    // What every runtime reads; those before 2022 know no zstd.
    let options = ["-root-owned", "-noappend", "-comp", "gzip", "-quiet", "-no-progress"];
    run(Command::new("mksquashfs").arg(&tree).arg(&image).args(options)).context("install squashfs-tools")?;
    let mut bytes = runtime;
    bytes.extend(fs::read(&image)?);
    fs::remove_file(&image)?;
    fs::write(&file, bytes)?;
    fs::set_permissions(&file, fs::Permissions::from_mode(0o755))?;
    Ok(file)
}

/// The file that `APPIMAGE_RUNTIME` names, else the one that the AppImage project publishes.
fn runtime(package: &Package, arch: &str) -> Result<Vec<u8>> {
    let named = std::env::var_os("APPIMAGE_RUNTIME").map(PathBuf::from);
    let file = named.clone().unwrap_or_else(|| package.out.join("runtime"));
    let url = format!("https://github.com/AppImage/type2-runtime/releases/download/continuous/runtime-{arch}");
    let how = format!("fetch {url} elsewhere and name the file in APPIMAGE_RUNTIME");
    if named.is_none() {
        run(Command::new("curl")
            .args(["-fsSL", "--connect-timeout", "10", "--max-time", "120", "-o"])
            .arg(&file)
            .arg(url))
        .with_context(|| format!("its runtime cannot be fetched from github.com — {how}"))?;
    }
    let bytes = fs::read(&file).with_context(|| format!("cannot read {}", file.display()))?;
    // ELF, and AppImage's own mark for type 2.
    if !(bytes.starts_with(b"\x7fELF") && bytes.get(8..11) == Some(b"AI\x02")) {
        bail!("this is no runtime of a type-2 AppImage — {how}: {}", file.display());
    }
    Ok(bytes)
}

fn parent(path: &Path) -> &Path {
    path.parent().unwrap_or(Path::new("."))
}

/// Copies a folder.
fn copy(from: &Path, to: &Path) -> Result<()> {
    fs::create_dir_all(parent(to))?;
    run(Command::new("cp").arg("-a").arg(from).arg(to))
}

/// Folders and the program may be entered and run by all, files read.
fn set_modes(tree: &Path) -> Result<()> {
    run(Command::new("chmod").args(["-R", "u=rwX,go=rX"]).arg(tree))
}

fn text(command: &mut Command) -> Result<String> {
    Ok(String::from_utf8_lossy(&printed(command)?).trim().to_owned())
}
