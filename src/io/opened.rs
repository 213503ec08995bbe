//! Input files whose header has been read, and their companion files.

use super::exr::{self, ExrFile, Limits};
use super::nearest;
use super::normal_encoding::holds_normals;
use super::numbers::{NUMBERED, RoleByNumbers, roles_by_numbers};
use super::open::open_input;
use super::photo::StoredPhoto;
use super::roles::{self, Layer, Role};
use super::views;
use crate::error::{Error, Result};
use crate::frame::Window;
use crate::untrusted::listed;
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// An input file whose header has been read: an EXR's layers, or a photo.
pub(super) enum Opened {
    Exr {
        file: Box<ExrFile>,
        /// Its layers, of one view if there are several.
        layers: Vec<Layer>,
        /// All views, and the one in use.
        views: Vec<String>,
        view: Option<String>,
        /// The roles found by numbers, computed when first needed.
        by_numbers: OnceCell<Vec<RoleByNumbers>>,
        companions: Companions,
    },
    Photo {
        photo: StoredPhoto,
        /// Whether it is a normal map, found when first asked for.
        is_normal_map: OnceCell<bool>,
        companions: Companions,
    },
}

/// Files opened as companions of another.
pub(super) struct Companions {
    files: RefCell<Vec<(PathBuf, Rc<Opened>)>>,
    pub(super) holding: Holding,
}

/// Policy for holding the decoded samples of photos.
#[derive(Debug, Clone, Copy)]
pub(super) struct Holding {
    /// Most bytes of samples of one photo: of others rows alone are read.
    pub(super) most_bytes: u64,
    /// Whether they are kept for the next rows.
    pub(super) stay: bool,
}

impl Default for Holding {
    fn default() -> Self {
        Self {
            most_bytes: u64::MAX,
            stay: false,
        }
    }
}

impl Companions {
    fn held(holding: Holding) -> Self {
        Self {
            files: RefCell::default(),
            holding,
        }
    }

    fn find(&self, path: &Path) -> Option<Rc<Opened>> {
        let files = self.files.borrow();
        let (_, file) = files.iter().find(|(own, _)| own == path)?;
        Some(file.clone())
    }

    fn keep(&self, path: &Path, file: &Rc<Opened>) {
        self.files.borrow_mut().push((path.into(), file.clone()));
    }
}

impl Opened {
    pub(super) fn open(path: &Path) -> Result<Rc<Self>> {
        Self::open_view(path, None)
    }

    /// The file with the layers of one view: the requested one, else the default.
    pub(super) fn open_view(path: &Path, wanted: Option<&str>) -> Result<Rc<Self>> {
        Self::open_held(path, wanted, Holding::default())
    }

    /// The same, with the policy for samples of photos.
    pub(super) fn open_held(
        path: &Path,
        wanted: Option<&str>,
        holding: Holding,
    ) -> Result<Rc<Self>> {
        let companions = Companions::held(holding);
        if !has_exr_magic(path)? {
            let photo = StoredPhoto::open(path, holding.most_bytes)?;
            return Ok(Rc::new(Self::Photo {
                photo,
                is_normal_map: OnceCell::new(),
                companions,
            }));
        }
        let file = Box::new(ExrFile::open(path, &Limits::default())?);
        let mut layers = layers_of(&file);
        let all = views::mark(&file, &mut layers);
        let view = views::keep(&file, &mut layers, &all, wanted)?;
        Ok(Rc::new(Self::Exr {
            file,
            layers,
            views: all,
            view,
            by_numbers: OnceCell::new(),
            companions,
        }))
    }

    /// A companion file: of the same view, if it has several. It is opened once.
    pub(super) fn open_companion(&self, path: &Path) -> Result<Rc<Self>> {
        let (Self::Exr { companions, .. } | Self::Photo { companions, .. }) = self;
        if let Some(file) = companions.find(path) {
            return Ok(file);
        }
        let open = |view| Self::open_held(path, view, companions.holding);
        let file = open(None)?;
        let file = match (self, file.as_ref()) {
            (
                Self::Exr {
                    view: Some(view), ..
                },
                Self::Exr { views, .. },
            ) if !views.is_empty() => open(Some(view))?,
            _ => file,
        };
        companions.keep(path, &file);
        Ok(file)
    }

    /// The layer that plays `role` by its numbers, where none does by its name.
    pub(super) fn role_by_numbers(&self, role: Role) -> Option<&RoleByNumbers> {
        match self {
            Self::Exr {
                file,
                layers,
                by_numbers,
                ..
            } if NUMBERED.contains(&role) => {
                let by_numbers = by_numbers.get_or_init(|| roles_by_numbers(file, layers));
                by_numbers.iter().find(|found| found.role == role)
            }
            _ => None,
        }
    }

    /// Whether it is a photo whose pixels are normals.
    pub(super) fn is_normal_map(&self) -> bool {
        match self {
            Self::Exr { .. } => false,
            Self::Photo {
                photo,
                is_normal_map,
                ..
            } => *is_normal_map.get_or_init(|| holds_normals(photo)),
        }
    }

    /// The layer that may be meant for `role`, for messages.
    pub(super) fn nearest(&self, role: Role) -> Option<&str> {
        match self {
            Self::Exr { layers, .. } => nearest::nearest(layers, role),
            Self::Photo { .. } => None,
        }
    }

    /// The layer whose name is most like `name`, for messages.
    pub(super) fn alike(&self, name: &str) -> Option<&str> {
        match self {
            Self::Exr { layers, .. } => nearest::alike(layers, name),
            Self::Photo { .. } => None,
        }
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Exr { file, .. } => &file.path,
            Self::Photo { photo, .. } => &photo.header.path,
        }
    }

    /// Releases the samples of photos, its own and those of companion files.
    #[cfg(feature = "cli")]
    pub(super) fn release(&self) {
        let (Self::Exr { companions, .. } | Self::Photo { companions, .. }) = self;
        let files = companions.files.borrow();
        files.iter().for_each(|(_, file)| file.release());
        if let Self::Photo { photo, .. } = self {
            photo.release();
        }
    }

    /// The file's text attributes.
    pub(super) fn attributes(&self) -> Option<&BTreeMap<String, String>> {
        match self {
            Self::Exr { file, .. } => Some(&file.attributes),
            Self::Photo { .. } => None,
        }
    }

    /// The pixels meant to be shown, and a pixel's width over its height. A photo shows the `window` of all that it holds.
    pub(super) fn shown(&self, window: Window) -> (Window, f32) {
        match self {
            Self::Exr { file, .. } => (file.display_window, file.pixel_aspect),
            Self::Photo { .. } => (window, 1.0),
        }
    }

    /// The layers to list in messages, or `otherwise` without any.
    pub(super) fn found(&self, otherwise: &str) -> String {
        match self.layer_names() {
            names if names.is_empty() => otherwise.into(),
            names => listed(&names),
        }
    }

    /// Names of the layers, for messages: a photo has none.
    pub(super) fn layer_names(&self) -> Vec<String> {
        match self {
            Self::Exr { layers, .. } => layers.iter().map(layer_label).collect(),
            Self::Photo { .. } => Vec::new(),
        }
    }
}

/// The layers of all parts and views of a file.
pub(super) fn layers_of(file: &ExrFile) -> Vec<Layer> {
    roles::layers(file.parts.iter().map(|part| {
        let names = part.channels.iter().map(|c| c.name.as_str());
        (part.name.as_deref(), names.collect())
    }))
}

/// A layer's name, or its bare channels where it has none.
fn layer_label(layer: &Layer) -> String {
    if !layer.name.is_empty() {
        return layer.name.clone();
    }
    layer
        .components
        .iter()
        .map(|(c, _)| c.to_ascii_uppercase())
        .collect::<Vec<_>>()
        .join("")
}

fn has_exr_magic(path: &Path) -> Result<bool> {
    use std::io::Read;
    let mut file = open_input(path).map_err(Error::io(path, "read"))?;
    let mut first = [0; 4];
    match file.read_exact(&mut first) {
        Ok(()) => Ok(first == exr::MAGIC),
        Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Ok(false),
        Err(e) => Err(Error::io(path, "read")(e)),
    }
}
