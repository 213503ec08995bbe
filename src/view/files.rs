//! The system's own dialogs. They are asked through the desktop portal on Linux, which needs no library to build with;
//! where there is no desktop to ask, a file is named on the command line or dropped on the window.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};

/// What a chosen file is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Open,
    SaveRecipe,
    SavePicture,
}

/// Dialogs that are open, and files that were chosen.
pub(super) struct Files {
    sender: Sender<(Purpose, PathBuf)>,
    chosen: Receiver<(Purpose, PathBuf)>,
}

impl Files {
    pub(super) fn new() -> Self {
        let (sender, chosen) = channel();
        Self { sender, chosen }
    }

    /// Opens a dialog; `wake` is called when a file has been chosen. `beside` is the picture in hand.
    pub(super) fn ask(
        &self,
        purpose: Purpose,
        beside: Option<&Path>,
        wake: impl Fn() + Send + 'static,
    ) {
        let mut dialog = rfd::AsyncFileDialog::new();
        if let Some(folder) = beside.and_then(Path::parent)
            && !folder.as_os_str().is_empty()
        {
            dialog = dialog.set_directory(folder);
        }
        let stem = beside.and_then(Path::file_stem);
        let stem = stem.map_or("picture".into(), |stem| stem.to_string_lossy().into_owned());
        let sender = self.sender.clone();
        // A dialog is begun where the window is, and waited for elsewhere.
        let asked: std::pin::Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>> =
            match purpose {
                Purpose::Open => Box::pin(dialog.set_title("Open").pick_file()),
                Purpose::SaveRecipe => Box::pin(
                    dialog
                        .set_title("Save recipe")
                        .add_filter("Recipe", &["toml"])
                        .set_file_name(format!("{stem}.toml"))
                        .save_file(),
                ),
                Purpose::SavePicture => Box::pin(
                    dialog
                        .set_title("Save picture")
                        .set_file_name(format!("{stem}.out.png"))
                        .save_file(),
                ),
            };
        std::thread::spawn(move || {
            if let Some(file) = pollster::block_on(asked)
                && sender.send((purpose, file.path().to_path_buf())).is_ok()
            {
                wake();
            }
        });
    }

    /// Files that have been chosen since.
    pub(super) fn chosen(&self) -> Vec<(Purpose, PathBuf)> {
        self.chosen.try_iter().collect()
    }
}

/// Whether a file is a recipe rather than a picture.
pub(super) fn is_recipe(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}
