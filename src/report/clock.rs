//! Time used: by this process on all cores, by the clock on the wall, and by other programs beside it.

use serde::Serialize;
use std::time::{Duration, Instant};

/// Time used by some work, in milliseconds.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Spent {
    /// Of this process, on all cores: hardly longer beside other programs. Where the system does not tell, as `wall_ms`.
    pub cpu_ms: f64,
    pub wall_ms: f64,
}

/// Runs `work` and tells the time it used.
pub(super) fn timed<T>(work: impl FnOnce() -> T) -> (T, Spent) {
    let (began, busy) = (Instant::now(), of_process());
    let made = work();
    let wall = began.elapsed();
    let cpu = of_process().zip(busy).map(|(after, before)| after - before);
    let ms = |time: Duration| 1e3 * time.as_secs_f64();
    let used = Spent {
        cpu_ms: ms(cpu.unwrap_or(wall)),
        wall_ms: ms(wall),
    };
    (made, used)
}

/// Processor time of this process so far.
fn of_process() -> Option<Duration> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Some(Duration::new(time.tv_sec as u64, time.tv_nsec as u32))
    }
    #[cfg(not(unix))]
    None
}

/// How many cores other programs keep busy, measured from its making on.
pub(super) struct Others {
    began: Instant,
    own: Option<Duration>,
    all: Option<Duration>,
}

impl Others {
    pub(super) fn begin() -> Self {
        Self {
            began: Instant::now(),
            own: of_process(),
            all: of_machine(),
        }
    }

    /// Cores kept busy by others so far; `None` where the system does not tell.
    pub(super) fn cores(&self) -> Option<f64> {
        let all = of_machine()?.checked_sub(self.all?)?;
        let own = of_process()?.checked_sub(self.own?)?;
        let busy = all.as_secs_f64() - own.as_secs_f64();
        Some((busy / self.began.elapsed().as_secs_f64().max(1e-9)).max(0.0))
    }
}

/// Processor time of all programs since the system began: the first line of /proc/stat counts hundredths of seconds of
/// `user nice system idle iowait irq softirq steal`.
fn of_machine() -> Option<Duration> {
    let stat = std::fs::read_to_string("/proc/stat").ok()?;
    let counts = stat.lines().next()?.split_whitespace().skip(1);
    let counts: Vec<u64> = counts.map_while(|count| count.parse().ok()).collect();
    let busy = counts.get(..3)?.iter().sum::<u64>() + counts.get(5..7)?.iter().sum::<u64>();
    Some(Duration::from_millis(10 * busy))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sleep_takes_no_processor_time() {
        let ((), used) = timed(|| std::thread::sleep(Duration::from_millis(20)));
        assert!(used.wall_ms >= 20.0, "{used:?}");
        if cfg!(unix) {
            // Other tests of this process run beside it: only the order is sure.
            let (sum, used) =
                timed(|| (0..20_000_000_u64).fold(0, |sum: u64, i| sum ^ sum.wrapping_add(i)));
            assert!(used.cpu_ms > 0.0, "{used:?} {sum}");
        }
    }
}
