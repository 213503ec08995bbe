//! Input files whose header has been read, and their companion files.

use super::exr::{self, ChannelId, ExrFile, Limits};
use super::groups::{self, Groups};
use super::inputs::Inputs;
use super::map_codes::MapCodes;
use super::nearest;
use super::normal_encoding::holds_normals;
use super::numbers::{NUMBERED, RoleByNumbers, roles_by_numbers};
use super::open::open_input;
use super::photo::{PhotoHeader, StoredPhoto, is_inside};
use super::roles::{self, Layer, Match, Role};
use super::views;
use crate::error::{Error, Result};
use crate::frame::Window;
use crate::untrusted::listed;
use image::DynamicImage;
use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::rc::Rc;
use std::sync::{Arc, OnceLock};

/// An input file whose header has been read: an EXR's layers, or a photo.
pub(super) enum Opened {
    Exr {
        file: Box<ExrFile>,
        /// Its layers, of one view and one group if there are several.
        layers: Vec<Layer>,
        groups: Groups,
        /// All views, and the one in use.
        views: Vec<String>,
        view: Option<String>,
        /// The roles found by numbers, computed when first needed.
        by_numbers: OnceCell<Vec<RoleByNumbers>>,
        companions: Companions,
    },
    Photo {
        photo: StoredPhoto,
        judged: Judged,
        companions: Companions,
    },
}

/// What is found of a photo when it is first asked for.
#[derive(Debug, Clone, Default)]
pub(super) struct Judged {
    /// Whether it is a normal map.
    is_normal_map: OnceLock<bool>,
    /// What its codes hold, if it is one.
    codes: OnceLock<MapCodes>,
    /// The noise of its slopes, if it is one.
    pub(super) noise: OnceLock<f32>,
}

/// Which of a file's layers are wanted: those of a view, and of a group; the default ones where none is named.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Selection<'a> {
    view: Option<&'a str>,
    layer: Option<&'a str>,
}

impl<'a> Selection<'a> {
    pub(super) fn of(inputs: &'a Inputs) -> Self {
        Self {
            view: inputs.view.as_deref(),
            layer: inputs.layer.as_deref(),
        }
    }
}

/// Files opened as companions of another.
pub(super) struct Companions {
    files: RefCell<Vec<(PathBuf, Rc<Opened>)>>,
    pub(super) holding: Holding,
}

/// Policy for holding the decoded samples of photos.
#[derive(Clone)]
pub(super) struct Holding {
    /// Most bytes of samples of one photo: of others rows alone are read.
    pub(super) most_bytes: u64,
    /// Whether they are kept for the next rows.
    pub(super) stay: bool,
    /// Columns and rows of the cells that photos consist of, if they are sheets.
    pub(super) cell: Option<[usize; 2]>,
    /// The part that is taken of photos, where these are decoded already.
    pub(super) part: Option<PartOfPhotos>,
}

/// A part of photos that are decoded: it is read on any thread.
#[derive(Clone)]
pub(crate) struct PartOfPhotos {
    pub(crate) photos: Arc<Vec<WholePhoto>>,
    pub(crate) window: Window,
}

/// A decoded photo, and what was judged of the whole of it.
pub(crate) struct WholePhoto {
    header: PhotoHeader,
    samples: Arc<DynamicImage>,
    judged: Judged,
}

impl Default for Holding {
    fn default() -> Self {
        Self {
            most_bytes: u64::MAX,
            stay: false,
            cell: None,
            part: None,
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

impl PartOfPhotos {
    /// The part of the photo at `path`; `None` if it is not one of them.
    fn of(&self, path: &Path) -> Option<(StoredPhoto, Judged)> {
        let whole = self.photos.iter().find(|whole| whole.header.path == path)?;
        let part = StoredPhoto::part(&whole.header, &whole.samples, self.window);
        Some((part, whole.judged.clone()))
    }
}

impl Opened {
    pub(super) fn open(path: &Path) -> Result<Rc<Self>> {
        Self::open_held(path, Selection::default(), Holding::default())
    }

    /// The picture of `inputs`.
    pub(super) fn open_picture(inputs: &Inputs) -> Result<Rc<Self>> {
        Self::open_held(&inputs.picture, Selection::of(inputs), Holding::default())
    }

    /// The file with the layers that are wanted, and the policy for samples of photos.
    pub(super) fn open_held(path: &Path, wanted: Selection, holding: Holding) -> Result<Rc<Self>> {
        let taken = holding.part.as_ref().and_then(|part| part.of(path));
        let (most_bytes, cell) = (holding.most_bytes, holding.cell);
        let companions = Companions::held(holding);
        if let Some((photo, judged)) = taken {
            return Ok(Rc::new(Self::Photo {
                photo,
                judged,
                companions,
            }));
        }
        if is_inside(path) || !has_exr_magic(path)? {
            groups::refuse(wanted.layer, path)?;
            let mut photo = StoredPhoto::open(path, most_bytes)?;
            if let Some([width, height]) = cell {
                photo.cell = [
                    width.min(photo.header.width),
                    height.min(photo.header.height),
                ];
            }
            return Ok(Rc::new(Self::Photo {
                photo,
                judged: Judged::default(),
                companions,
            }));
        }
        let file = Box::new(ExrFile::open(path, &Limits::default())?);
        let mut layers = layers_of(&file);
        let all = views::mark(&file, &mut layers);
        let view = views::keep(&file, &mut layers, &all, wanted.view)?;
        let groups = groups::keep(&file, &mut layers, wanted.layer)?;
        Ok(Rc::new(Self::Exr {
            file,
            layers,
            groups,
            views: all,
            view,
            by_numbers: OnceCell::new(),
            companions,
        }))
    }

    /// A companion file: of the same view and group, if it has several. It is opened once.
    pub(super) fn open_companion(&self, path: &Path) -> Result<Rc<Self>> {
        let (Self::Exr { companions, .. } | Self::Photo { companions, .. }) = self;
        if let Some(file) = companions.find(path) {
            return Ok(file);
        }
        let open = |wanted| Self::open_held(path, wanted, companions.holding.clone());
        let mut file = open(Selection::default())?;
        let wanted = self.selection_in(&file);
        if wanted != Selection::default() {
            file = open(wanted)?;
        }
        companions.keep(path, &file);
        Ok(file)
    }

    /// Its own view and group, as far as `other` has several.
    fn selection_in(&self, other: &Self) -> Selection<'_> {
        let (
            Self::Exr { view, groups, .. },
            Self::Exr {
                views,
                groups: there,
                ..
            },
        ) = (self, other)
        else {
            return Selection::default();
        };
        let is_there = |own: &&str| {
            there
                .names
                .iter()
                .any(|name| name.eq_ignore_ascii_case(own))
        };
        Selection {
            view: view.as_deref().filter(|_| !views.is_empty()),
            layer: groups.taken.as_deref().filter(is_there),
        }
    }

    /// The channels of the layer called `name`, for `role`; those of the group in use come first.
    pub(super) fn named(&self, name: &str, role: Role) -> Option<Match> {
        let Self::Exr { layers, groups, .. } = self else {
            return None;
        };
        let sets = [layers, &groups.apart];
        sets.into_iter()
            .find_map(|layers| roles::named(layers, name, role))
    }

    /// Whether a channel belongs to another group than the one in use.
    pub(super) fn is_apart(&self, ChannelId { part, channel }: ChannelId) -> bool {
        let holds = |layer: &Layer| {
            layer.part == part && layer.components.iter().any(|(_, own)| *own == channel)
        };
        matches!(self, Self::Exr { groups, .. } if groups.apart.iter().any(holds))
    }

    /// What was taken of several groups, where none was named.
    pub(super) fn note(&self) -> Option<&str> {
        match self {
            Self::Exr { groups, .. } => groups.note.as_deref(),
            Self::Photo { .. } => None,
        }
    }

    /// All layers that flags can name.
    pub(super) fn all_layers(&self) -> impl Iterator<Item = &Layer> {
        let sets = match self {
            Self::Exr { layers, groups, .. } => [&layers[..], &groups.apart],
            Self::Photo { .. } => [&[][..]; 2],
        };
        sets.into_iter().flatten()
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
            Self::Photo { photo, judged, .. } => *judged.is_normal_map.get_or_init(|| {
                let pair = || self.map_codes()?.pair;
                holds_normals(photo) || pair().is_some_and(|pair| pair.is_sure)
            }),
        }
    }

    /// What the codes of a photo hold, as a normal map.
    pub(super) fn map_codes(&self) -> Option<&MapCodes> {
        match self {
            Self::Exr { .. } => None,
            Self::Photo { photo, judged, .. } => {
                Some(judged.codes.get_or_init(|| MapCodes::of(photo)))
            }
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
        nearest::alike(self.all_layers(), name)
    }

    pub(super) fn path(&self) -> &Path {
        match self {
            Self::Exr { file, .. } => &file.path,
            Self::Photo { photo, .. } => &photo.header.path,
        }
    }

    /// Its photo and its companions, decoded, with what has been judged of them.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for an EXR.
    #[cfg(feature = "cli")]
    pub(super) fn photos(&self) -> Result<Vec<WholePhoto>> {
        let Self::Photo {
            photo,
            judged,
            companions,
        } = self
        else {
            return Err(Error::Unsupported {
                path: self.path().to_path_buf(),
                found: "is an EXR, and the cells of --grid are cut from pictures".into(),
                remedy: "save it as a PNG or TIFF of 16 bits".into(),
            });
        };
        let mut all = vec![WholePhoto {
            header: photo.header.clone(),
            samples: photo.take_samples()?,
            judged: judged.clone(),
        }];
        for (_, file) in companions.files.borrow().iter() {
            all.extend(file.photos()?);
        }
        Ok(all)
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
        self.all_layers().map(layer_label).collect()
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
