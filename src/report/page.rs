//! A report as one page of HTML: it loads nothing, is read on a wide or a narrow screen, dark or light.

use super::difference::Codes;
use super::text::{
    FILE, LEFT_OUT, SETTING, can_be_left_out, cells_of_file, cells_of_part, cells_of_setting,
    hardly_shows, ms, percent, same_stages, trust,
};
use super::{LeftOut, Reference, Report, SEEN, Tried};
use crate::io::picture::{ViewTransform, small_png};
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

const STYLE: &str = include_str!("page.css");

/// A picture of 8 bits as a PNG.
pub(super) fn png([width, height]: [usize; 2], codes: &Codes) -> Vec<u8> {
    let rgb = codes.iter().take(width * height);
    let rgb: Vec<u8> = rgb.flat_map(|[r, g, b, _]| [r, g, b].map(level)).collect();
    let (mut png, [width, height]) = (Vec::new(), [width as u32, height as u32]);
    PngEncoder::new(&mut png)
        .write_image(&rgb, width, height, ExtendedColorType::Rgb8)
        .expect("memory can be written to");
    png
}

/// A code as one of 8 bits.
pub(super) fn level(code: &u16) -> u8 {
    ((u32::from(*code) + 128) / 257) as u8
}

/// The page.
pub(crate) fn page(report: &Report) -> String {
    let frame = &report.frame;
    let (name, width, height) = (Untrusted(&frame.name).html(), frame.width, frame.height);
    let title = format!("{name}, {width}x{height}");
    let mut body = format!("<h1>relievo report: {title}</h1>\n");
    let command = Untrusted(&report.command).html();
    let _ = writeln!(body, "<p class=\"soft\"><code>{command}</code></p>");
    let sentence = Untrusted(&report.verdict.sentence).html();
    let _ = writeln!(body, "<p class=\"say\">{sentence}</p>");
    if let Some(hardly) = hardly_shows(report) {
        let _ = writeln!(body, "<p class=\"say\">{hardly}</p>");
    }
    if let Some(flags) = &report.verdict.flags {
        let _ = writeln!(body, "<code class=\"line\">{command} {flags}</code>");
    }
    body += &pictures(report);
    body += "<div class=\"grid\">\n";
    if report.settings.iter().any(|tried| tried.error.p99 > 1.0) {
        body += &section("Error against time", &plot(&report.settings));
    }
    body += &section("What it can leave out", &left_out(report));
    if let Some(reference) = &report.reference {
        body += &section("Every setting tried", &settings(report, reference));
    }
    if !report.warnings.is_empty() {
        let warnings = report.warnings.iter();
        let warnings = warnings.map(|text| format!("<li>{}</li>\n", Untrusted(text).html()));
        let warnings: String = warnings.collect();
        body += &section("Beware", &format!("<ul>{warnings}</ul>"));
    }
    if report.files.len() > 1 {
        body += &section("The picture as a file", &files(report));
    }
    body += &section("Where the time goes", &stages(report));
    body += "</div>\n";
    format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; style-src 'unsafe-inline'; img-src data:\">\
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
    table(&LEFT_OUT, hardly.chain(needed))
        + "<p class=\"soft\">Pixels that change by more than 2 grey levels of 255, and the largest change.</p>\n"
}

fn settings(report: &Report, reference: &Reference) -> String {
    let mut tried: Vec<&Tried> = report.settings.iter().collect();
    tried.sort_by(|a, b| b.cost.saved_ms.total_cmp(&a.cost.saved_ms));
    format!(
        "{}<p class=\"soft\">Grey levels of 255 against <code>{}</code>, itself within {:.2} of half its effort (99 % of \
         pixels). \u{25cf} nothing else is both quicker and more exact. ~ timed once. {}</p>\n",
        table(&SETTING, tried.into_iter().map(of_setting)),
        reference.flags,
        reference.own.p99,
        same_stages(report).unwrap_or_default()
    )
}

fn files(report: &Report) -> String {
    let rows = report.files.iter();
    table(&FILE, rows.map(|file| (cells_of_file(file).to_vec(), "")))
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
    let head = head.iter().map(|head| head.replace('>', "&gt;"));
    let head: Vec<String> = head.collect();
    let rows =
        rows.map(|(row, class)| format!("<tr class=\"{class}\">{}</tr>\n", cells("td", &row)));
    let rows: String = rows.collect();
    format!(
        "<div class=\"wide\"><table><tr>{}</tr>\n{rows}</table></div>\n",
        cells("th", &head)
    )
}

fn of_setting(setting: &Tried) -> (Vec<String>, &'static str) {
    let mark = if setting.is_on_front { "\u{25cf}" } else { "" };
    let mut cells = cells_of_setting(setting).to_vec();
    let name = Untrusted(&cells[0]).html();
    cells[0] = format!("<span class=\"mark\">{mark}</span>{name}");
    (
        cells,
        if setting.flags.is_empty() {
            "given"
        } else {
            ""
        },
    )
}

fn of_part(part: &LeftOut, is_spare: bool) -> (Vec<String>, &'static str) {
    let mut cells = cells_of_part(part).to_vec();
    if is_spare {
        cells[4] = format!("<code>{}</code>", cells[4]);
        return (cells, "");
    }
    (cells[3], cells[4]) = (String::new(), "needed".into());
    (cells, "off")
}

/// The frame before and after, and where it is off.
fn pictures(report: &Report) -> String {
    let shown = &report.pictures;
    let (width, size) = (shown.size[0], shown.size);
    let figure = |caption: &str, at: &dyn Fn(usize, usize) -> f32| {
        let at = |x: usize, y: usize, c: usize| at(y * width + x, c);
        let png = small_png(size, LONGEST, at, ViewTransform::None);
        let data = STANDARD.encode(png.expect("memory can be written to"));
        format!(
            "<figure><img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"><figcaption>{caption}</figcaption></figure>\n"
        )
    };
    let of_codes = |codes: &Codes, caption: &str| {
        figure(caption, &|i, c| {
            f32::from(codes[i][c]) / f32::from(u16::MAX)
        })
    };
    let mut figures = String::new();
    if let Some(before) = &shown.before {
        figures += &of_codes(before, "before");
    }
    figures += &of_codes(&shown.after, "as given");
    if !shown.error.is_empty() && report.settings[0].error.largest >= 1.0 {
        let caption = "error as given: white is 8 levels or more";
        figures += &figure(caption, &|i, _| shown.error[i] / BRIGHTEST);
    }
    format!("<div class=\"row\">\n{figures}</div>\n")
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
        let fill = ["var(--soft)", "var(--mark)"][usize::from(setting.is_on_front)];
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
    let front = front.iter().map(|[x, y]| format!("{x:.1},{y:.1}"));
    let front: Vec<_> = front.collect();
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
            let (to, label, anchor) = match axis {
                0 => ([x, 0.5 * margin], [x, y + 16.0], "middle"),
                _ => ([right, y], [x - 6.0, y + 4.0], "end"),
            };
            let _ = writeln!(
                grid,
                "<line x1=\"{x:.1}\" y1=\"{y:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"var(--line)\"/>\
                 <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"{anchor}\">{value}</text>",
                to[0], to[1], label[0], label[1]
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
