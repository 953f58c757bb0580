//! Light fields as files: which format goes where.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use plenoscope::io::formats::{FieldToWrite, eslf, hci, quilt, stanford, views};
use plenoscope::io::save;
use plenoscope::job::Job;
use plenoscope::render::cpu;

use super::input::Scene;
use crate::cli::FieldFormat;

/// Where a light field is written to.
pub struct Target<'a> {
    path: PathBuf,
    format: FieldFormat,
    input: &'a Path,
}

impl<'a> Target<'a> {
    /// A folder of files for most formats; ESLF and quilts are one file: `output` itself where it is named like a
    /// picture, else a file in it that is named after the input.
    pub fn new(output: &Path, format: FieldFormat, input: &'a Path) -> Self {
        let stem = input.file_stem().map_or_else(|| "photo".to_owned(), |stem| stem.to_string_lossy().into_owned());
        let is_file = output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
        let path = match format {
            FieldFormat::Eslf if !is_file => output.join(format!("{stem}_eslf.png")),
            FieldFormat::Quilt if !is_file => output.join(quilt::DEVICES[0].file_name(&stem)),
            _ => output.to_owned(),
        };
        Self { path, format, input }
    }

    /// Refuses to write over the input unless `force` is given.
    pub fn check(&self, force: bool) -> Result<()> {
        if !force && save::same_file(&self.path, self.input) {
            bail!("the output is the input — it would be lost — choose another name: {}", self.path.display());
        }
        Ok(())
    }

    /// Writes the light field.
    pub fn write(&self, scene: &Scene, job: &Job) -> Result<()> {
        let depths = scene.depths(job)?;
        let models: Vec<_> = scene.models.iter().map(|model| (model.id.clone(), model.sha256.clone())).collect();
        let photo = scene.photo.as_deref();
        let source = FieldToWrite { field: &scene.field, depths: Some(&depths), photo, models: &models };
        self.make_folder()?;
        match self.format {
            FieldFormat::Views => views::write(&self.path, &source, job)?,
            FieldFormat::Hci => hci::write(&self.path, &source, job)?,
            FieldFormat::Stanford => stanford::write(&self.path, &source, job)?,
            FieldFormat::Eslf => eslf::write(&self.path, &source, job)?,
            FieldFormat::Quilt => {
                let reach = scene.field.grid().cols() as f32 / 2.0;
                let device = &quilt::DEVICES[0];
                let view = |at| cpu::view_with_depths(&scene.field, Some(&depths), at);
                quilt::write(&device.path(&self.path), device, [-reach, reach - 1.0], &view, job)?;
            }
        }
        Ok(())
    }

    /// Formats of one file may go into a folder that is not there yet.
    fn make_folder(&self) -> Result<()> {
        let Some(folder) = self.path.parent().filter(|folder| !folder.as_os_str().is_empty()) else { return Ok(()) };
        std::fs::create_dir_all(folder).map_err(|error| save::SaveError::from_io(&error, folder).into())
    }
}
