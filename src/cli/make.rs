//! One frame of any command: from its files to its results.

use super::job::{Done, Job};
use super::kit::Kit;
use super::progress::passes_bar;
use super::strip_memory::{goes_in_strips, refuse_large_surroundings};
use super::strips;
use crate::command::chosen::{Chosen, look_at_depth};
use crate::command::map::MapArgs;
use crate::engine::run::ENLARGE;
use crate::engine::{PlanInputs, Progress, Run};
use crate::error::Result;
use crate::frame::{Frame, Plane, SpecularScene};
use crate::io::Loaded;
use crate::io::exr::{OutputChannel, OutputType};
use crate::io::output::OutputKind;
use crate::work::map::MapSamples;
use crate::work::source::FrameSource;
use crate::work::{FrameSeen, Results, shape};
use std::time::Instant;

/// Makes the output of one frame; returns the parameters chosen for it.
pub(super) fn make(kit: &Kit, job: &Job) -> Result<Chosen> {
    let work = job.work();
    let warnings = work.warnings();
    let warnings = kit.warning.iter().chain(&warnings);
    warnings.for_each(|warning| job.warn(warning));
    let mut source = FrameSource::of(work, &kit.light, job.is_in_sequence())?;
    if let Some(motion) = work.motion().filter(|_| job.follows()) {
        source.needs.motion = true;
        source.inputs.motion = motion.layer();
    }
    if work.takes_whole() {
        work.refuse_too_large(&job.args().input)?;
    } else if goes_in_strips(job)? {
        return strips::make(kit, job, source);
    }
    if let Some((inputs, _)) = &source.specular {
        refuse_large_surroundings(job, inputs.surroundings.as_deref())?;
    }
    let (mut loaded, read) = job.load(&source.inputs, source.needs)?;
    let mut scene = kit.scene(work, &source, &mut loaded)?;
    let began = Instant::now();
    let is_alone = !job.is_in_sequence() && job.part.is_none();
    let times = work.times(&loaded.frame, scene.is_some(), is_alone)?;
    let bar = passes_bar(&job.args().run, times != 1.0 && !job.is_in_sequence());
    let warn = |text: &str| bar.suspend(|| job.warn(text));
    let tell = |at: Progress| {
        bar.set_message(at.stage);
        bar.set_position((100.0 * at.done) as u64);
    };
    let run = match bar.is_hidden() {
        true => Run::new().warn(&warn),
        false => Run::new().warn(&warn).progress(&tell),
    };
    let moves = job.index.is_some() && work.motion().is_some();
    // Motion is read beside the frame as it was.
    let small = (moves && times != 1.0).then(|| loaded.frame.clone());
    if times != 1.0 {
        enlarge(job, &mut loaded, &mut scene, times, &run)?;
    }
    let enlarging = began.elapsed();
    let mut made = work.begin(&source.inputs, &loaded.frame)?;
    made.warnings.extend(work.warnings_on(&loaded.frame));
    made.warnings.iter().for_each(|warning| job.warn(warning));
    let mut seen = FrameSeen {
        times,
        moves,
        is_specular: scene.is_some(),
        is_in_sequence: job.is_in_sequence(),
        ..FrameSeen::new(&loaded.frame, &kit.light)
    };
    let (mut plans, light) = (work.plans(&mut seen)?, seen.light);
    look_at_depth(&mut loaded);
    for plan in &mut plans {
        if let Some(part) = job.part {
            part.settle_albedo(plan, &loaded.frame);
        }
        job.tell_plan(plan);
        if work.goes_by_rows() {
            let (engine, frame) = (&kit.engine, &mut loaded.frame);
            let layers = engine.execute_for_rows(plan, frame, PlanInputs::default(), &run)?;
            job.note_gain(plan, layers.outcome.gain);
            job.release_spare_memory(&kit.engine);
            let chosen = job.write_layers(&loaded, &layers, read, |rows| {
                shape::channels(job.args(), &rows.frame, &rows.outcome)
            })?;
            kit.engine.recycle(layers.outcome);
            return Ok(chosen);
        }
        let inputs = PlanInputs {
            specular: scene.as_ref(),
            art_map: kit.art_map.as_ref(),
            ..PlanInputs::lit_by(&light)
        };
        let draw = |frame: &mut Frame, inputs: PlanInputs| {
            kit.engine.execute_sparingly(plan, frame, inputs, &run)
        };
        let outcome = match moves {
            true => kit.drawn_on(job, &mut loaded, small.as_ref(), inputs, draw)?,
            false => draw(&mut loaded.frame, inputs)?,
        };
        job.note_gain(plan, outcome.gain);
        let rest = work.take(&mut made, plan, outcome);
        kit.engine.recycle(rest);
    }
    bar.finish_and_clear();
    if times != 1.0 {
        made.outcome.timings.insert(0, (ENLARGE, enlarging));
    }
    job.keep_picture_alone(&kit.engine, &mut made.outcome);
    let params = &job.args().flags.params;
    made.outcome.mix(&loaded.frame, times, params);
    let Results {
        outcome,
        maps,
        notes,
        ..
    } = made;
    notes.iter().for_each(|note| job.note(note));
    let done = Done {
        loaded,
        outcome,
        read,
    };
    let chosen = match work.maps() {
        Some(args) => write_maps(args, job, &done, &maps)?,
        None => write(job, &done)?,
    };
    kit.engine.recycle(done.outcome);
    Ok(chosen)
}

/// Makes a frame, and what its mirrors show, so many times as large.
fn enlarge(
    job: &Job,
    loaded: &mut Loaded,
    scene: &mut Option<SpecularScene>,
    times: f64,
    run: &Run,
) -> Result<()> {
    let args = job.args();
    let is_layers = !args.output.is_svg() && args.output.kind()? == OutputKind::Exr;
    let refused = if job.part.is_some() {
        Some((
            "makes cells larger than those of the sheet",
            "leave it or --grid out",
        ))
    } else if args.output.color_layer(loaded).is_some() && is_layers {
        let remedy = "give --layers results, or write a picture";
        Some(("makes layers larger than those of the input", remedy))
    } else {
        None
    };
    if let Some((found, remedy)) = refused {
        return Err(args.cannot_enlarge(found.into(), remedy.into()));
    }
    if let Some(scene) = scene {
        *scene = run.install(|| scene.enlarged(&loaded.frame, times));
    }
    loaded.frame = run.enlarged(&loaded.frame, times)?;
    loaded.enlarged = times;
    Ok(())
}

/// Writes a picture, layers, or lines.
fn write(job: &Job, done: &Done) -> Result<Chosen> {
    let (work, frame, outcome) = (job.work(), &done.loaded.frame, &done.outcome);
    if let Some(lines) = work.lines(frame, outcome) {
        return job.write_svg(done, &lines);
    }
    let picture = work.picture(frame, outcome).expect("a picture was made");
    match job.args().output.kind()? {
        OutputKind::Picture(_) => job.write_picture(done, picture),
        _ => job.write_channels(done, work.channels(&done.loaded, outcome, Some(&picture))),
    }
}

/// Writes each map to a file of its own, or all to one EXR.
fn write_maps(args: &MapArgs, job: &Job, done: &Done, samples: &MapSamples) -> Result<Chosen> {
    let (output, frame) = (&job.args().output, &done.loaded.frame);
    let kind = output.kind()?;
    let mut maps = args.made(samples, frame);
    if kind == OutputKind::Exr && !output.is_per_map() {
        let all = maps.try_fold(Vec::new(), |mut all, map| {
            all.extend(map?.named());
            Ok(all)
        })?;
        return job.write_channels(done, channels(args, &all));
    }
    let mut chosen = Chosen::default();
    for map in maps {
        let map = map?;
        let is_picture = matches!(kind, OutputKind::Picture(_));
        let note = map.in_words(&frame.mask, is_picture);
        note.iter().for_each(|note| job.note(note));
        let job = job.writing(&map.part.name);
        chosen = match is_picture {
            true => job.write_picture(done, map.picture(args, frame))?,
            false => job.write_channels(done, channels(args, &map.named()))?,
        };
    }
    Ok(chosen)
}

/// The channels of an EXR that hold maps.
fn channels<'a>(args: &MapArgs, maps: &'a [(String, Plane)]) -> Vec<OutputChannel<'a>> {
    let given = args.work.output.depth_of_output;
    let channel = |(name, plane): &'a (String, Plane)| OutputChannel {
        name: match args.is_of_normals(name) {
            true => name.clone(),
            false => format!("map.{name}"),
        },
        plane,
        sample_type: given.unwrap_or(OutputType::Float),
    };
    maps.iter().map(channel).collect()
}
