//! What the numbers come to: which settings nothing beats, and what to change.

use super::{Advice, SEEN, Tried, text};

/// A time saved below this share of the whole is not worth a flag.
const WORTH: f64 = 0.05;

/// Marks what nothing else is both quicker than and more exact. Times that cannot be told apart are equal.
pub(super) fn mark_front(settings: &mut [Tried]) {
    let all: Vec<(f64, f64)> = settings
        .iter()
        .map(|s| (-s.cost.saved_ms, s.error.p99))
        .collect();
    for (setting, own) in settings.iter_mut().zip(&all) {
        let better = |(time, error): &(f64, f64)| {
            *time <= own.0 && *error <= own.1 && (*time < own.0 || *error < own.1)
        };
        setting.is_on_front = !all.iter().any(better);
    }
}

/// What to change, if anything: the quickest of what nobody can tell from the truth.
pub(super) fn verdict(settings: &[Tried], own_error: f64, shows: Option<f64>) -> Advice {
    let [given, others @ ..] = settings else {
        unreachable!("the command as given is one of them")
    };
    let is_exact = |setting: &&Tried| setting.error.p99 <= SEEN;
    let is_unseen = |setting: &&Tried| {
        let (found, as_given) = (&setting.error, &given.error);
        let is_no_worse = found.p99 <= as_given.p99 && found.largest <= as_given.largest;
        is_no_worse || (found.p99 <= 0.5 * SEEN && found.largest <= SEEN)
    };
    let saves = |setting: &&Tried| setting.cost.saved_ms > WORTH * given.cost.cpu_ms;
    let quickest = |found: Vec<&Tried>| -> Option<Tried> {
        let order = |a: &&Tried, b: &&Tried| {
            let by_time = b.cost.saved_ms.total_cmp(&a.cost.saved_ms);
            by_time.then(a.error.p99.total_cmp(&b.error.p99))
        };
        found.into_iter().min_by(order).cloned()
    };
    let ms = |ms: f64| text::ms(ms.abs());
    let nothing = |why: String| Advice {
        flags: None,
        sentence: why,
        shows,
    };
    if others.is_empty() {
        return nothing(
            "nothing to trade: no setting of this command gives quality for time here".into(),
        );
    }
    if own_error > SEEN {
        return nothing(format!(
            "no advice: even the best that was tried is off by {own_error:.1} levels from half its effort; \
             a longer --budget gives it more"
        ));
    }
    let found = match is_exact(&given) {
        true => quickest(others.iter().filter(is_unseen).filter(saves).collect()),
        false => quickest(others.iter().filter(is_exact).collect()).or_else(|| {
            let better = others
                .iter()
                .filter(|s| 1.5 * s.error.p99 < given.error.p99);
            better
                .min_by(|a, b| a.error.p99.total_cmp(&b.error.p99))
                .cloned()
        }),
    };
    let Some(found) = found else {
        let (start, end) = match is_exact(&given) {
            true => ("nothing to trade: ", "nothing as exact is quicker"),
            false => ("", "no other setting does better"),
        };
        let off = given.error.p99;
        return nothing(format!(
            "{start}as given it is off by {off:.1} levels (99 % of pixels), and {end}"
        ));
    };
    let (from, to) = (ms(given.cost.cpu_ms), ms(found.cost.cpu_ms));
    let sentence = match (is_exact(&given), found.cost.saved_ms) {
        (true, saved) => format!(
            "{} saves {} ms of {from}, and nobody sees it (99 % of pixels within {:.1} levels, all within {:.1})",
            found.flags,
            ms(saved),
            found.error.p99,
            found.error.largest
        ),
        (false, saved) => {
            let time = match saved {
                0.0 => "in the same time".to_string(),
                saved if saved > 0.0 => format!("{} ms of CPU less a frame", ms(saved)),
                longer => format!("{} ms of CPU more a frame", ms(longer)),
            };
            format!(
                "{}: {:.1} levels off instead of {:.1} (99 % of pixels), {time} ({from} -> {to})",
                found.flags, found.error.p99, given.error.p99
            )
        }
    };
    Advice {
        sentence,
        flags: Some(found.flags),
        shows,
    }
}

#[cfg(test)]
mod tests {
    use super::super::difference::CodeDifference;
    use super::super::timing::TimedCost;
    use super::*;

    /// A setting by its time saved of 100 ms, and its error: of 99 of 100 pixels, and the largest.
    fn setting(flags: &str, saved_ms: f64, p99: f64, largest: f64) -> Tried {
        Tried {
            flags: flags.into(),
            error: CodeDifference {
                p99,
                largest,
                ..CodeDifference::default()
            },
            cost: TimedCost {
                cpu_ms: 100.0 - saved_ms,
                wall_ms: 100.0 - saved_ms,
                saved_ms,
                is_in_rounds: true,
            },
            is_on_front: false,
            chosen: None,
        }
    }

    fn advice(settings: &[Tried]) -> Option<String> {
        verdict(settings, 0.1, None).flags
    }

    #[test]
    fn what_nobody_sees_and_saves_time_is_advised() {
        let exact = setting("", 0.0, 0.0, 0.1);
        let free = setting("--tolerance 0.01", 20.0, 0.1, 0.7);
        let seen = setting("--tolerance 0.1", 30.0, 0.3, 8.0);
        let all = [exact.clone(), seen.clone(), free.clone()];
        assert_eq!(advice(&all).as_deref(), Some("--tolerance 0.01"));
        // What some pixel shows, or what saves hardly any time, is none.
        let hardly = setting("--tolerance 0.01", 4.0, 0.1, 0.7);
        assert_eq!(advice(&[exact.clone(), seen, hardly]), None);
        assert_eq!(advice(&[exact]), None);
        // A truth that is unsure ranks nothing.
        assert_eq!(verdict(&all, 3.0, None).flags, None);
    }

    #[test]
    fn a_command_that_is_off_is_told_the_quickest_that_is_not() {
        let off = setting("", 0.0, 10.5, 60.0);
        let less = setting("--samples 100", -10.0, 6.5, 23.0);
        let enough = setting("--samples 400", -60.0, 1.6, 26.0);
        let more = setting("--samples 1600", -200.0, 0.4, 9.0);
        let of = |settings: &[&Tried]| {
            advice(&settings.iter().map(|s| (*s).clone()).collect::<Vec<_>>())
        };
        assert_eq!(
            of(&[&off, &less, &enough, &more]).as_deref(),
            Some("--samples 400")
        );
        // Where none is exact, the one that is most so, if it is clearly better.
        assert_eq!(of(&[&off, &less]).as_deref(), Some("--samples 100"));
        let alike = setting("--samples 60", -2.0, 9.9, 60.0);
        assert_eq!(of(&[&off, &alike]), None);
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let mut all = [
            setting("", 0.0, 1.0, 1.0),
            setting("quicker, less exact", 20.0, 3.0, 3.0),
            setting("slower, less exact", -20.0, 2.0, 2.0),
            setting("as quick, as exact", 0.0, 1.0, 1.0),
        ];
        mark_front(&mut all);
        assert_eq!(all.map(|s| s.is_on_front), [true, true, false, true]);
    }
}
