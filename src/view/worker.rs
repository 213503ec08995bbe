//! The worker thread, which reads, computes and writes for the window.

use super::arrows::{Arrow, arrows};
use super::layer::{self, ShownLayer};
use super::lights::{Lights, NearLight};
use super::look::{
    LightFile, Look, OneLine, SavePicture, ShownFile, ViewPixels, ViewSession, What, light_files,
};
use super::probe::{self, ProbedValue};
use super::space::{Space, before_the_middle};
use super::thumbnails::{LONGEST, Motif};
use crate::engine::Engine;
use crate::io::output::{Replace, write_text};
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

/// Target latency of a preview in seconds; its pixel step is chosen to meet it.
const SOON: f64 = 0.04;

/// Pixel steps of previews.
const STEPS: [usize; 3] = [1, 2, 4];

/// The picture that is to be shown.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ToShow {
    pub(super) look: Look,
    pub(super) reading: ShownFile,
    pub(super) layer: ShownLayer,
    /// Whether the comparison is wanted too: the same relighting without shape enhancement, or the input picture.
    pub(super) before: bool,
}

/// A picture to make.
#[derive(Debug, Clone)]
pub(super) struct Order {
    pub(super) number: u64,
    pub(super) wanted: ToShow,
    /// The setting being changed; run times are recorded by it.
    pub(super) changed: Option<String>,
    /// Whether it is still being changed: a preview will do.
    pub(super) is_quick: bool,
}

/// A file to save.
#[derive(Debug, Clone)]
pub(super) enum Save {
    Recipe,
    Picture,
}

/// A finished picture.
#[derive(Debug)]
pub(super) struct ShownPicture {
    pub(super) number: u64,
    /// Pixel step of the result; 1 for all pixels.
    pub(super) step: usize,
    /// Width and height of the whole picture, and the pixel aspect ratio (width / height).
    pub(super) size: [usize; 2],
    pub(super) pixel_aspect: f32,
    pub(super) pixels: Arc<ViewPixels>,
    pub(super) before: Option<Arc<ViewPixels>>,
    pub(super) arrows: Vec<Arrow>,
    pub(super) space: Space,
    /// Automatic choices, by setting.
    pub(super) chosen: Vec<(String, String)>,
    pub(super) warnings: Vec<String>,
    pub(super) took: Duration,
    pub(super) counts: BTreeMap<&'static str, u32>,
}

/// A message from the worker.
#[derive(Debug)]
pub(super) enum Reply {
    Shown(Box<ShownPicture>),
    /// The order failed.
    Failed(u64, OneLine),
    /// The values at a pixel.
    Probed([usize; 2], Vec<ProbedValue>),
    /// The outcome of saving a file.
    Saved(Result<PathBuf, OneLine>),
    /// A new light near the surface.
    Placed(Result<NearLight, OneLine>),
    /// What may be light beside a picture.
    Found(Vec<LightFile>),
    /// The small picture of a choice, by its name; `None` if there is none.
    Small((String, Motif), Option<ViewPixels>),
}

/// What the worker is asked for.
#[derive(Debug, Clone)]
pub(super) enum ViewTask {
    Save(Save, Look, ShownFile, PathBuf),
    /// A place for a light near the surface.
    Place(Look, ShownFile),
    Show(Order),
    /// The values at a pixel.
    Probe([usize; 2]),
    /// What may be light beside a picture.
    Search(PathBuf),
    /// The small picture of a choice, by its name.
    Small((String, Motif)),
}

impl ViewTask {
    /// Its place in the order of tasks: files first, then the picture and the values, and small pictures last.
    fn rank(&self) -> usize {
        match self {
            Self::Save(..) => 0,
            Self::Place(..) => 1,
            Self::Show(_) => 2,
            Self::Probe(_) => 3,
            Self::Search(_) => 4,
            Self::Small(_) => 5,
        }
    }
}

#[derive(Default)]
struct Inbox {
    tasks: Vec<ViewTask>,
    has_ended: bool,
}

#[derive(Default)]
struct Shared {
    inbox: Mutex<Inbox>,
    changed: Condvar,
}

impl Shared {
    fn inbox(&self) -> MutexGuard<'_, Inbox> {
        self.inbox.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// The window's handle to the worker.
pub(super) struct Worker {
    shared: Arc<Shared>,
    replies: Receiver<Reply>,
}

impl Worker {
    /// Starts the worker on `engine`, saving pictures with `save`; it calls `wake` after each reply.
    pub(super) fn start(
        engine: Arc<Engine>,
        save: SavePicture,
        wake: impl Fn() + Send + 'static,
    ) -> Self {
        let shared = Arc::new(Shared::default());
        let (sender, replies) = channel();
        let theirs = shared.clone();
        std::thread::spawn(move || {
            let worker = ViewWorker {
                session: ViewSession::new(engine.clone()),
                small: ViewSession::small(engine.clone(), LONGEST),
                engine,
                save,
                times: BTreeMap::new(),
                replies: sender,
            };
            worker.work(&theirs, wake);
        });
        Self { shared, replies }
    }

    /// Asks for something. Every file is saved; of all else only what is asked for last is made.
    pub(super) fn ask(&self, task: ViewTask) {
        self.ask_all(vec![task]);
    }

    /// Asks for several things of a kind.
    pub(super) fn ask_all(&self, mut tasks: Vec<ViewTask>) {
        let waiting = &mut self.shared.inbox().tasks;
        waiting.retain(|old| {
            let is_file = matches!(old, ViewTask::Save(..));
            is_file || tasks.iter().all(|new| new.rank() != old.rank())
        });
        waiting.append(&mut tasks);
        self.shared.changed.notify_one();
    }

    pub(super) fn replies(&self) -> impl Iterator<Item = Reply> + '_ {
        self.replies.try_iter()
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        self.shared.inbox().has_ended = true;
        self.shared.changed.notify_one();
    }
}

/// State of the worker thread.
struct ViewWorker {
    session: ViewSession,
    /// Makes small pictures, of a reduced frame of its own.
    small: ViewSession,
    engine: Arc<Engine>,
    save: SavePicture,
    /// Run times of whole pictures in seconds, by the setting changed.
    times: BTreeMap<Option<String>, f64>,
    replies: Sender<Reply>,
}

impl ViewWorker {
    fn work(mut self, shared: &Shared, wake: impl Fn()) {
        while let Some(task) = next(shared) {
            let tried = catch_unwind(AssertUnwindSafe(|| self.reply(&task)));
            let reply = tried.unwrap_or_else(|_| {
                // The session may hold half-made results after a panic.
                self.session = ViewSession::new(self.engine.clone());
                self.small = ViewSession::small(self.engine.clone(), LONGEST);
                let said =
                    "this is a mistake of relievo's own, reported on stderr; please report it";
                match &task {
                    ViewTask::Show(order) => Some(Reply::Failed(order.number, said.into())),
                    ViewTask::Save(..) => Some(Reply::Saved(Err(said.into()))),
                    ViewTask::Place(..) => Some(Reply::Placed(Err(said.into()))),
                    ViewTask::Small(choice) => Some(Reply::Small(choice.clone(), None)),
                    ViewTask::Probe(_) | ViewTask::Search(_) => None,
                }
            });
            if let Some(reply) = reply {
                if self.replies.send(reply).is_err() {
                    return;
                }
                wake();
            }
        }
    }

    fn reply(&mut self, task: &ViewTask) -> Option<Reply> {
        match task {
            ViewTask::Show(order) => Some(match self.show(order) {
                Ok(shown) => Reply::Shown(Box::new(shown)),
                Err(said) => Reply::Failed(order.number, said),
            }),
            ViewTask::Probe(pixel) => {
                let (frame, outcome) = (self.session.frame()?, self.session.outcome()?);
                let seen = pixel.map(|place| place / self.session.step());
                let values = probe::values(frame, outcome, seen);
                Some(Reply::Probed(*pixel, values))
            }
            ViewTask::Save(save, look, reading, path) => {
                let saved = match save {
                    Save::Recipe => self.save_recipe(look, reading, path),
                    Save::Picture => self.save_picture(look, reading, path),
                };
                Some(Reply::Saved(saved.map(|()| path.clone())))
            }
            ViewTask::Place(look, reading) => Some(Reply::Placed(self.place(look, reading))),
            ViewTask::Search(input) => Some(Reply::Found(light_files(input))),
            ViewTask::Small(choice) => {
                let pixels = match &choice.1 {
                    Motif::Look(look, reading) => {
                        self.small.small_picture(&self.session, look, reading)
                    }
                    Motif::Light(file) => file.small(LONGEST),
                };
                Some(Reply::Small(choice.clone(), pixels))
            }
        }
    }

    fn show(&mut self, order: &Order) -> Result<ShownPicture, OneLine> {
        let start = Instant::now();
        let step = self.step(order);
        let ToShow {
            look,
            reading,
            layer,
            before: is_compared,
        } = &order.wanted;
        let is_compared = *is_compared && *layer == ShownLayer::Picture;
        let mut before = None;
        if let Some(plain) = look.unaltered().filter(|_| is_compared) {
            self.session.make(&plain, reading, What::Picture, step)?;
            before = self.session.picture();
        }
        self.session.make(look, reading, layer.made_of(), step)?;
        let frame = self.session.frame().expect("a picture was made of it");
        let outcome = self.session.outcome().expect("a picture was made");
        let pixels = match layer {
            ShownLayer::Picture | ShownLayer::Curvature => {
                self.session.picture().expect("it was made")
            }
            _ => layer::pixels(*layer, frame, outcome)?,
        };
        let arrows = match layer {
            ShownLayer::Arrows => arrows(outcome, step),
            _ => Vec::new(),
        };
        let step = self.session.step();
        let (size, pixel_aspect) = self.session.size().expect("a frame was read");
        if is_compared && before.is_none() {
            before = self.session.as_it_came();
        }
        let took = start.elapsed();
        if step == 1 {
            let seconds = took.as_secs_f64();
            self.times.insert(order.changed.clone(), seconds);
        }
        Ok(ShownPicture {
            number: order.number,
            step,
            size,
            pixel_aspect,
            pixels: Arc::new(pixels),
            before: before.map(Arc::new),
            arrows,
            space: Space::of(self.session.whole().expect("a frame was read")),
            chosen: self.session.chosen_numbers(),
            warnings: self.session.warnings(),
            took,
            counts: self.session.counts().cloned().unwrap_or_default(),
        })
    }

    /// A place for a light near the surface: the frame is read again, with the depth and camera that such light takes.
    fn place(&mut self, look: &Look, reading: &ShownFile) -> Result<NearLight, OneLine> {
        let mut lit = look.clone();
        let black = NearLight {
            position: [0.0; 3],
            color: Some([0.0; 3]),
        };
        Lights::add_near(&mut lit, black);
        self.session.make(&lit, reading, What::Picture, 1)?;
        let frame = self.session.whole().expect("a frame was read");
        before_the_middle(frame).ok_or_else(|| "there is no surface to light".into())
    }

    /// The pixel step at which a picture meets [`SOON`].
    fn step(&self, order: &Order) -> usize {
        if !order.is_quick {
            return 1;
        }
        let known = self.times.get(&order.changed);
        let longest = || self.times.values().copied().reduce(f64::max);
        let seconds = known.copied().or_else(longest).unwrap_or(0.0);
        let soon = |&step: &usize| seconds / (step * step) as f64 <= SOON;
        let last = STEPS[STEPS.len() - 1];
        STEPS.into_iter().find(soon).unwrap_or(last)
    }

    /// Writes the same recipe as the command line with these settings.
    fn save_recipe(
        &mut self,
        look: &Look,
        reading: &ShownFile,
        path: &Path,
    ) -> Result<(), OneLine> {
        self.session.make(look, reading, What::Picture, 1)?;
        let text = self.session.recipe(look, reading)?;
        let written = write_text(path, Replace::IfWritable, &text);
        written.map_err(|error| error.to_string())
    }

    /// Writes the picture through the command line's own code.
    fn save_picture(&self, look: &Look, reading: &ShownFile, path: &Path) -> Result<(), OneLine> {
        let numbered = reading
            .frame
            .and_then(|frame| crate::io::sequence::path_of_frame(&reading.input, frame));
        (self.save)(look, numbered.as_ref().unwrap_or(&reading.input), path)
    }
}

/// Waits for the next task.
fn next(shared: &Shared) -> Option<ViewTask> {
    let mut inbox = shared.inbox();
    loop {
        if inbox.has_ended {
            return None;
        }
        let tasks = &mut inbox.tasks;
        let first = (0..tasks.len()).min_by_key(|&at| tasks[at].rank());
        if let Some(first) = first {
            return Some(tasks.remove(first));
        }
        inbox = shared
            .changed
            .wait(inbox)
            .unwrap_or_else(PoisonError::into_inner);
    }
}
