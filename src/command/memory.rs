//! The memory limit of a run.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Share of free memory used by default.
const SHARE: f64 = 0.6;

/// Free memory assumed where the system does not report it, in bytes.
const UNKNOWN: u64 = 4 << 30;

/// A memory limit: `2G`, `500M` or bytes, or a share of this machine's free memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum MaxMemory {
    /// Six tenths of the memory free when the run begins, within the limits of its control group.
    Auto,
    /// A limit given in bytes.
    Bytes(u64),
}

impl MaxMemory {
    /// The amount in bytes.
    pub(crate) fn bytes(self) -> u64 {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Auto => (self.most() as f64 * SHARE) as u64,
        }
    }

    /// Hard limit, beyond which no work is started: the given amount, or all free memory.
    pub(crate) fn most(self) -> u64 {
        match self {
            Self::Bytes(bytes) => bytes,
            Self::Auto => free().unwrap_or(UNKNOWN),
        }
    }

    /// Bytes that images of light, or strokes, may take beside the frame: half.
    pub(crate) fn for_light(self) -> u64 {
        self.bytes() / 2
    }
}

/// Bytes this process may still allocate, by the machine and by its control group.
fn free() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    let machine = kib << 10;
    Some(group_limit().map_or(machine, |group| machine.min(group)))
}

/// Bytes left in the control groups of this process: the minimum over its own and its ancestors.
fn group_limit() -> Option<u64> {
    let number = |path: PathBuf| -> Option<u64> {
        let text = std::fs::read_to_string(path).ok()?;
        text.trim().parse().ok()
    };
    let groups = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let limits = groups.lines().flat_map(|line| {
        let mut fields = line.splitn(3, ':');
        let (_, kind, path) = (fields.next(), fields.next(), fields.next());
        // Version 2 has one group without a controller name, version 1 one per controller.
        let (root, limit, used) = match kind {
            Some("") => ("/sys/fs/cgroup", "memory.max", "memory.current"),
            _ => (
                "/sys/fs/cgroup/memory",
                "memory.limit_in_bytes",
                "memory.usage_in_bytes",
            ),
        };
        let is_memory =
            kind.is_some_and(|kind| kind.is_empty() || kind.split(',').any(|k| k == "memory"));
        let path = path
            .filter(|_| is_memory)
            .unwrap_or("/")
            .trim_start_matches('/');
        let around: Vec<PathBuf> = Path::new(path)
            .ancestors()
            .map(|p| Path::new(root).join(p))
            .collect();
        around.into_iter().filter_map(move |group| {
            Some(number(group.join(limit))?.saturating_sub(number(group.join(used))?))
        })
    });
    limits.min()
}

impl fmt::Display for MaxMemory {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Bytes(bytes) => write!(f, "{bytes}"),
        }
    }
}

impl FromStr for MaxMemory {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        let upper = text.to_ascii_uppercase();
        let short = upper.trim_end_matches('B').trim_end_matches('I');
        let units = [('K', 10), ('M', 20), ('G', 30), ('T', 40)];
        let with_unit = |&(letter, shift)| Some((short.strip_suffix(letter)?, shift));
        let (number, shift) = units.iter().find_map(with_unit).unwrap_or((short, 0));
        match number.trim().parse::<f64>() {
            Ok(number) if number > 0.0 && number.is_finite() => {
                Ok(Self::Bytes((number * (1_u64 << shift) as f64) as u64))
            }
            _ => Err("expected auto or a size such as 2G or 500M".into()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        let bytes = |text: &str| match text.parse() {
            Ok(MaxMemory::Bytes(bytes)) => Some(bytes),
            _ => None,
        };
        assert_eq!(bytes("1024"), Some(1024));
        assert_eq!(bytes("2G"), Some(2 << 30));
        assert_eq!(bytes("2GiB"), Some(2 << 30));
        assert_eq!(bytes("1.5 mb"), Some(3 << 19));
        assert_eq!(bytes("1T"), Some(1 << 40));
        for wrong in ["", "G", "-1G", "0", "two", "nan", "inf"] {
            assert_eq!(bytes(wrong), None, "{wrong}");
        }
        assert!(MaxMemory::Auto.bytes() > 0);
    }
}
