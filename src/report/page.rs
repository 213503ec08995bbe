//! A report as one page of HTML: it loads nothing, is read on a wide or a narrow screen, dark or light.

use super::difference::Codes;
use super::text::{
    can_be_left_out, hardly_shows, megabytes, ms, name, percent, same_stages, trust,
};
use super::{LeftOut, Reference, Report, SEEN, Tried};
use crate::untrusted::Untrusted;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};
use std::fmt::Write;

/// The longest side of a picture on the page, in pixels.
const LONGEST: usize = 640;

/// An error of so many levels is shown white.
const BRIGHTEST: f32 = 8.0;

const STYLE: &str = "\
:root{color-scheme:light dark;--ink:#1b1b1b;--soft:#666;--line:#ddd;--paper:#fff;--mark:#0b62a8}
@media(prefers-color-scheme:dark){:root{--ink:#e6e6e6;--soft:#a0a0a0;--line:#3a3a3a;--paper:#161616;--mark:#6fb7f2}}
body{margin:0 auto;padding:1.2rem;max-width:72rem;font:15px/1.45 system-ui,sans-serif;color:var(--ink);background:var(--paper)}
h1{font-size:1.15rem;margin:0 0 .4rem}h2{font-size:1rem;margin:1.6rem 0 .4rem}
code{font:13px ui-monospace,monospace;overflow-wrap:anywhere}.line{display:block;margin:0 0 .8rem;padding:.6rem .8rem;border:1px solid var(--mark);border-radius:.3rem}
.soft{color:var(--soft)}.say{font-size:1.1rem}
.row{display:flex;flex-wrap:wrap;gap:.8rem}figure{margin:0;flex:1 1 15rem;min-width:0}img{max-width:100%;display:block}figcaption{color:var(--soft);font-size:.85rem}
.wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums}td,th{padding:.15rem .7rem .15rem 0;text-align:right;border-bottom:1px solid var(--line);white-space:nowrap}
td:first-child,th:first-child,table.stages td:last-child{text-align:left}.mark{display:inline-block;width:1.1em;color:var(--mark)}svg{width:100%;max-width:40rem;height:auto}svg text{fill:var(--ink);font:12px system-ui,sans-serif}
.grid{display:grid;grid-template-columns:repeat(auto-fit,minmax(min(100%,29rem),1fr));gap:0 2rem}.bar{display:inline-block;height:.6rem;background:var(--mark)}
tr.given td{font-weight:600}tr.off td{color:var(--soft)}";

/// A picture of 8 bits as a PNG.
pub(super) fn png([width, height]: [usize; 2], codes: &Codes) -> Vec<u8> {
    let rgb = codes.iter().take(width * height);
    let rgb = rgb.flat_map(|[r, g, b, _]| [r, g, b].map(level));
    encoded([width, height], &rgb.collect::<Vec<_>>())
}

/// A code as one of 8 bits.
pub(super) fn level(code: &u16) -> u8 {
    ((u32::from(*code) + 128) / 257) as u8
}

fn encoded([width, height]: [usize; 2], rgb: &[u8]) -> Vec<u8> {
    let mut png = Vec::new();
    PngEncoder::new(&mut png)
        .write_image(rgb, width as u32, height as u32, ExtendedColorType::Rgb8)
        .expect("memory can be written to");
    png
}

/// The page.
pub(crate) fn page(report: &Report) -> String {
    let frame = &report.frame;
    let title = format!(
        "{}, {}x{}",
        Untrusted(&frame.name).html(),
        frame.width,
        frame.height
    );
    let mut body = format!("<h1>relievo report: {title}</h1>\n");
    let command = Untrusted(&report.command).html();
    let _ = writeln!(body, "<p class=\"soft\"><code>{command}</code></p>");
    let _ = writeln!(
        body,
        "<p class=\"say\">{}</p>",
        Untrusted(&report.verdict.sentence).html()
    );
    if let Some(hardly) = hardly_shows(report) {
        let _ = writeln!(body, "<p class=\"say\">{hardly}</p>");
    }
    if let Some(flags) = &report.verdict.flags {
        let _ = writeln!(body, "<code class=\"line\">{command} {flags}</code>");
    }
    body += &pictures(report);
    body += "<div class=\"grid\">\n";
    if report
        .settings
        .iter()
        .any(|setting| setting.error.p99 > 1.0)
    {
        body += &section("Error against time", &plot(&report.settings));
    }
    body += &section("What it can leave out", &left_out(report));
    if let Some(reference) = &report.reference {
        body += &section("Every setting tried", &settings(report, reference));
    }
    if !report.warnings.is_empty() {
        let warnings = report.warnings.iter();
        let warnings = warnings.map(|text| format!("<li>{}</li>\n", Untrusted(text).html()));
        body += &section(
            "Beware",
            &format!("<ul>{}</ul>", warnings.collect::<String>()),
        );
    }
    if report.files.len() > 1 {
        body += &section("The picture as a file", &files(report));
    }
    body += &section("Where the time goes", &stages(report));
    body += "</div>\n";
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"><title>{title}</title>\
         <style>{STYLE}</style></head>\n<body>\n{body}</body></html>\n"
    )
}

fn section(head: &str, body: &str) -> String {
    format!("<section><h2>{head}</h2>\n{body}</section>\n")
}

fn left_out(report: &Report) -> String {
    let (hardly, needed) = can_be_left_out(report);
    let hardly = hardly.into_iter().map(|part| of_part(part, true));
    let needed = needed.into_iter().map(|part| of_part(part, false));
    let head = ["left out", "pixels &gt; 2", "largest", "saves ms", "by"];
    table(&head, hardly.chain(needed))
        + "<p class=\"soft\">Pixels that change by more than 2 grey levels of 255, and the largest change.</p>\n"
}

fn settings(report: &Report, reference: &Reference) -> String {
    let mut tried: Vec<&Tried> = report.settings.iter().collect();
    tried.sort_by(|a, b| b.cost.saved_ms.total_cmp(&a.cost.saved_ms));
    let head = [
        "setting", "p50", "p99", "max", "&gt; 1", "&gt; 2", "CPU ms", "wall",
    ];
    format!(
        "{}<p class=\"soft\">Grey levels of 255 against <code>{}</code>, itself within {:.2} of half its effort (99 % of \
         pixels). \u{25cf} nothing else is both quicker and more exact. ~ timed once. {}</p>\n",
        table(&head, tried.into_iter().map(of_setting)),
        reference.flags,
        reference.own.p99,
        same_stages(report).unwrap_or_default()
    )
}

fn files(report: &Report) -> String {
    let rows = report.files.iter().map(|file| {
        let error = &file.error;
        let cells = [
            file.flags.clone(),
            format!("{:.2}", megabytes(file)),
            ms(file.used.cpu_ms),
            format!("{:.2}", error.p99),
            format!("{:.2}", error.largest),
        ];
        (cells.to_vec(), "")
    });
    table(&["file", "MB", "CPU ms", "p99", "max"], rows)
        + "<p class=\"soft\">Written once, with nothing but the picture; grey levels from the picture as made.</p>\n"
}

fn stages(report: &Report) -> String {
    let files = [
        ("read", report.read.wall_ms),
        ("write (PNG)", report.files[0].used.wall_ms),
    ];
    let stages = files[..1].iter().chain(&report.stages).chain(&files[1..]);
    let whole: f64 = stages.clone().map(|(_, ms)| ms).sum();
    let rows = stages.map(|(stage, time)| {
        let share = time / whole.max(1e-9);
        let bar = format!(
            "<span class=\"bar\" style=\"width:{:.1}rem\"></span>",
            8.0 * share
        );
        (vec![(*stage).into(), ms(*time), percent(share), bar], "")
    });
    table(&["stage", "ms", "share", ""], rows).replace("<table>", "<table class=\"stages\">")
        + &format!("<p class=\"soft\">{}.</p>\n", trust(report))
}

/// A table: its head, and rows of cells with their class.
fn table(head: &[&str], rows: impl Iterator<Item = (Vec<String>, &'static str)>) -> String {
    let cells = |tag: &str, cells: &[String]| -> String {
        cells
            .iter()
            .map(|cell| format!("<{tag}>{cell}</{tag}>"))
            .collect()
    };
    let head: Vec<String> = head.iter().map(ToString::to_string).collect();
    let rows =
        rows.map(|(row, class)| format!("<tr class=\"{class}\">{}</tr>\n", cells("td", &row)));
    let rows: String = rows.collect();
    format!(
        "<div class=\"wide\"><table><tr>{}</tr>\n{rows}</table></div>\n",
        cells("th", &head)
    )
}

fn of_setting(setting: &Tried) -> (Vec<String>, &'static str) {
    let error = &setting.error;
    let once = if setting.cost.is_in_rounds { "" } else { "~" };
    let mark = if setting.is_on_front { "\u{25cf}" } else { "" };
    let name = Untrusted(&name(setting)).html();
    let mut cells = vec![format!("<span class=\"mark\">{mark}</span>{name}")];
    cells.extend([error.p50, error.p99, error.largest].map(|levels| format!("{levels:.2}")));
    cells.extend([error.beyond_1, error.beyond_2].map(percent));
    cells.push(format!("{once}{}", ms(setting.cost.cpu_ms)));
    cells.push(ms(setting.cost.wall_ms));
    let is_given = setting.flags.is_empty();
    (cells, if is_given { "given" } else { "" })
}

fn of_part(part: &LeftOut, is_spare: bool) -> (Vec<String>, &'static str) {
    let saved = match (is_spare, part.cost.saved_ms) {
        (false, _) => String::new(),
        (true, 0.0) => "no difference".into(),
        (true, saved) => ms(saved).replace("--", "-"),
    };
    let cells = vec![
        part.name.into(),
        percent(part.change.beyond_2),
        format!("{:.1}", part.change.largest),
        saved,
        if is_spare {
            format!("<code>{}</code>", part.flags)
        } else {
            "needed".into()
        },
    ];
    (cells, if is_spare { "" } else { "off" })
}

/// The frame before and after, and where it is off.
fn pictures(report: &Report) -> String {
    let shown = &report.pictures;
    let figure = |rgb: Vec<u8>, size: [usize; 2], caption: &str| {
        let data = STANDARD.encode(encoded(size, &rgb));
        format!(
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
        )
    };
    let of_codes = |codes: &Codes, caption: &str| {
        let (rgb, size) = small(shown.size, |i| {
            let [r, g, b, _] = codes[i];
            [r, g, b].map(|code| f32::from(code) / 257.0)
        });
        figure(rgb, size, caption)
    };
    let mut figures = String::new();
    if let Some(before) = &shown.before {
        figures += &of_codes(before, "before");
    }
    figures += &of_codes(&shown.after, "as given");
    if !shown.error.is_empty() && report.settings[0].error.largest >= 1.0 {
        let (rgb, size) = small(shown.size, |i| {
            [255.0 * (shown.error[i] / BRIGHTEST).min(1.0); 3]
        });
        figures += &figure(rgb, size, "error as given: white is 8 levels or more");
    }
    format!("<div class=\"row\">\n{figures}</div>\n")
}

/// A picture made small enough for the page, each pixel the mean of a square, and its size.
fn small([width, height]: [usize; 2], at: impl Fn(usize) -> [f32; 3]) -> (Vec<u8>, [usize; 2]) {
    let step = width.max(height).div_ceil(LONGEST).max(1);
    let size = [width, height].map(|side| side.div_ceil(step));
    let mean = |x: usize, y: usize| {
        let rows = y * step..((y + 1) * step).min(height);
        let columns = x * step..((x + 1) * step).min(width);
        let count = (rows.len() * columns.len()) as f32;
        let mut sum = [0.0_f32; 3];
        for i in rows.flat_map(|y| columns.clone().map(move |x| y * width + x)) {
            let sample = at(i);
            sum.iter_mut().zip(sample).for_each(|(sum, v)| *sum += v);
        }
        sum.map(|sum| (sum / count).round() as u8)
    };
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (x, y)));
    (pixels.flat_map(|(x, y)| mean(x, y)).collect(), size)
}

/// Error against time, both by factors: the settings as points, those that nothing beats joined.
fn plot(settings: &[Tried]) -> String {
    let (width, height, margin) = (640.0, 300.0, 48.0);
    let at: Vec<[f64; 2]> = settings
        .iter()
        .map(|setting| {
            [
                setting.cost.cpu_ms.max(1e-3).log10(),
                setting.error.p99.max(0.01).log10(),
            ]
        })
        .collect();
    let range = |axis: usize| {
        let low = at.iter().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
        let high = at.iter().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
        [low - 0.1, high + 0.15]
    };
    let (across, up) = (range(0), range(1));
    let place = |p: &[f64; 2]| {
        let share = |v: f64, [low, high]: [f64; 2]| (v - low) / (high - low);
        let x = margin + share(p[0], across) * (width - 2.0 * margin);
        let y = height - margin - share(p[1], up) * (height - 1.5 * margin);
        [x, y]
    };
    let mut front: Vec<[f64; 2]> = Vec::new();
    let (mut marks, mut labelled) = (String::new(), Vec::<[f64; 2]>::new());
    for (setting, p) in settings.iter().zip(&at) {
        let [x, y] = place(p);
        if setting.is_on_front {
            front.push([x, y]);
        }
        let fill = if setting.is_on_front {
            "var(--mark)"
        } else {
            "var(--soft)"
        };
        let is_near = |q: &&[f64; 2]| (q[0] - x).abs() < 90.0 && (q[1] - y).abs() < 12.0;
        let label = match &setting.flags[..] {
            "" => "given",
            // What is as good as the command as given, the first, needs no name beside it.
            _ if labelled.iter().any(|q| is_near(&q)) => "",
            flags => flags.trim_start_matches('-'),
        };
        labelled.push([x, y]);
        let _ = writeln!(
            marks,
            "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"4\" fill=\"{fill}\"/><text x=\"{:.1}\" y=\"{:.1}\">{label}</text>",
            x + 7.0,
            y - 5.0
        );
    }
    front.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let front: Vec<_> = front
        .iter()
        .map(|[x, y]| format!("{x:.1},{y:.1}"))
        .collect();
    let (right, floor) = (width - margin, height - margin);
    let mut grid = String::new();
    let seen = place(&[across[0], SEEN.log10()])[1].clamp(0.5 * margin, floor);
    let _ = writeln!(
        grid,
        "<rect x=\"{margin}\" y=\"{seen:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"var(--mark)\" opacity=\".1\"/>\
         <text x=\"{:.1}\" y=\"{:.1}\" >below {SEEN} levels: nobody sees it</text>",
        right - margin,
        floor - seen,
        margin + 6.0,
        floor - 6.0
    );
    for (axis, range) in [(0, across), (1, up)] {
        for value in ticks(range) {
            let mut p = [across[0], up[0]];
            p[axis] = value.log10();
            let [x, y] = place(&p);
            let (to_x, to_y) = if axis == 0 {
                (x, 0.5 * margin)
            } else {
                (right, y)
            };
            let (dx, dy, anchor) = if axis == 0 {
                (0.0, 16.0, "middle")
            } else {
                (-6.0, 4.0, "end")
            };
            let _ = writeln!(
                grid,
                "<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{to_x:.1}\" y2=\"{to_y:.1}\" stroke=\"var(--line)\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{value}</text>",
                x + dx,
                y + dy
            );
        }
    }
    format!(
        "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"error against time\">\n{grid}\
         <polyline points=\"{}\" fill=\"none\" stroke=\"var(--mark)\" stroke-width=\"1.5\"/>\n{marks}\
         <text x=\"{margin}\" y=\"14\">levels off, 99 % of pixels within</text>\
         <text x=\"{right}\" y=\"{:.1}\" text-anchor=\"end\">ms of CPU</text></svg>\n",
        front.join(" "),
        height - 10.0
    )
}

/// Round numbers in a range of decimal logarithms: 1, 2 and 5 times powers of ten, or powers alone where there are many.
fn ticks([low, high]: [f64; 2]) -> Vec<f64> {
    let factors: &[f64] = if high - low > 2.0 {
        &[1.0]
    } else {
        &[1.0, 2.0, 5.0]
    };
    let exponents = low.floor() as i32..=high.ceil() as i32;
    let values =
        exponents.flat_map(|exponent| factors.iter().map(move |f| f * 10_f64.powi(exponent)));
    let inside = values.filter(|value| (low..=high).contains(&value.log10()));
    // 0.1 and the like are no sums of binary fractions.
    inside.map(|value| (value * 1e6).round() / 1e6).collect()
}
