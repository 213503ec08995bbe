//! System file dialogs. On Linux they go through the desktop portal, which needs no library to build; without a
//! desktop, files are named on the command line or dropped on the window.

use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};

/// The use of a chosen file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FilePurpose {
    Open,
    SaveRecipe,
    SavePicture,
    /// A value of this setting.
    Setting(&'static str),
}

/// Open dialogs, and files chosen in them.
pub(super) struct FileDialogs {
    sender: Sender<(FilePurpose, PathBuf)>,
    chosen: Receiver<(FilePurpose, PathBuf)>,
}

impl FileDialogs {
    pub(super) fn new() -> Self {
        let (sender, chosen) = channel();
        Self { sender, chosen }
    }

    /// Opens a dialog, next to the open picture `beside`; `wake` is called once a file is chosen.
    pub(super) fn ask(
        &self,
        purpose: FilePurpose,
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
        // Dialogs are created on the window's thread and awaited on another.
        let asked: std::pin::Pin<Box<dyn Future<Output = Option<rfd::FileHandle>> + Send>> =
            match purpose {
                FilePurpose::Open => Box::pin(dialog.set_title("Open").pick_file()),
                FilePurpose::Setting(name) => Box::pin(dialog.set_title(name).pick_file()),
                FilePurpose::SaveRecipe => Box::pin(
                    dialog
                        .set_title("Save recipe")
                        .add_filter("Recipe", &["toml"])
                        .set_file_name(format!("{stem}.toml"))
                        .save_file(),
                ),
                FilePurpose::SavePicture => Box::pin(
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

    /// Files chosen since the last call.
    pub(super) fn chosen(&self) -> Vec<(FilePurpose, PathBuf)> {
        self.chosen.try_iter().collect()
    }
}

/// Whether a file is a recipe rather than a picture.
pub(super) fn is_recipe(path: &Path) -> bool {
    path.extension()
        .is_some_and(|e| e.eq_ignore_ascii_case("toml"))
}
