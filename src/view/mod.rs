//! The window of `relievo view`: a look is tuned on a picture and saved as a recipe.
//!
//! Pictures are made by the same functions as on the command line, from the same arguments; controls come from the
//! tables of flags. A worker thread does all computation and caches what the next picture can reuse
//! ([`Session`](crate::engine::Session)); the window only sends requests and shows results.

mod actions;
mod app;
mod arrows;
mod ball;
mod canvas;
mod controls;
mod files;
mod flow;
mod gallery;
mod handles;
mod history;
mod layer;
mod light_rows;
mod lights;
pub(crate) mod look;
mod notices;
mod observed;
mod overlay;
mod picks;
mod probe;
mod setting_row;
mod shortcuts;
mod space;
mod texture;
mod thumbnails;
mod toolbar;
mod worker;

pub use app::View;

use crate::error::{Error, Result};
use look::Opening;

/// Opens a window, and returns when it is closed.
///
/// # Errors
/// [`Error::Window`] if no window can be opened.
pub(crate) fn open(opening: Opening) -> Result<()> {
    let viewport = eframe::egui::ViewportBuilder::default()
        .with_title("relievo")
        .with_inner_size([1280.0, 800.0])
        .with_min_inner_size([640.0, 400.0])
        .with_drag_and_drop(true);
    let options = eframe::NativeOptions {
        viewport,
        ..eframe::NativeOptions::default()
    };
    let create: eframe::AppCreator = Box::new(|context| {
        let view = View::of(opening, &context.egui_ctx);
        Ok(Box::new(view))
    });
    eframe::run_native("relievo", options, create).map_err(|error| Error::Window {
        found: format!("no window can be opened ({error})").replace('\n', " "),
        remedy: "it takes a display and Vulkan, Metal, DX12 or GLES (Debian: libvulkan1 mesa-vulkan-drivers)"
            .into(),
    })
}

impl eframe::App for View {
    fn ui(&mut self, ui: &mut eframe::egui::Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }
}
