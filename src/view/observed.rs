//! The window as programs see it that drive it, its tests above all.

use super::app::View;
use super::overlay;
use std::collections::BTreeMap;

impl View {
    /// Whether small pictures of choices are being made.
    pub fn is_drawing_small(&self) -> bool {
        self.thumbnails.is_pending()
    }

    /// The command line that reproduces the picture.
    pub fn command_line(&self) -> Option<String> {
        let frames = self.frames.as_deref();
        Some(self.look.command_line(self.input()?, frames))
    }

    /// The value of a setting that is not at its default; the first, if it has several.
    pub fn value(&self, name: &str) -> Option<&str> {
        self.look.value(name)
    }

    /// The name of the shown layer.
    pub fn layer(&self) -> &'static str {
        self.layer.name()
    }

    /// The command whose picture is shown.
    pub fn command(&self) -> &str {
        self.look.command()
    }

    /// Width, height and pixels of the shown picture: red, green, blue and alpha, as in a PNG.
    pub fn pixels(&self) -> Option<(usize, usize, &[[u8; 4]])> {
        let pixels = &self.shown.as_ref()?.pixels;
        Some((pixels.width, pixels.height, &pixels.rgba))
    }

    /// How often each pass has run on the open frame, named as in
    /// [`Outcome::timings`](crate::plan::outcome::Outcome::timings).
    pub fn counts(&self) -> BTreeMap<&'static str, u32> {
        self.shown
            .as_ref()
            .map_or(BTreeMap::new(), |shown| shown.counts.clone())
    }

    /// Position of the divider between before and after, as a share of the width.
    pub fn split(&self) -> f32 {
        self.canvas.split
    }

    /// The values under the pointer, as lines of text.
    pub fn probed(&self) -> Vec<String> {
        match &self.probed {
            Some((pixel, Some(values))) => overlay::lines_of(*pixel, values),
            _ => Vec::new(),
        }
    }

    /// The last message to the user.
    pub fn said(&self) -> Option<&str> {
        self.said.as_ref().map(|said| said.text.as_str())
    }
}
