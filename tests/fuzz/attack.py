#!/usr/bin/env python3
"""Attacks the built program: damaged files, odd command lines, kills, limits.

After every run: exit code 0 to 3, no panic, at most 10 s, no more memory than --max-memory, no temporary files left, no
control character in what is said. (What is written, and that inputs stay as they were, the fuzz target command_line looks
at.) Prints a table of counts and, for each failure, the command that shows it again; exit code 1 if there is one. Needs
nothing but Python on Linux.
"""

import argparse
import collections
import html.parser
import math
import os
import pathlib
import random
import re
import resource
import shlex
import shutil
import signal
import struct
import subprocess
import sys
import tempfile
import time

import files

HERE = pathlib.Path(__file__).resolve().parent
SECONDS = 10
MIB = 1 << 20
# What a run on small pictures may use, and what a program takes before it has read anything.
CAP = 300 * MIB
START = 32 * MIB
# Of C0, C1 and the characters that turn the direction of text, only the line feed is ours.
RAW = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u202a-\u202e\u2066-\u2069]")
MESSAGES, LONGEST_LINE = ("error: ", "warning: ", "note: "), 2020
HOSTILE_WORDS = [0, 1, 0x7F, 0xFF, 0x7FFF, 0xFFFF, 0x7FFFFFFF, 0x80000000, 0xFFFFFFFF, 0x7F800000, 0x7FC00000, 0xFF7FFFFF]
HOSTILE_VALUES = ("0 -1 1e-300 1e300 1e38 -1e38 nan inf -inf 65535 65536 4294967295 auto none -- - 1,2 1,2,3,4,5,6 frame.exr absent"
                  " \x1b[31m \u202ex 1-3 é 1e-45").split() + [""]
WRITTEN = ("-o", "--output", "--timings", "--save-recipe")

Outcome = collections.namedtuple("Outcome", "code said seconds rss")


def lines(text):
    """Command lines with | between them, as words."""
    return [line.split() for line in text.split("|")]


class Attack:
    """A folder to run in, counts, and failures."""

    def __init__(self, binary, seed):
        self.binary, self.seed = binary, seed
        self.random = random.Random(seed)
        self.counts = collections.defaultdict(collections.Counter)
        self.failures = []
        self.group = ""
        self.desk = pathlib.Path(tempfile.mkdtemp(prefix="relievo-attack-"))
        os.chmod(self.desk, 0o777)
        self.clean = self.make_clean()

    def make_clean(self):
        """What lies on the desk before every run."""
        frame = files.exr(files.bumps(), 24, 18)
        clean = {f"shot.{n:04}.exr": files.exr(files.bumps(n), 24, 18) for n in (1, 2, 3)}
        photo = files.colored_png(24, 18)
        clean |= {"frame.exr": frame, "plain.png": photo, "st/1.png": photo, "st/2.png": photo, "ball.png": files.colored_png(16, 16),
                  "sky.hdr": files.hdr(16, 8), "scan.tif": files.tiff(24, 18), "camera.json": b'{"focal_px": 30}',
                  "look.toml": b'version = 1\ncommand = "relight"\nlight = "135,40"\n'}
        for name, data in clean.items():
            self.put(name, data)
        # Compressed as this program compresses; every way of storing is attacked.
        made = {"photo.jpg": ["enhance", "frame.exr", "-o", "photo.jpg"]}
        for kind in ("rle", "zips", "zip", "piz", "dwaa", "dwab"):
            command, layers = ("enhance", "results") if kind.startswith("dwa") else ("shape", "channels")
            made[f"{kind}.exr"] = [command, "frame.exr", "-o", f"{kind}.exr", "--compression", kind, "--layers", layers]
        for name, line in made.items():
            subprocess.run([self.binary, *line], cwd=self.desk, capture_output=True, timeout=60)
            path = self.desk / name
            if path.exists():
                clean[name] = path.read_bytes()
            else:
                print(f"note: no {name}, for `relievo {' '.join(line)}` made none")
        return clean

    def put(self, name, data):
        path = self.desk / name
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_symlink() or path.exists():
            path.unlink()
        path.write_bytes(data)

    def reset(self):
        """Clears the desk and lays it anew."""
        for entry in self.desk.iterdir():
            shutil.rmtree(entry) if entry.is_dir() and not entry.is_symlink() else entry.unlink()
        for name, data in self.clean.items():
            self.put(name, data)
        (self.desk / "sub").mkdir()

    def some(self, cases, runs):
        """As many of the cases, each with the desk laid anew."""
        for case in self.random.sample(cases, min(runs, len(cases))):
            self.reset()
            yield case

    def start(self, words, limits=(), user=None):
        def prepare():
            for kind, value in limits:
                resource.setrlimit(kind, (value, value))
            if user is not None:
                os.setgroups([])
                os.setgid(user)
                os.setuid(user)

        said = tempfile.TemporaryFile()
        run = subprocess.Popen([self.binary, *words], cwd=self.desk, stdin=subprocess.DEVNULL, stdout=said, stderr=said,
                               preexec_fn=prepare, start_new_session=True)
        return run, said

    def run(self, words, most=SECONDS, **how):
        """Runs the program; a code below 0 is a signal."""
        began, rss = time.monotonic(), 0
        run, said = self.start(words, **how)
        while True:
            rss = memory_of(run.pid) or rss
            pid, status = os.waitpid(run.pid, os.WNOHANG)
            seconds = time.monotonic() - began
            if pid:
                break
            if seconds > most:
                os.kill(run.pid, signal.SIGKILL)
                _, status = os.waitpid(run.pid, 0)
                break
            time.sleep(0.002)
        run.returncode = os.waitstatus_to_exitcode(status)
        said.seek(0)
        return Outcome(run.returncode, said.read(), seconds, rss)

    def fail(self, words, why, before=""):
        self.counts[self.group]["failures"] += 1
        line = " ".join([before, "relievo", *map(shell_word, words)]).strip()
        kept = self.keep()
        self.failures.append(f"[{self.group}] {why}\n    cd {kept} && {line}")

    def keep(self):
        """A copy of the desk as it is, to run the command in again: of the first failures only."""
        if len(self.failures) >= 40:
            return "(as made by the same seed)"
        kept = pathlib.Path(tempfile.gettempdir()) / f"relievo-failure-{self.seed}-{len(self.failures)}"
        shutil.rmtree(kept, ignore_errors=True)
        shutil.copytree(self.desk, kept, symlinks=True)
        return kept

    def check(self, words, *, before="", may_abort=False, seconds=SECONDS, **how):
        """Runs the program and checks all that must hold after it."""
        outcome = self.run(words, seconds, **how)
        counts = self.counts[self.group]
        counts["runs"] += 1
        counts[f"exit {outcome.code}"] += 1
        text = outcome.said.decode(errors="replace")
        wrong = []
        if outcome.seconds > seconds:
            wrong.append(f"takes more than {seconds} s")
        elif may_abort and outcome.code == -signal.SIGABRT and "memory allocation" in text:
            counts["no memory"] += 1
        elif not 0 <= outcome.code <= 3:
            wrong.append(f"ends with {outcome.code}: {text[-300:]!r}")
        elif outcome.code and not any(line.startswith("error: ") for line in text.splitlines()):
            wrong.append(f"exit {outcome.code} without a line of error: {text[-300:]!r}")
        if "panicked" in text:
            wrong.append(f"panics: {text[-300:]!r}")
        if outcome.rss > CAP + START:
            wrong.append(f"takes {outcome.rss / MIB:.0f} MiB where {CAP / MIB:.0f} are allowed")
        long = [line for line in text.splitlines() if line.startswith(MESSAGES) and len(line) > LONGEST_LINE]
        wrong += [f"says a line of {len(line)} characters: {line[:120]!r}" for line in long[:1]]
        if raw := RAW.search(text):
            wrong.append(f"says {raw.group()!r} raw: {text[max(raw.start() - 80, 0):raw.end() + 20]!r}")
        wrong += [f"{path.name} is left behind" for path in self.desk.rglob(".relievo-*")]
        for why in wrong:
            self.fail(words, why, before)
        return outcome


def memory_of(pid):
    """The most memory that a program has held, in bytes: what the system counts of a child holds that of its parent, too."""
    try:
        found = re.search(r"VmHWM:\s+(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text())
    except OSError:
        return 0
    return int(found.group(1)) << 10 if found else 0


def shell_word(word):
    """A word as bash reads it, whatever it holds."""
    word = os.fsdecode(word) if isinstance(word, bytes) else word
    if word.isprintable():
        return shlex.quote(word)
    return "$'" + "".join(f"\\x{b:02x}" if not 32 <= b < 127 or b in b"'\\" else chr(b) for b in os.fsencode(word)) + "'"


def mutated(attack, data):
    """The same with bits flipped, words replaced, cut, or spliced."""
    pick, data = attack.random, bytearray(data)
    for _ in range(pick.choice([1, 1, 2, 4])):
        if not data:
            break
        # Headers are small and matter most.
        at = pick.randrange(min(len(data), 600) if pick.random() < 0.5 else len(data))
        kind = pick.randrange(6)
        if kind < 2:
            data[at] ^= 1 << pick.randrange(8)
        elif kind == 2:
            data[at:at + 4] = struct.pack(pick.choice("<>") + "I", pick.choice(HOSTILE_WORDS))
        elif kind == 3:
            data[at] = pick.randrange(256)
        elif kind == 4:
            del data[at:at + pick.choice([1, 4, 100, len(data)])]
        else:
            start = pick.randrange(len(data))
            data[at:at] = data[start:start + pick.choice([1, 4, 64])]
    return bytes(data)


def mutations(attack, runs):
    """Damaged files in every role."""
    exrs = [n for n in attack.clean if n.endswith(".exr")]
    photos = ["plain.png", "photo.jpg", "scan.tif", "sky.hdr"]
    result = "-o out.exr"
    roles = [(exrs, f"shape X {result} | enhance X -o out.png | relight X --light 135,40 {result} | hatch X -o out.svg | hatch X -o out.png"
              f" | relight frame.exr --material mirror --surroundings X {result} | relight frame.exr --material glass --back X {result}"),
             (exrs + photos, f"inspect X | inspect --json X | relight frame.exr --environment X {result}"
              f" | relight frame.exr --lit-sphere X {result} | enhance plain.png --normal X {result}"),
             (["camera.json"], f"relight frame.exr --light 135,40 --camera X {result} --layers results"),
             (["look.toml"], f"run X frame.exr {result}"), (photos, "hatch frame.exr --style st -o out.png")]
    roles = [(kinds, line) for kinds, text in roles for line in lines(text)]
    for _ in range(runs):
        attack.reset()
        kinds, line = attack.random.choice(roles)
        name = attack.random.choice(kinds)
        damaged = "st/1.png" if "st" in line else "X." + name.rsplit(".", 1)[1]
        attack.put(damaged, mutated(attack, attack.clean[name]))
        words = [damaged if word == "X" else word for word in line]
        if words[0] != "inspect":
            words += ["--compression", "none"] + ([] if "run" in words else ["--max-memory", str(CAP)])
        attack.check(words)


def flags_of(attack):
    """The flags of every command with their possible values, from its help."""
    table = {}
    for command in ("shape", "enhance", "relight", "hatch", "inspect"):
        text = subprocess.run([attack.binary, command, "--help-all"], capture_output=True, text=True, timeout=10).stdout
        entries = re.split(r"\n +(?:-\w, )?(?=--)", text)[1:]
        flags = []
        for entry in entries:
            name, value = re.match(r"(--[\w-]+)(?: <([^>]+)>)?", entry).groups()
            possible = re.search(r"\[possible values: ([^\]]+)\]", entry)
            flags.append((name, value, possible.group(1).split(", ") if possible else None))
        table[command] = flags
    return table


def command_lines(attack, runs):
    """Real flags with hostile values."""
    table, pick = flags_of(attack), attack.random
    names = "frame.exr ./frame.exr shot.####.exr plain.png sky.hdr camera.json look.toml st absent.exr".split()
    outputs = "out.exr out.png out.svg out.####.exr ./frame.exr st/1.png sub absent/out.png out.hdr out.tif".split()
    for _ in range(runs):
        attack.reset()
        command = pick.choice(list(table))
        words = [command, pick.choice(names) if pick.random() < 0.2 else "frame.exr"]
        if command != "inspect":
            words += ["-o", pick.choice(outputs) if pick.random() < 0.3 else "out.exr", "--compression", "none", "--layers", "results",
                      "--max-memory", str(CAP)]
        for name, value, possible in pick.sample(table[command], pick.randint(0, 4)):
            if name in ("--max-memory", "--help", "--help-all") or value is None:
                words += [name] if value is None else []
                continue
            if name in WRITTEN:
                given = pick.choice(outputs)
            elif possible and pick.random() < 0.8:
                given = pick.choice(possible)
            elif any(kind in value for kind in ("FILE", "DIR")) and pick.random() < 0.8:
                given = pick.choice(names)
            elif "," in value.split("[")[0]:
                given = ",".join(pick.choice(HOSTILE_VALUES[:12]) for _ in range(value.split("[")[0].count(",") + 1))
            else:
                given = pick.choice(HOSTILE_VALUES)
            words += [f"{name}={given}"] if pick.random() < 0.3 else [name, given]
        attack.check(words)


def kills(attack, runs):
    """SIGKILL at any moment; then the same command has to leave the same bytes and nothing else."""
    big = {f"big.{n:04}.exr": files.exr(files.bumps(n if n > 1 else 0), 160, 120) for n in (1, 2, 3, 4)}
    commands = lines("shape big.0001.exr -o o/out.exr | hatch big.0001.exr -o o/out.png | relight big.####.exr --frames 1-4 --light 135,40"
                     " -o o/out.####.exr --skip-existing -q | hatch big.####.exr --frames 1-4 -o o/out.####.png --skip-existing -q")

    def outputs():
        return {p.name: p.read_bytes() for p in (attack.desk / "o").iterdir()}

    def lay():
        attack.reset()
        (attack.desk / "o").mkdir()
        for name, data in big.items():
            attack.put(name, data)

    expected = []
    for line in commands:
        lay()
        began = time.monotonic()
        attack.check(line)
        expected.append((outputs(), time.monotonic() - began))
    for turn in range(runs):
        line, (whole, seconds) = commands[turn % len(commands)], expected[turn % len(commands)]
        lay()
        delay = attack.random.uniform(0, 1.1 * seconds)
        run, _ = attack.start(line)
        time.sleep(delay)
        run.kill()
        run.wait()
        before = f"# after kill -9 at {delay:.3f} s:"
        for path in (attack.desk / "o").glob("out*"):
            if path.read_bytes() != whole.get(path.name):
                attack.fail(line, f"{path.name} is half written", before)
        attack.check(line, before=before)
        if outputs() != whole:
            attack.fail(line, f"other files than without a kill: {sorted(outputs())}", before)


def pages(attack, runs):
    """Names of files that a page would take for more than text, in that of a report."""
    odd = ["<img src=x onerror=alert(1)>", "<script>alert(1)</script>", "[x](javascript:alert(1))", "![x](http://x.example/y.png)",
           "a|b`c`", "<svg onload=alert(1)>", "&lt;b&gt;"]
    for name in attack.some(odd, runs):
        name = name.replace("/", "\u2215")
        attack.put(f"{name}.exr", files.exr(files.bumps(), 24, 18))
        words = ["report", f"{name}.exr", "-o", "rep", "-q", "--budget", "1"]
        outcome = attack.check(words, seconds=60)
        page = attack.desk / "rep/report.html"
        live = Live()
        live.feed(page.read_text() if page.exists() else "")
        if outcome.code == 0 and (live.found or not page.exists()):
            attack.fail(words, f"its page holds {live.found}" if page.exists() else "there is no page")


class Live(html.parser.HTMLParser):
    """What in a page would run, or be loaded from elsewhere."""

    def __init__(self):
        super().__init__()
        self.found = []

    def handle_starttag(self, tag, attributes):
        if tag in ("script", "iframe", "object", "embed", "base"):
            self.found.append(tag)
        for name, value in attributes:
            if name.startswith("on") or name in ("src", "href") and not (value or "").startswith(("data:image/", "#")):
                self.found.append(f"{name}={value}")


def limits(attack, runs):
    """Little memory, few threads, small files, as the system allows them."""
    nobody = 65534 if os.getuid() == 0 else None
    frames = "shape shot.####.exr --frames 1-3 -o out.####.png"
    commands = lines(f"shape frame.exr -o out.exr | hatch frame.exr -o out.png | relight frame.exr --light 1,1 -o out.exr | {frames}"
                     " | enhance plain.png --normal plain.png -o out.jpg | shape frame.exr -o out.exr --threads 64"
                     f" | shape frame.exr -o out.exr --save-recipe out.toml | {frames} --threads 65535")
    kinds = [("ulimit -v", resource.RLIMIT_AS, [64 * MIB, 128 * MIB, 256 * MIB, 1 << 30, 2 << 30], 1 << 10),
             ("ulimit -u", resource.RLIMIT_NPROC, [1, 2, 3, 8], 1), ("ulimit -f", resource.RLIMIT_FSIZE, [512, 1024, 8192, 1 << 20], 512),
             ("ulimit -n", resource.RLIMIT_NOFILE, [4, 6, 10, 16], 1)]
    cases = [(line, kind, value) for line in commands for kind in kinds for value in kind[2]]
    for line, (name, kind, _, unit), value in attack.some(cases, runs):
        few = kind == resource.RLIMIT_AS and value < 1 << 30
        user = nobody if kind == resource.RLIMIT_NPROC else None
        before = f"{name} {value // unit};" + (f" # as user {user}" if user else "")
        attack.check(line, limits=[(kind, value)], user=user, before=before, may_abort=few)


STYLES = ["pen", "pencil", "lines", "engraving", "stipple"]
WORK = lines("enhance | shape | relight --light 135,40 |" + "|".join(f"hatch --style {style}" for style in STYLES))


def drawn(line, out):
    """Whether a command writes such a file: an SVG is of lines."""
    return out != "svg" or line[-1] in STYLES and line[-1] != "pencil"


def tiles(attack, runs):
    """Joined borders with every command, at every scale: no more memory or time than without."""
    scales = ["0", "0.5", "4", "30", "300", "1000"]
    cases = [(line, "frame.exr", ["--scale", scale], out) for line in WORK for scale in scales for out in ("exr", "png", "svg") if drawn(line, out)]
    maps = ["curvature", "convex,concave,edges", "height", "occlusion"]
    cases += [(["map", "--map", name], "plain.png", ["--scale", scale], out) for name in maps for scale in scales for out in ("exr", "png")
              if out == "exr" or "," not in name]
    cases += [(["map", "--map", "occlusion"], "plain.png", ["--occlusion-radius", radius], "png") for radius in ("1", "64", "1024")]
    cases += [(["hatch", "--style", style], "frame.exr", ["--enlarge", "3", "--layers", "results"], out) for style in STYLES for out in ("exr", "png")]
    cases = [(*case, wrap) for case in cases for wrap in ("x", "y", "xy", "auto")]
    for line, picture, more, out, wrap in attack.some(cases, runs):
        attack.check([line[0], picture, *line[1:], *more, "--wrap", wrap, "-o", f"out.{out}", "--max-memory", str(CAP)], seconds=2)


def coverage(attack, runs):
    """Coverage, masks and maps with samples far beyond 0 and 1, in every command and style."""
    wild = [1e10, -math.inf, math.inf, 1e38, -1e38, math.nan, 0.5, 65504.0, -1e-30, 2.0]
    roles = {"A": None, "mask.Y": ["--mask", "mask"], "occ.Y": ["--occlusion", "occ"], "imp.Y": ["--importance", "imp"]}
    cases = [(line, channel, share, out) for line in WORK for channel in roles for share in (0.02, 0.3, 1.0) for out in ("exr", "png", "svg")
             if drawn(line, out)]
    pick = attack.random
    for line, channel, share, out in attack.some(cases, runs):
        of_few = pick.sample(wild, 3)
        samples = [[pick.choice(of_few) if pick.random() < share else float(x > 8) for x in range(24)] for _ in range(18)]
        layers = files.bumps()
        # Depth would show coverage instead.
        if channel in ("A", "occ.Y"):
            del layers["Z"]
        layers[channel] = lambda x, y: samples[y][x]
        attack.put("wild.exr", files.exr(layers, 24, 18))
        words = [line[0], "wild.exr", *line[1:], *(roles[channel] or []), "-o", f"out.{out}", "--compression", "none", "--max-memory", str(CAP)]
        attack.check(words, seconds=2)


GROUPS = {"mutations": (mutations, 0.4), "command_lines": (command_lines, 0.4), "kills": (kills, 0.04), "pages": (pages, 0.005),
          "limits": (limits, 0.03), "tiles": (tiles, 0.06), "coverage": (coverage, 0.06)}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--binary", default=HERE.parent.parent / "target/release/relievo", type=pathlib.Path)
    parser.add_argument("--seed", type=int, default=int(time.time()))
    parser.add_argument("--runs", type=int, default=2000, help="about as many in all; the smaller groups hold a fixed number of cases")
    parser.add_argument("--only", choices=GROUPS, help="one group, of as many runs")
    parser.add_argument("--lay", type=pathlib.Path, metavar="DIR", help="only lay the undamaged files there, for other fuzzers")
    given = parser.parse_args()
    binary = given.binary.resolve()
    if not binary.exists():
        sys.exit(f"{binary} is missing: cargo build --release")
    attack = Attack(binary, given.seed)
    if given.lay:
        shutil.copytree(attack.desk, given.lay, dirs_exist_ok=True)
        shutil.rmtree(attack.desk)
        return
    began = time.monotonic()
    try:
        for name, (group, share) in GROUPS.items():
            if given.only in (None, name):
                attack.group = name
                group(attack, given.runs if given.only else max(1, round(share * given.runs)))
    finally:
        shutil.rmtree(attack.desk, ignore_errors=True)
    report(attack, time.monotonic() - began)
    sys.exit(1 if attack.failures else 0)


def report(attack, seconds):
    print(f"seed {attack.seed}, {seconds:.0f} s")
    columns = ["runs", "exit 0", "exit 1", "exit 2", "exit 3", "no memory", "failures"]
    print(f"{'':14}" + "".join(f"{c:>11}" for c in columns))
    for group, counts in attack.counts.items():
        print(f"{group:14}" + "".join(f"{counts[c]:>11}" for c in columns))
    for failure in attack.failures:
        print(failure)


if __name__ == "__main__":
    main()
