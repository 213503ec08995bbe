//! The part on light.

use super::{pair, place, table};
use crate::params::Method;
use crate::report::advice::{milliseconds, noun, of_light, rounded, scientific};
use crate::report::light::cost::Cost;
use crate::report::light::equations::Sample;
use crate::report::light::functions::{self, Measured};
use crate::report::light::lit::Difference;
use crate::report::light::{LightReport, REFERENCE_LIGHTS, Subject};

/// Names of the plots of a subject: by number of lights, by equation.
pub fn plot_names(subject: &Subject) -> [String; 2] {
    // A frame is called by its file.
    let name = match subject.name.contains('.') {
        true => "",
        false => &format!("{}-", subject.name),
    };
    ["lights", "equations"].map(|what| format!("{name}{what}.svg"))
}

pub(super) fn section(light: &LightReport) -> String {
    let mut text = format!(
        "## Light\n\n{}\n\nUnder an environment that is a formula: {}. Errors are those of the worst channel, relative \
         to the luminance that 98 pixels in 100 of the reference stay below, *white*; grey levels are steps of 8 bits after \
         the curve of sRGB, where that luminance shows as white. The reference is a picture under {REFERENCE_LIGHTS} even lights, \
         each of which stands for the pixels of the environment nearest to it; warped by equation 2. Highlights are Phong's \
         lobe of exponent 32 alone, normalised. Times are of lighting alone: making the environment ready is told \
         apart, as it is done once for a sequence.\n",
        of_light(light),
        light.environment,
    );
    for subject in &light.subjects {
        text += &of_subject(subject);
    }
    text + &elementary(light) + &cost(&light.cost)
}

fn of_subject(subject: &Subject) -> String {
    let [samples_plot, equations_plot] = plot_names(subject);
    format!(
        "\n### Light on {}\n\nThe middle {}x{} of it, {} pixels covered.\n\n![Error against time by number of lights]({samples_plot})\n\n\
         {}\nBold: on the Pareto front of time and the error of 99 %. {}\n\n\
         Light warping by look-ups that are warped (equation 1) and by lights that are unwarped, times the Jacobian (equation 2), \
         both against the same reference, that of equation 2:\n\n![Error against time by equation]({equations_plot})\n\n{}\n\
         Prefiltered maps, looked up once per pixel (where light is warped, in the warped direction), against the sum over the \
         reference's lights:\n\n{}",
        subject.name,
        subject.width,
        subject.height,
        subject.covered,
        samples(subject),
        rounding(subject),
        equations(subject),
        prefiltered(subject),
    )
}

fn altered(method: Method) -> &'static str {
    if method.warps() { "warped" } else { "plain" }
}

const DIFFERENCE: [&str; 5] = [
    "mean / 99 % / max",
    "worst at",
    "not finite",
    "grey levels 99 %",
    "max",
];

fn difference(d: &Difference) -> Vec<String> {
    let e = &d.errors;
    vec![
        [e.mean, e.p99, e.max].map(scientific).join(" / "),
        place(e),
        e.non_finite.to_string(),
        rounded(d.grey_p99),
        rounded(d.grey_max),
    ]
}

fn with_difference<'a>(before: &[&'a str], after: &[&'a str]) -> Vec<&'a str> {
    [before, &DIFFERENCE, after].concat()
}

fn samples(subject: &Subject) -> String {
    let rows = subject.samples.iter().flat_map(|sweep| {
        sweep.rows.iter().map(move |row| {
            let count = row.count;
            let mut cells = vec![
                noun(sweep.surface).to_string(),
                altered(sweep.method).into(),
                match row.on_front {
                    true => format!("**{count}**"),
                    false => count.to_string(),
                },
            ];
            cells.extend(difference(&row.difference));
            cells.extend([pair(row.relight), milliseconds(row.cut.min)]);
            cells
        })
    });
    let after = ["lighting min / median", "median cut"];
    table(&with_difference(&["what", "light", "lights"], &after), rows)
}

fn rounding(subject: &Subject) -> String {
    let sweeps = subject.samples.iter();
    let worst = sweeps.clone().map(|s| s.reference_rounding);
    let times = sweeps.map(|s| milliseconds(s.reference.min));
    format!(
        "The reference takes {}, and its sums in single precision are within {} of double precision.",
        times.collect::<Vec<_>>().join(", "),
        scientific(worst.fold(0.0, f64::max)),
    )
}

fn equations(subject: &Subject) -> String {
    let rows = subject.equations.iter().flat_map(|sweep| {
        let row = move |equation: &str, sample: &Sample| {
            let mut cells = vec![
                noun(sweep.surface).to_string(),
                equation.into(),
                sample.count.to_string(),
            ];
            cells.extend(difference(&sample.difference));
            cells.push(pair(sample.relight));
            cells
        };
        let lookups = sweep.lookups.iter().map(move |s| row("1, look-ups", s));
        lookups.chain(sweep.lights.iter().map(move |s| row("2, lights", s)))
    });
    let before = ["what", "equation", "samples"];
    table(&with_difference(&before, &["lighting min / median"]), rows)
}

fn prefiltered(subject: &Subject) -> String {
    let rows = subject.prefiltered.iter().map(|row| {
        let mut cells = vec![noun(row.surface).to_string(), altered(row.method).into()];
        cells.extend(difference(&row.difference));
        cells.extend([
            if row.serves { "yes" } else { "no" }.into(),
            milliseconds(row.prefilter.min),
            pair(row.relight),
            milliseconds(row.reference.min),
        ]);
        cells
    });
    let after = [
        "serves",
        "filtering, once",
        "look-ups min / median",
        "the sum",
    ];
    table(&with_difference(&["what", "light"], &after), rows)
}

fn elementary(light: &LightReport) -> String {
    let rows = light.functions.iter().map(|row| {
        let errors = |m: &Measured| format!("{} / {:.2}", scientific(m.relative), m.ulp);
        vec![
            row.name.to_string(),
            format!("{:e} to {:e}", row.domain[0], row.domain[1]),
            row.arguments.to_string(),
            errors(&row.fast),
            errors(&row.std),
            rounded(row.fast.nanoseconds),
            rounded(row.std.nanoseconds),
            format!("{:.1}", row.std.nanoseconds / row.fast.nanoseconds),
        ]
    });
    let head = [
        "function",
        "arguments",
        "tried",
        "largest error, relative / ulp",
        "std",
        "ns per number",
        "std",
        "speed-up",
    ];
    format!(
        "\n### Elementary functions\n\nOurs and those of the standard library against double precision, over f32 evenly \
         spaced among all there are between the ends; a row of numbers on one thread, ours in vectors of {}, those of the \
         standard library one by one.\n\n{}",
        functions::vectors(),
        table(&head, rows)
    )
}

fn cost(cost: &Cost) -> String {
    let rows = cost.rows.iter().map(|row| {
        vec![
            row.lights.to_string(),
            pair(row.relight),
            rounded(row.nanoseconds),
        ]
    });
    let covered = cost.covered.iter().map(|row| {
        vec![
            format!("{:.0} %", 100.0 * row.share),
            row.pixels.to_string(),
            pair(row.relight),
            rounded(row.nanoseconds),
        ]
    });
    let each = "ns per covered pixel and light";
    format!(
        "\n### Cost by number of lights\n\nBlinn-Phong under a warp, on waves of {}x{}, all of it covered, all threads \
         together. The line of least squares is {} and {} per light, and tells {:.4} of the variance (R squared).\n\n{}\n\
         By the share that is covered, {} lights:\n\n{}",
        cost.width,
        cost.height,
        milliseconds(cost.line.start),
        milliseconds(cost.line.slope),
        cost.line.told,
        table(&["lights", "min / median", each], rows),
        cost.lights,
        table(&["covered", "pixels", "min / median", each], covered),
    )
}
