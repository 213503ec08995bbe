//! Reading some channels of an OpenEXR file, and writing a picture: CPU time and wall time of one.
//!
//! `cargo run --release -p examples --example codec -- read FILE CHANNEL,CHANNEL,... [REPEATS]`
//! `cargo run --release -p examples --example codec -- write FILE COMPRESSION OUTPUT [REPEATS]`
//!
//! `read` decodes the named channels of the first part. `write` reads `R G B A` once and writes them as
//! half floats. The CPU time is that of all threads, user and system, as the kernel counts it.

use relievo::io::exr::{
    ChannelId, ExrFile, Limits, OutputChannel, OutputCompression, OutputPart, OutputType,
    write_results,
};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;
use std::time::{Duration, Instant};

const USAGE: &str =
    "usage: codec read FILE CHANNELS [REPEATS] | write FILE COMPRESSION OUTPUT [REPEATS]";

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

fn main() -> Outcome<()> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    match args[..] {
        ["read", file, names] => read(file, names, 7),
        ["read", file, names, repeats] => read(file, names, repeats.parse()?),
        ["write", file, compression, output] => write(file, compression, output, 7),
        ["write", file, compression, output, n] => write(file, compression, output, n.parse()?),
        _ => Err(USAGE.into()),
    }
}

fn read(path: &str, names: &str, repeats: usize) -> Outcome<()> {
    let names: Vec<&str> = names.split(',').collect();
    let label = format!("read {} channels of {path}", names.len());
    best_of(repeats, &label, || {
        let file = ExrFile::open(Path::new(path), &Limits::default())?;
        file.read_channels(&channels(&file, &names)?)?;
        Ok(())
    })
}

fn write(path: &str, compression: &str, output: &str, repeats: usize) -> Outcome<()> {
    let file = ExrFile::open(Path::new(path), &Limits::default())?;
    let names = ["R", "G", "B", "A"];
    let planes = file.read_channels(&channels(&file, &names)?)?;
    let compression: OutputCompression = compression.parse()?;
    let channels = names.iter().zip(&planes);
    let channels = channels.map(|(&name, plane)| OutputChannel {
        name: name.into(),
        plane,
        sample_type: OutputType::Half,
    });
    let part = OutputPart {
        name: "picture".into(),
        data_window: file.parts[0].window,
        display_window: file.display_window,
        pixel_aspect: file.pixel_aspect,
        channels: channels.collect(),
        attributes: Vec::new(),
        chromaticities: None,
        compression,
    };
    let output = Path::new(output);
    best_of(repeats, &format!("write RGBA half, {compression}"), || {
        write_results(&mut BufWriter::new(File::create(output)?), output, &part)?;
        Ok(())
    })?;
    println!("{} bytes", output.metadata()?.len());
    Ok(())
}

fn channels(file: &ExrFile, names: &[&str]) -> Outcome<Vec<ChannelId>> {
    let find = |name: &&str| {
        let channels = file.parts[0].channels.iter();
        let channel = channels.map(|c| c.name.as_str()).position(|n| n == *name);
        let channel = channel.ok_or_else(|| format!("no channel {name}"))?;
        Ok(ChannelId { part: 0, channel })
    };
    names.iter().map(find).collect()
}

/// Prints the least and the median of CPU and wall time of `repeats` runs, after a warm-up run.
fn best_of(repeats: usize, label: &str, run: impl Fn() -> Outcome<()>) -> Outcome<()> {
    run()?;
    let (mut cpu, mut wall) = (Vec::new(), Vec::new());
    for _ in 0..repeats.max(1) {
        let (start, before) = (Instant::now(), cpu_time()?);
        run()?;
        wall.push(start.elapsed());
        cpu.push(cpu_time()?.saturating_sub(before));
    }
    let told = |mut times: Vec<Duration>| {
        times.sort();
        let [least, median] = [times[0], times[times.len() / 2]].map(|t| 1e3 * t.as_secs_f64());
        format!("{least:.0} ms, median {median:.0}")
    };
    println!("{label}: CPU {}; wall {}", told(cpu), told(wall));
    Ok(())
}

/// The CPU time of this process so far, to a nanosecond; of Linux alone.
fn cpu_time() -> Outcome<Duration> {
    // Threads that have ended are not in the list; those of the pool never end.
    let mut total = Duration::ZERO;
    for thread in std::fs::read_dir("/proc/self/task")? {
        let stat = std::fs::read_to_string(thread?.path().join("schedstat"))?;
        let nanoseconds = stat.split(' ').next().unwrap_or_default();
        total += Duration::from_nanos(nanoseconds.parse()?);
    }
    Ok(total)
}
