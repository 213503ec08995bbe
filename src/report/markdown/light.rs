//! The page's section on light.

use super::{bold_if, percent, place, table, yes_or};
use crate::report::advice::{altered, noun, of_light};
use crate::report::light::cost::Cost;
use crate::report::light::functions::{self, Measured};
use crate::report::light::samples::Sample;
use crate::report::light::{LightReport, REFERENCE_LIGHTS, Subject};
use crate::report::numbers::{milliseconds, rounded, scientific};
use crate::report::plots::of_light as plot_names;
use crate::untrusted::Untrusted;

pub(super) fn section(light: &LightReport) -> String {
    format!(
        "## Light\n\n{}\n\nUnder an environment that is a formula: {}. Errors are those of the worst channel, relative \
         to the luminance that 98 pixels in 100 of the reference stay below, *white*; grey levels are steps of 8 bits after \
         the curve of sRGB, where that luminance shows as white. The reference is a picture under {REFERENCE_LIGHTS} even lights, \
         each of which stands for the pixels of the environment nearest to it; warped by equation 2. Highlights are Phong's \
         lobe of exponent 32 alone, normalised. Times are of lighting alone: making the environment ready is timed \
         apart, as it is done once for a sequence.\n{}{}{}",
        of_light(light),
        light.environment,
        light.subjects.iter().map(of_subject).collect::<String>(),
        elementary(light),
        cost(&light.cost),
    )
}

/// A [`table!`] with the columns of a [`crate::report::light::lit::Difference`] in the middle.
macro_rules! differences {
    ($rows:expr, $row:pat_param => $difference:expr, { $($before:tt)+ } { $($after:tt)+ }) => {
        table!($rows, $row => {
            $($before)+,
            "mean / 99 % / max": $difference.errors,
            "worst at": place(&$difference.errors),
            "not finite": $difference.errors.non_finite,
            "grey levels 99 %": rounded($difference.grey_p99),
            "max": rounded($difference.grey_max),
            $($after)+
        })
    };
}

fn of_subject(subject: &Subject) -> String {
    let [samples_plot, equations_plot] = plot_names(subject);
    let samples = subject
        .samples
        .iter()
        .flat_map(|sweep| sweep.rows.iter().map(move |row| (sweep, row)));
    let samples = differences!(samples, (sweep, row) => row.sample.difference, {
        "what": noun(sweep.surface),
        "light": altered(sweep.method),
        "lights": bold_if(row.on_front, row.sample.count)
    } {
        "lighting min / median": row.sample.relight,
        "median cut": milliseconds(row.cut.min)
    });
    let equations = subject.equations.iter().flat_map(|sweep| {
        let row = move |equation, sample: &Sample| (sweep.surface, equation, *sample);
        let lookups = sweep.lookups.iter().map(move |s| row("1, look-ups", s));
        lookups.chain(sweep.lights.iter().map(move |s| row("2, lights", s)))
    });
    let equations = differences!(equations, (surface, equation, sample) => sample.difference, {
        "what": noun(surface),
        "equation": equation,
        "samples": sample.count
    } {
        "lighting min / median": sample.relight
    });
    let prefiltered = differences!(&subject.prefiltered, row => row.difference, {
        "what": noun(row.surface),
        "light": altered(row.method)
    } {
        "serves": yes_or("no", row.serves),
        "filtering, once": milliseconds(row.prefilter.min),
        "look-ups min / median": row.relight,
        "the sum": milliseconds(row.reference.min)
    });
    format!(
        "\n### Light on {}\n\nThe middle {}x{} of it, {} pixels covered.\n\n![Error against time by number of lights]({samples_plot})\n\n\
         {samples}\nBold: on the Pareto front of time and the error of 99 %. {}\n\n\
         Light warping by look-ups that are warped (equation 1) and by lights that are unwarped, times the Jacobian (equation 2), \
         both against the same reference, that of equation 2:\n\n![Error against time by equation]({equations_plot})\n\n{equations}\n\
         Prefiltered maps, looked up once per pixel (where light is warped, in the warped direction), against the sum over the \
         reference's lights:\n\n{prefiltered}",
        Untrusted(&subject.on.name).markdown(),
        subject.on.width,
        subject.on.height,
        subject.on.covered,
        rounding(subject),
    )
}

fn rounding(subject: &Subject) -> String {
    let sweeps = subject.samples.iter();
    let worst = sweeps.clone().map(|s| s.reference_rounding);
    let times: Vec<_> = sweeps.map(|s| milliseconds(s.reference.min)).collect();
    format!(
        "The reference takes {}, and its sums in single precision are within {} of double precision.",
        times.join(", "),
        scientific(worst.fold(0.0, f64::max)),
    )
}

fn elementary(light: &LightReport) -> String {
    let errors = |m: &Measured| format!("{} / {:.2}", scientific(m.relative), m.ulp);
    let table = table!(&light.functions, row => {
        "function": row.name,
        "arguments": format!("{:e} to {:e}", row.domain[0], row.domain[1]),
        "tried": row.arguments,
        "largest error, relative / ulp": errors(&row.fast),
        "std": errors(&row.std),
        "ns per number": rounded(row.fast.nanoseconds),
        "std": rounded(row.std.nanoseconds),
        "speed-up": format!("{:.1}", row.std.nanoseconds / row.fast.nanoseconds),
    });
    format!(
        "\n### Elementary functions\n\nOurs and those of the standard library against double precision, over f32 evenly \
         spaced among all there are between the ends; a row of numbers on one thread, ours in vectors of {}, those of the \
         standard library one by one.\n\n{table}",
        functions::vectors(),
    )
}

fn cost(cost: &Cost) -> String {
    let by_lights = table!(&cost.rows, row => {
        "lights": row.lights,
        "min / median": row.relight,
        "ns per covered pixel and light": rounded(row.nanoseconds),
    });
    let by_share = table!(&cost.covered, row => {
        "covered": percent(row.share),
        "pixels": row.pixels,
        "min / median": row.relight,
        "ns per covered pixel and light": rounded(row.nanoseconds),
    });
    format!(
        "\n### Cost by number of lights\n\nBlinn-Phong under a warp, on waves of {}x{}, all of it covered, all threads \
         together. The line of least squares is {} and {} per light, and explains {:.4} of the variance (R squared).\n\n{by_lights}\n\
         By the share that is covered, {} lights:\n\n{by_share}",
        cost.width,
        cost.height,
        milliseconds(cost.line.start),
        milliseconds(cost.line.slope),
        cost.line.r_squared,
        cost.lights,
    )
}
