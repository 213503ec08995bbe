//! Times that hold beside other programs: shuffled rounds, in each of which the command as given runs three times as its own
//! control.

use super::clock::{Others, Spent};
use crate::error::Result;
use crate::kernel::quantile::quantile;
use serde::Serialize;
use std::time::{Duration, Instant};

/// Runs of the command as given in every round.
pub(super) const CONTROLS: usize = 3;

/// The fewest rounds that tell a difference.
const LEAST_ROUNDS: usize = 9;

/// How many times the controls' disagreement a difference has to be.
const TOLD_APART: f64 = 2.0;

/// How far times can be trusted.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Trust {
    pub rounds: usize,
    /// Disagreement of the controls, in milliseconds of CPU: what differs by less than twice as much is no difference.
    pub disagreement_ms: f64,
    /// Cores kept busy by other programs meanwhile, where the system tells.
    pub other_cores: Option<f64>,
}

/// The time of a run that was changed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct TimedCost {
    pub cpu_ms: f64,
    pub wall_ms: f64,
    /// CPU time saved against the command as given; negative if it takes longer, 0 where there is no difference.
    pub saved_ms: f64,
    /// Whether it was timed round by round; else once.
    pub is_in_rounds: bool,
}

impl TimedCost {
    /// That of the command as given, which all others are compared with.
    pub(super) fn of_given(used: Spent) -> Self {
        Self {
            is_in_rounds: true,
            ..Self::once(used)
        }
    }

    /// That of a single run.
    pub(super) fn once(used: Spent) -> Self {
        Self {
            cpu_ms: used.cpu_ms,
            wall_ms: used.wall_ms,
            saved_ms: 0.0,
            is_in_rounds: false,
        }
    }
}

/// What rounds found: the time of the command as given, of each other run, and how far to trust them.
pub(super) struct Timed {
    pub(super) given: Spent,
    pub(super) others: Vec<TimedCost>,
    pub(super) trust: Trust,
}

/// Times runs within about `budget`, and `grace` more where that gives enough rounds. `first` are times of first runs, that of the command as given before all others;
/// `run` makes one of them. Those whose rounds the budget does not allow keep their first times.
///
/// # Errors
/// As `run`.
pub(super) fn rounds(
    first: &[Spent],
    budget: Duration,
    grace: Duration,
    mut run: impl FnMut(usize) -> Result<Spent>,
) -> Result<Timed> {
    let began = Instant::now();
    let load = Others::begin();
    // One run on the wall says little beside other programs.
    let stretch = (first[0].wall_ms / first[0].cpu_ms.max(1e-9)).min(1.0);
    let wall_ms = |i: usize| stretch * first[i].cpu_ms;
    let of_round = |members: &[usize]| -> f64 {
        let own: f64 = members.iter().map(|&i| wall_ms(i)).sum();
        CONTROLS as f64 * wall_ms(0) + own
    };
    let mut members: Vec<usize> = (1..first.len()).collect();
    members.sort_by(|&a, &b| wall_ms(a).total_cmp(&wall_ms(b)));
    while !members.is_empty()
        && LEAST_ROUNDS as f64 * of_round(&members) > 1e3 * budget.as_secs_f64()
    {
        members.pop();
    }
    let mut order: Vec<usize> = members.clone();
    order.extend([0; CONTROLS]);
    let mut found: Vec<Vec<Spent>> = vec![Vec::new(); first.len()];
    let mut random = Shuffle(0x9e37_79b9_7f4a_7c15);
    let mut count = 0;
    // A last round that would end late is not begun; a command that takes a third of the budget gets three rounds.
    let may_go_on = |count: usize| {
        let end = || began.elapsed().mul_f64((count + 1) as f64 / count as f64);
        match count {
            0..3 => true,
            3..LEAST_ROUNDS => end() < budget + grace,
            _ => end() < budget && count < 4 * LEAST_ROUNDS,
        }
    };
    while may_go_on(count) {
        random.shuffle(&mut order);
        for &i in &order {
            found[i].push(run(i)?);
        }
        count += 1;
    }
    let controls: Vec<f64> = found[0].iter().map(|used| used.cpu_ms).collect();
    // Of each round, so that what slows the machine for a while slows all alike.
    let middles: Vec<f64> = controls.chunks(CONTROLS).map(median).collect();
    // The middle one of three is off itself by nothing.
    let off = controls.iter().enumerate();
    let off = off.map(|(i, control)| (control - middles[i / CONTROLS]).abs());
    let off: Vec<f64> = off.filter(|&off| off > 0.0).collect();
    // What interrupts a run for long says nothing of the others.
    let most = 3.0 * median(&off);
    let squares: f64 = off.iter().map(|off| off.min(most).powi(2)).sum();
    let deviation = (squares / off.len().max(1) as f64).sqrt();
    // Twice this is 2.8 deviations of the median of so many differences.
    let disagreement_ms = 1.9 * deviation / (count as f64).sqrt();
    let given = Spent {
        cpu_ms: median(&controls),
        wall_ms: median(&found[0].iter().map(|used| used.wall_ms).collect::<Vec<_>>()),
    };
    let cost = |i: usize| {
        let runs = &found[i];
        let (saved, wall_ms) = match runs.is_empty() {
            true => (first[0].cpu_ms - first[i].cpu_ms, first[i].wall_ms),
            false => {
                let less = runs
                    .iter()
                    .zip(&middles)
                    .map(|(used, middle)| middle - used.cpu_ms);
                let wall = runs.iter().map(|used| used.wall_ms);
                (
                    median(&less.collect::<Vec<_>>()),
                    median(&wall.collect::<Vec<_>>()),
                )
            }
        };
        let is_told = saved.abs() >= TOLD_APART * disagreement_ms;
        TimedCost {
            cpu_ms: (given.cpu_ms - saved).max(0.0),
            wall_ms,
            saved_ms: if is_told { saved } else { 0.0 },
            is_in_rounds: !runs.is_empty(),
        }
    };
    Ok(Timed {
        given,
        others: (1..first.len()).map(cost).collect(),
        trust: Trust {
            rounds: count,
            disagreement_ms,
            other_cores: load.cores(),
        },
    })
}

fn median(values: &[f64]) -> f64 {
    quantile(&mut values.to_vec(), 0.5, f64::total_cmp).unwrap_or(0.0)
}

/// A shuffle that is the same in every run of the program (xorshift64).
struct Shuffle(u64);

impl Shuffle {
    fn shuffle(&mut self, order: &mut [usize]) {
        for end in (1..order.len()).rev() {
            for shift in [13_i32, -7, 17] {
                self.0 ^= match shift > 0 {
                    true => self.0 << shift,
                    false => self.0 >> -shift,
                };
            }
            order.swap(end, (self.0 % (end as u64 + 1)) as usize);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs that take 100 ms, with noise of 4 ms and a load that comes and goes and slows all alike: one that does the
    /// same is no difference, one that saves 20 ms is found to, and so is one that is too slow for rounds.
    #[test]
    fn a_difference_is_told_from_noise() {
        let used = |cpu_ms: f64| Spent {
            cpu_ms,
            wall_ms: 1e-5 * cpu_ms,
        };
        let first = vec![used(100.0), used(100.0), used(80.0), used(9e9)];
        let mut state = 1_u64;
        let mut noise = move || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 40) as f64 / f64::from(1 << 24) - 0.5
        };
        for case in 0..20 {
            let mut count = 0;
            let timed = rounds(
                &first.clone(),
                Duration::from_millis(400),
                Duration::ZERO,
                |i| {
                    count += 1;
                    let load = if count / 30 % 2 == 0 { 1.0 } else { 1.3 };
                    Ok(used(load * (first[i].cpu_ms + 8.0 * noise())))
                },
            )
            .unwrap();
            assert!(timed.trust.rounds >= LEAST_ROUNDS);
            let [same, quick, slow] = timed.others[..] else {
                panic!("three runs were timed");
            };
            assert_eq!(same.saved_ms, 0.0, "case {case}");
            assert!(
                (quick.saved_ms - 21.0).abs() < 6.0,
                "case {case}: {quick:?}"
            );
            assert!(
                !slow.is_in_rounds && slow.saved_ms == 100.0 - 9e9,
                "{slow:?}"
            );
        }
    }

    #[test]
    fn shuffles_keep_all_and_change_the_order() {
        let mut order: Vec<usize> = (0..20).collect();
        Shuffle(1).shuffle(&mut order);
        assert_ne!(order, (0..20).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..20).collect::<Vec<_>>());
    }
}
