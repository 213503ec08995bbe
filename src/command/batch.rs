//! Several independent pictures on one command line, and the names of their outputs.

use super::args::WorkArgs;
use super::output::NAME;
use crate::error::{Error, Result, bad};
use crate::io::output::OutputKind;
use crate::untrusted::{Untrusted, shown};
use std::path::{Path, PathBuf};

/// Several pictures, and their output folder unless the output name has a placeholder.
#[derive(Debug, Clone)]
pub(crate) struct PictureBatch {
    inputs: Vec<PathBuf>,
    folder: Option<PathBuf>,
    /// The output as given, with its placeholders.
    pattern: Option<PathBuf>,
}

impl PictureBatch {
    /// The pictures, in their order.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        self.inputs.iter().map(PathBuf::as_path)
    }

    /// The text that replaces [`NAME`] in files written for `input`.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for one that would lead to another folder.
    pub(crate) fn name_of(input: &Path) -> Result<String> {
        let stem = input.file_stem().unwrap_or_default().to_string_lossy();
        match Untrusted(&stem).path_component() {
            Some(name) => Ok(name.into()),
            None => Err(bad(
                "IN",
                format!(
                    "{} leaves '{stem}' as the name of its results",
                    shown(input)
                ),
                "rename it",
            )),
        }
    }

    /// Restricts `work` to `input`, whose files are called `name`.
    pub(crate) fn give(&self, input: &Path, name: String, work: &mut WorkArgs) {
        work.input = input.to_path_buf();
        work.more.clear();
        match (&self.folder, &self.pattern) {
            (Some(folder), _) => {
                let mut file = input.file_stem().unwrap_or_default().to_os_string();
                file.push(".png");
                work.output.output = Some(folder.join(file));
            }
            (None, Some(pattern)) => work.output.named = Some((pattern.clone(), name)),
            (None, None) => {}
        }
    }
}

impl WorkArgs {
    /// The pictures of the command line, where there are several or the output is a folder.
    ///
    /// # Errors
    /// [`Error::BadParameter`] for a single file shared by all pictures, and for frames combined with several pictures.
    pub(crate) fn batch(&self) -> Result<Option<PictureBatch>> {
        let output = self.output.output.as_deref();
        let folder = output.filter(|output| self.is_folder(output));
        let has_name = |path: &Path| path.to_string_lossy().contains(NAME);
        let is_sequence = self.sequence.frames.is_given();
        let is_named = folder.is_some() || output.is_some_and(has_name);
        if self.more.is_empty() && (is_sequence || !is_named) {
            return Ok(None);
        }
        let files = [
            ("-o", output.filter(|_| folder.is_none())),
            ("--timings", self.run.timings.as_deref()),
            ("--save-recipe", self.run.save_recipe.as_deref()),
        ];
        let one_for_all = |(name, path): (_, Option<&Path>)| {
            let path = path.filter(|path| !has_name(path))?;
            Some((name, path.to_path_buf()))
        };
        match files.into_iter().find_map(one_for_all) {
            Some((name, path)) => return Err(self.one_for_all(name, &path)),
            None if is_sequence => {
                return Err(bad(
                    "--frames",
                    "does not go with several pictures",
                    "give one input with #### for its numbers, or leave it out",
                ));
            }
            None => {}
        }
        let first = std::iter::once(&self.input);
        Ok(Some(PictureBatch {
            inputs: first.chain(&self.more).cloned().collect(),
            folder: folder.map(Path::to_path_buf),
            pattern: output.map(Path::to_path_buf),
        }))
    }

    /// Whether an output is a folder: written as one, or without extension and either existing or shared by several
    /// pictures.
    fn is_folder(&self, output: &Path) -> bool {
        let text = output.to_string_lossy();
        let is_called_so = text.ends_with(std::path::is_separator);
        let may_be_one = output.extension().is_none() && !text.contains(NAME);
        is_called_so || may_be_one && (output.is_dir() || !self.more.is_empty())
    }

    /// Error for a single file shared by all pictures. One of the inputs may have been meant as the output.
    fn one_for_all(&self, name: &'static str, path: &Path) -> Error {
        let is_stray = |path: &&PathBuf| !path.exists() && OutputKind::of(path).is_ok();
        let stray = self.more.iter().find(is_stray);
        let stray = stray.map(|path| path.to_string_lossy());
        let stray = stray.as_deref().map(Untrusted);
        let folder = if name == "-o" { "a folder, or " } else { "" };
        let several = format!("give {folder}a name with {NAME} for theirs");
        bad(
            name,
            format!("{} is one file for all pictures", shown(path)),
            match stray {
                Some(stray) => format!("{several}; to write {stray}, give -o {}", stray.word()),
                None => several,
            },
        )
    }
}
