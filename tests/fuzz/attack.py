#!/usr/bin/env python3
"""Attacks the built program: damaged files, odd command lines, kills, names, pipes, limits.

After every run: exit code 0 to 3, no panic, at most 10 s, no more memory than --max-memory, inputs as they were, no temporary
files left, no control character in what is said, and at exit code 0 no sample that is not finite. Prints a table of counts
and, for each failure, the command that shows it again; exit code 1 if there is one. Needs nothing but Python on Linux.
"""

import argparse
import collections
import hashlib
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
import socket
import struct
import subprocess
import sys
import tempfile
import time
import zlib

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
HOSTILE_VALUES = ["0", "-1", "1e-300", "1e300", "1e38", "-1e38", "nan", "inf", "-inf", "65535", "65536", "4294967295", "", "auto",
                  "none", "--", "-", "1,2", "1,2,3,4,5,6", "frame.exr", "absent", "\x1b[31m", "\u202ex", "1-3", "é", "1e-45"]
WRITTEN = ("-o", "--output", "--timings", "--save-recipe")


class Outcome:
    """What a run has come to."""

    def __init__(self, code, said, seconds, rss):
        self.code, self.said, self.seconds, self.rss = code, said, seconds, rss


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
        clean.update({"frame.exr": frame, "plain.png": files.colored_png(24, 18), "sky.hdr": files.hdr(16, 8),
                      "ball.png": files.colored_png(16, 16), "scan.tif": files.tiff(24, 18), "camera.json": b'{"focal_px": 30}',
                      "look.toml": b'version = 1\ncommand = "relight"\nlight = "135,40"\n', "st/1.png": files.colored_png(24, 18),
                      "st/2.png": files.colored_png(24, 18)})
        for name, data in clean.items():
            self.put(name, data)
        # Compressed as this program compresses; every way of storing is attacked.
        made = {"photo.jpg": ["enhance", "frame.exr", "-o", "photo.jpg"]}
        for kind in ("rle", "zips", "zip", "piz", "dwaa", "dwab"):
            name = f"{kind}.exr"
            made[name] = ["shape", "frame.exr", "-o", name, "--compression", kind, "--layers", "channels"]
            if kind.startswith("dwa"):
                made[name] = ["enhance", "frame.exr", "-o", name, "--compression", kind, "--layers", "results"]
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

    def start(self, words, limits=(), user=None, env=None, out=None):
        def prepare():
            for kind, value in limits:
                resource.setrlimit(kind, (value, value))
            if user is not None:
                os.setgroups([])
                os.setgid(user)
                os.setuid(user)

        said = tempfile.TemporaryFile()
        run = subprocess.Popen([self.binary, *words], cwd=self.desk, stdin=subprocess.DEVNULL, stdout=out or said, stderr=said,
                               preexec_fn=prepare, start_new_session=True, env={**os.environ, **(env or {})})
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
        shutil.copytree(self.desk, kept, symlinks=True, ignore=lambda folder, names: [n for n in names if is_special(pathlib.Path(folder, n))])
        return kept

    def check(self, words, *, cap=CAP, before="", may_abort=False, spoiled=False, seconds=SECONDS, **how):
        """Runs the program and checks all that must hold after it."""
        inputs = self.inputs(words)
        hashes = {path: digest(path) for path in inputs}
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
        if outcome.rss > cap + START:
            wrong.append(f"takes {outcome.rss / MIB:.0f} MiB where {cap / MIB:.0f} are allowed")
        long = [line for line in text.splitlines() if line.startswith(MESSAGES) and len(line) > LONGEST_LINE]
        wrong += [f"says a line of {len(line)} characters: {line[:120]!r}" for line in long[:1]]
        if raw := RAW.search(text):
            wrong.append(f"says {raw.group()!r} raw: {text[max(raw.start() - 80, 0):raw.end() + 20]!r}")
        wrong += [f"{path} is changed" for path, was in hashes.items() if digest(path) != was]
        wrong += self.left_behind()
        if outcome.code == 0 and not spoiled:
            pictures = [path for path in self.desk.glob("out*.exr") if not path.read_bytes().startswith(b"{")]
            # Timings may be asked for under any name.
            wrong += [f"{path.name} has samples that are not finite" for path in pictures if not finite(path)]
        for why in wrong:
            self.fail(words, why, before)
        return outcome

    def inputs(self, words):
        """The files that the words name, other than to write them."""
        named = [w for at, w in enumerate(words) if at == 0 or words[at - 1] not in WRITTEN]
        named = [w.split("=", 1)[-1] for w in named if not w.startswith(tuple(f"{flag}=" for flag in WRITTEN)) and not w.startswith("-o")]
        found = []
        for word in (part for w in named for part in w.split(",")):
            if "####" in word or "%04d" in word:
                found += sorted(self.desk.glob("shot.*"))
                continue
            try:
                path = (self.desk / word).resolve()
                if path.is_dir() and self.desk in path.parents:
                    found += [p for p in path.rglob("*") if p.is_file()]
                elif path.is_file():
                    found.append(path)
            except (OSError, ValueError, RuntimeError):
                pass
        return found

    def left_behind(self):
        left = [p for p in self.desk.rglob(".relievo-*") if not p.is_fifo()]
        return [f"{path.name} is left behind" for path in left]


def memory_of(pid):
    """The most memory that a program has held, in bytes: what the system counts of a child holds that of its parent, too."""
    try:
        found = re.search(r"VmHWM:\s+(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text())
    except OSError:
        return 0
    return int(found.group(1)) << 10 if found else 0


def is_special(path):
    return path.is_fifo() or path.is_socket()


def shell_word(word):
    """A word as bash reads it, whatever it holds."""
    word = os.fsdecode(word) if isinstance(word, bytes) else word
    if word.isprintable():
        return shlex.quote(word)
    return "$'" + "".join(f"\\x{b:02x}" if not 32 <= b < 127 or b in b"'\\" else chr(b) for b in os.fsencode(word)) + "'"


def digest(path):
    try:
        return hashlib.sha256(path.read_bytes()).digest()
    except OSError:
        return None


def finite(path):
    """Whether an uncompressed EXR file of one part holds finite samples alone; true of others, which are not looked into."""
    data = path.read_bytes()
    if data[:4] != b"v/1\x01" or data[5] & 0x1A:
        return data[:4] == b"v/1\x01"
    at, header = 8, {}
    while data[at]:
        end = data.index(0, at)
        kind = data.index(0, end + 1)
        size = struct.unpack_from("<i", data, kind + 1)[0]
        header[data[at:end]] = data[kind + 5:kind + 5 + size]
        at = kind + 5 + size
    if header[b"compression"] != b"\0":
        return True
    x0, y0, x1, y1 = struct.unpack("<4i", header[b"dataWindow"])
    width, height, channels, row = x1 - x0 + 1, y1 - y0 + 1, header[b"channels"], ""
    while channels[0]:
        end = channels.index(0)
        row += f"{width}" + "Ief"[struct.unpack_from("<i", channels, end + 1)[0]]
        channels = channels[end + 17:]
    offsets = struct.unpack_from(f"<{height}Q", data, at + 1)
    return all(math.isfinite(v) for offset in offsets for v in struct.unpack_from("<" + row, data, offset + 8))


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
    light = ["--light", "135,40"]
    lines = [(exrs, ["shape", "X", "-o", "out.exr"]), (exrs, ["enhance", "X", "-o", "out.png"]),
             (exrs, ["relight", "X", *light, "-o", "out.exr"]), (exrs, ["hatch", "X", "-o", "out.svg"]),
             (exrs, ["hatch", "X", "-o", "out.png"]), (exrs + photos, ["inspect", "X"]), (exrs + photos, ["inspect", "--json", "X"]),
             (exrs + photos, ["relight", "frame.exr", "--environment", "X", "-o", "out.exr"]),
             (exrs + photos, ["relight", "frame.exr", "--lit-sphere", "X", "-o", "out.exr"]),
             (exrs + photos, ["enhance", "plain.png", "--normal", "X", "-o", "out.exr"]),
             (["camera.json"], ["relight", "frame.exr", *light, "--camera", "X", "-o", "out.exr", "--layers", "results"]),
             (["look.toml"], ["run", "X", "frame.exr", "-o", "out.exr"]),
             (photos, ["hatch", "frame.exr", "--style", "st", "-o", "out.png"]),
             (exrs, ["relight", "frame.exr", "--material", "mirror", "--surroundings", "X", "-o", "out.exr"]),
             (exrs, ["relight", "frame.exr", "--material", "glass", "--back", "X", "-o", "out.exr"])]
    for _ in range(runs):
        attack.reset()
        kinds, line = attack.random.choice(lines)
        name = attack.random.choice(kinds)
        damaged = "st/1.png" if "st" in line else "X." + name.rsplit(".", 1)[1]
        attack.put(damaged, mutated(attack, attack.clean[name]))
        words = [damaged if w == "X" else w for w in line]
        if words[0] not in ("inspect",):
            words += ["--compression", "none"]
            words += [] if "run" in words else ["--max-memory", str(CAP)]
        # A damaged file may hold samples that are not finite, and they are carried through.
        attack.check(words, spoiled=name != "camera.json")


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
    names = ["frame.exr", "./frame.exr", "shot.####.exr", "plain.png", "sky.hdr", "camera.json", "look.toml", "st", "absent.exr"]
    outputs = ["out.exr", "out.png", "out.svg", "out.####.exr", "./frame.exr", "st/1.png", "sub", "absent/out.png", "out.hdr", "out.tif"]
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
    layers = files.bumps()
    big = {f"big.{n:04}.exr": files.exr(files.bumps(n) if n > 1 else layers, 160, 120) for n in (1, 2, 3, 4)}
    lines = [["shape", "big.0001.exr", "-o", "o/out.exr"], ["hatch", "big.0001.exr", "-o", "o/out.png"],
             ["relight", "big.####.exr", "--frames", "1-4", "--light", "135,40", "-o", "o/out.####.exr", "--skip-existing", "-q"],
             ["hatch", "big.####.exr", "--frames", "1-4", "-o", "o/out.####.png", "--skip-existing", "-q"]]

    def outputs():
        return {p.name: digest(p) for p in (attack.desk / "o").iterdir()}

    def lay():
        attack.reset()
        (attack.desk / "o").mkdir()
        for name, data in big.items():
            attack.put(name, data)

    expected = []
    for line in lines:
        lay()
        began = time.monotonic()
        attack.check(line)
        expected.append((outputs(), time.monotonic() - began))
    for turn in range(runs):
        line, (whole, seconds) = lines[turn % len(lines)], expected[turn % len(lines)]
        lay()
        delay = attack.random.uniform(0, 1.1 * seconds)
        run, _ = attack.start(line)
        time.sleep(delay)
        run.kill()
        run.wait()
        before = f"# after kill -9 at {delay:.3f} s:"
        for path in (attack.desk / "o").glob("out*"):
            if digest(path) != whole.get(path.name):
                attack.fail(line, f"{path.name} is half written", before)
        attack.check(line, before=before)
        if outputs() != whole:
            attack.fail(line, f"other files than without a kill: {sorted(outputs())}", before)


def paths(attack, runs):
    """One file as input and output, or as two outputs, however it is spelled."""
    lines = {"frame.exr": [["shape", "IN", "-o", "OUT"], ["shape", "IN", "-o", "out.exr", "--timings", "OUT"],
                           ["shape", "IN", "-o", "out.exr", "--save-recipe", "OUT"], ["shape", "IN", "--save-recipe", "OUT"]],
             "plain.png": [["enhance", "plain.png", "--normal", "IN", "-o", "OUT"], ["shape", "frame.exr", "--importance", "IN", "-o", "OUT"]],
             "sky.hdr": [["relight", "frame.exr", "--environment", "IN", "-o", "OUT"]],
             "ball.png": [["relight", "frame.exr", "--lit-sphere", "IN", "-o", "OUT"]],
             "camera.json": [["relight", "frame.exr", "--light", "1,1", "--camera", "IN", "-o", "out.exr", "--timings", "OUT"]],
             "look.toml": [["run", "IN", "frame.exr", "-o", "out.exr", "--save-recipe", "OUT"]],
             "st/1.png": [["hatch", "frame.exr", "--style", st, "-o", "OUT"] for st in ("st", "./st", "sub/../st", "linked")],
             "shot.0002.exr": [["shape", "shot.####.exr", "--frames", "1-3", "-o", "OUT"]]}

    def spellings(original):
        folder, name = os.path.split(original)
        suffix = pathlib.Path(original).suffix
        numbered = ["shot.####.exr", "./shot.%04d.exr", "sub/../shot.####.exr", "link.####.exr"] if "shot" in original else []
        return numbered + [original, f"./{original}", f".//{original}", f"sub/../{original}", f"link{suffix}", f"sub/link{suffix}",
                           f"hard{suffix}", str(attack.desk / original)]

    cases = [(original, [a if w == "IN" else b if w == "OUT" else w for w in line]) for original, of in lines.items()
             for line in of for a in spellings(original) for b in spellings(original)]
    twice = [("out.png", ["shape", "frame.exr", "-o", a, flag, b]) for flag in ("--timings", "--save-recipe")
             for a in ("out.png", "sub/../out.png") for b in ("out.png", "./out.png", ".//out.png")]
    twice += [("both", ["shape", "frame.exr", "-o", "out.png", "--timings", "both", "--save-recipe", b]) for b in ("both", "./both")]
    for original, words in attack.random.sample(cases + twice, min(runs, len(cases + twice))):
        attack.reset()
        suffix = pathlib.Path(original).suffix
        for link in (f"link{suffix}", f"sub/link{suffix}", "link.0002.exr"):
            os.symlink(attack.desk / original, attack.desk / link)
        os.symlink("st", attack.desk / "linked")
        if original in attack.clean:
            os.link(attack.desk / original, attack.desk / f"hard{suffix}")
        was = digest(attack.desk / original)
        outcome = attack.check(words)
        if was and digest(attack.desk / original) != was:
            attack.fail(words, f"{original} is overwritten")
        written = [os.path.realpath(attack.desk / words[i + 1]) for i, w in enumerate(words) if w in WRITTEN]
        if outcome.code == 0 and len(written) > len(set(written)):
            attack.fail(words, "two outputs in one file at exit code 0")


def pipes(attack, runs):
    """Pipes, devices and folders where files are read or written, and under the names of temporary files."""
    roles = [["inspect", "X"], ["inspect", "--json", "X"], ["shape", "X", "-o", "out.png"], ["enhance", "plain.png", "--normal", "X", "-o", "out.png"],
             ["relight", "frame.exr", "--environment", "X", "-o", "out.png"], ["relight", "frame.exr", "--lit-sphere", "X", "-o", "out.png"],
             ["relight", "frame.exr", "--light", "1,1", "--camera", "X", "-o", "out.png"], ["run", "X", "frame.exr", "-o", "out.png"],
             ["shape", "frame.exr", "--depth", "X", "-o", "out.png"], ["shape", "frame.exr", "--importance", "X", "-o", "out.png"],
             ["shape", "frame.exr", "-o", "X"], ["shape", "frame.exr", "-o", "out.png", "--timings", "X"],
             ["shape", "frame.exr", "-o", "out.png", "--save-recipe", "X"], ["hatch", "frame.exr", "--style", "X", "-o", "out.png"],
             ["hatch", "frame.exr", "--style", "pipes", "-o", "out.png"],
             ["relight", "frame.exr", "--material", "mirror", "--surroundings", "X", "-o", "out.png"]]
    things = ["pipe", "sub", "/dev/zero", "/dev/stdin", "-", "/proc/self/mem", "socket"]
    cases = [(role, thing) for role in roles for thing in things if not (thing.startswith("/") and any(
        role[i] in WRITTEN and role[i + 1] == "X" for i in range(len(role) - 1)))]
    for role, thing in attack.random.sample(cases, min(runs, len(cases))):
        attack.reset()
        os.mkfifo(attack.desk / "pipe")
        (attack.desk / "pipes").mkdir()
        os.mkfifo(attack.desk / "pipes/1.png")
        with socket.socket(socket.AF_UNIX) as listening:
            listening.bind(str(attack.desk / "socket"))
            attack.check([thing if w == "X" else w for w in role])
    for line in (["shape", "frame.exr", "-o", "o/out.png"], ["shape", "shot.####.exr", "--frames", "1-3", "-o", "o/out.####.png"],
                 ["shape", "shot.####.exr", "--frames", "1-3", "-o", "o/out.####.png", "--skip-existing"]):
        attack.reset()
        (attack.desk / "o").mkdir()
        host = re.sub(r"[^A-Za-z0-9]", "", pathlib.Path("/proc/sys/kernel/hostname").read_text())
        for name in (f".relievo-{host}-abcdef.part", ".relievo-abcdef.part", "out.0001.png"):
            os.mkfifo(attack.desk / "o" / name)
            os.utime(attack.desk / "o" / name, (0, 0))
        attack.check(line)


def names(attack, runs):
    """Control characters and turned text in names of layers, parts, attributes and files: none may reach the terminal."""
    odd = ["\x1b]0;x\x07", "\x1b[31mred", "a\nb", "a\rb", "\x08\x08", "\x9b31m", "a\u202eb", "\u2066x", "\x7f", "tab\tbed", "x" * 250]
    raw = [b"\xff\xfe", b"\xc3", b"a\xe2\x80"]
    views = [["inspect", "F"], ["inspect", "--json", "F"], ["shape", "F", "-o", "out.png", "-v", "--explain"], ["enhance", "F", "-o", "out.png", "-v"],
             ["enhance", "F", "--color", "N", "-o", "out.png"], ["enhance", "F", "--normal", "absent", "-o", "out.png"],
             ["shape", "F", "-o", "N/out.png"], ["shape", "N", "-o", "out.png"], ["run", "N.toml", "F", "-o", "out.png"],
             ["shape", "F", "--view", "N", "-o", "out.png"], ["shape", "F", "--layer", "N", "-o", "out.png"], ["enhance", "F", "--light-group", "N=1,2", "-o", "out.png"],
             ["shape", "F", "--N", "-o", "out.png"], ["relight", "F", "--light", "N", "-o", "out.png"],
             ["shape", "F", "-o", "out.png", "--save-recipe", "N.out"], ["relight", "F", "--light", "1,1", "--camera", "N.json", "-o", "out.png"]]
    cases = [(name, view) for name in odd + raw for view in views]
    for name, view in attack.random.sample(cases, min(runs, len(cases))):
        attack.reset()
        layers = files.bumps()
        bytes_of = files.as_bytes(name)
        layers.update({bytes_of + b"." + c: (lambda x, y: 0.5) for c in (b"R", b"G", b"B")})
        layers.update({b"Combined_" + bytes_of[:20] + b"." + c: (lambda x, y: 0.5) for c in (b"R", b"G", b"B")})
        more = files.attribute(bytes_of[:250], "string", bytes_of) + files.attribute("capDate", "string", bytes_of)
        file_name = os.fsdecode(bytes_of.replace(b"/", b"_")[:200]) + ".exr"
        attack.put(file_name, files.exr(layers, 24, 18, part=name, more=more))
        attack.put(os.fsdecode(bytes_of[:200]) + ".toml", b'version = 1\ncommand = "' + bytes_of[:200] + b'"\n"' + bytes_of[:200] + b'" = 1\n')
        attack.put(os.fsdecode(bytes_of[:200]) + ".json", b'{"camera_type": "\\u001b[31m' + bytes_of[:200].replace(b"\n", b"\\n") + b'"}')
        attack.check([w.replace("F", file_name) if w == "F" else w.replace("N", os.fsdecode(bytes_of[:200])) if "N" in w else w for w in view])


def sinks(attack, runs):
    """Names that a shell, a page or a path would take for more than text."""
    odd = ["$(touch pwned)Normal", "`touch pwned`", "a;touch pwned", "a\ntouch pwned", "{a,b}", "*", "~root", "-o", "#a", "a b", "\\x", "'", '"', "Übung"]
    plain = re.compile(r"[\w.\-:/+@,=]*")
    completed = [(name, shell, line) for name in odd for shell in ("bash", "zsh", "fish") for line in (
        ["enhance", "F", "--normal", ""], ["enhance", "F", "--object", ""], ["enhance", "F", "--color", ""], ["shape", ""], ["run", ""])]
    stems = ["..", ".", "{map}", "{name}", "%d#", "####", "-o", "--save-recipe=x", "{name}{map}", "a..b"]
    filled = [(stem, out) for stem in stems for out in ("o/{name}.png", "o/{name}/x.png", "o/{name}.{name}.exr", "o")]
    pages = ["<img src=x onerror=alert(1)>", "<script>alert(1)</script>", "[x](javascript:alert(1))", "![x](http://x.example/y.png)",
             "a|b`c`", "<svg onload=alert(1)>", "&lt;b&gt;"]
    printing = [["--help"], ["--version"], ["shape", "--help"], ["completions", "bash"], ["man"], ["schema"], ["inspect", "frame.exr"]]
    cases = [("complete", case) for case in completed] + [("fill", case) for case in filled] + [("print", line) for line in printing]
    # Reports take a second each.
    cases = attack.random.sample(cases, min(runs, len(cases))) + [("page", name) for name in pages[:max(1, runs // 20)]]
    for kind, case in cases:
        attack.reset()
        if kind == "print":
            with open("/dev/full", "w") as full:
                if attack.check(case, out=full).code != 1:
                    attack.fail(case, "output that no disk takes is no error", "> /dev/full")
        elif kind == "complete":
            name, shell, line = case
            layers = files.bumps()
            layers.update({f"{name}.{axis}": lambda x, y: 0.5 for axis in "RGB"})
            attack.put("named.exr", files.exr(layers, 24, 18))
            if "/" not in name:
                attack.put(name + ".exr", files.exr(files.bumps(), 24, 18))
            words = ["--", "relievo", *("named.exr" if w == "F" else w for w in line)]
            env = {"RELIEVO_COMPLETE": shell, "_CLAP_COMPLETE_INDEX": str(len(words) - 2), "_CLAP_IFS": "\n", "_CLAP_COMPLETE_COMP_TYPE": "9"}
            said = attack.run(words, env=env).said.decode(errors="replace")
            attack.counts[attack.group]["runs"] += 1
            # zsh and fish are given an explanation behind each word.
            split = {"bash": None, "zsh": ":", "fish": "\t"}[shell]
            offered = [line.split(split)[0] if split else line for line in said.splitlines()]
            wrong = [word for word in offered if not plain.fullmatch(word)]
            if wrong:
                attack.fail(words, f"offers {wrong[0]!r} to {shell}")
        elif kind == "fill":
            stem, out = case
            (attack.desk / "o").mkdir()
            attack.put(f"{stem}.exr", files.exr(files.bumps(), 24, 18))
            beyond = lambda: {p for p in [*attack.desk.rglob("*"), *attack.desk.parent.glob("*")] if attack.desk / "o" not in p.parents}
            before = beyond()
            words = ["shape", f"./{stem}.exr", "frame.exr", "-o", out]
            attack.check(words)
            # Other programs may write beside the desk.
            strays = [p for p in beyond() - before if attack.desk in p.parents or p.suffix in (".png", ".exr")]
            if strays:
                attack.fail(words, f"writes outside of its folder: {strays}")
        else:
            name = case.replace("/", "\u2215")
            attack.put(f"{name}.exr", files.exr(files.bumps(), 24, 18))
            words = ["report", f"{name}.exr", "-o", "rep", "-q"]
            outcome = attack.check(words, seconds=60)
            page = attack.desk / "rep/report.html"
            text = page.read_text() if page.exists() else ""
            live = Live()
            live.feed(text)
            if outcome.code == 0 and (not text or live.found or "Content-Security-Policy" not in text):
                attack.fail(words, f"its page holds {live.found or 'no policy'}")


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
    lines = [["shape", "frame.exr", "-o", "out.exr"], ["hatch", "frame.exr", "-o", "out.png"], ["relight", "frame.exr", "--light", "1,1", "-o", "out.exr"],
             ["shape", "shot.####.exr", "--frames", "1-3", "-o", "out.####.png"], ["enhance", "plain.png", "--normal", "plain.png", "-o", "out.jpg"],
             ["shape", "frame.exr", "-o", "out.exr", "--threads", "64"], ["shape", "frame.exr", "-o", "out.exr", "--save-recipe", "out.toml"],
             ["shape", "shot.####.exr", "--frames", "1-3", "-o", "out.####.png", "--threads", "65535"]]
    kinds = [("ulimit -v", resource.RLIMIT_AS, [64 * MIB, 128 * MIB, 256 * MIB, 1 << 30, 2 << 30], 1 << 10),
             ("ulimit -u", resource.RLIMIT_NPROC, [1, 2, 3, 8], 1), ("ulimit -f", resource.RLIMIT_FSIZE, [512, 1024, 8192, 1 << 20], 512),
             ("ulimit -n", resource.RLIMIT_NOFILE, [4, 6, 10, 16], 1)]
    cases = [(line, kind, value) for line in lines for kind in kinds for value in kind[2]]
    for line, (name, kind, _, unit), value in attack.random.sample(cases, min(runs, len(cases))):
        attack.reset()
        few = kind == resource.RLIMIT_AS and value < 1 << 30
        user = nobody if kind == resource.RLIMIT_NPROC else None
        before = f"{name} {value // unit};" + (f" # as user {user}" if user else "")
        attack.check(line, limits=[(kind, value)], user=user, before=before, may_abort=few)


def memory(attack, runs):
    """Pictures that are small as files: no more memory than is allowed."""
    rows = {}

    def black(side):
        if side not in rows:
            rows[side] = files.png(side, side, bytes(side * (1 + (side + 7) // 8)), kind=0, bits=1)
        return rows[side]

    cases = [(18000, ["inspect", "big.png"]), (18000, ["inspect", "--json", "big.png"]),
             (18000, ["shape", "big.png", "--normal", "big.png", "-o", "out.png", "--max-memory", "200M"]),
             (12000, ["relight", "frame.exr", "--environment", "big.png", "-o", "out.png", "--max-memory", "200M"]),
             (12000, ["relight", "frame.exr", "--lit-sphere", "big.png", "-o", "out.png", "--max-memory", "200M"]),
             (12000, ["enhance", "big.png", "--normal", "plain.png", "-o", "out.png", "--max-memory", "200M"]),
             (12000, ["enhance", "plain.png", "--normal", "big.png", "-o", "out.png", "--max-memory", "200M"])]
    for side, line in cases[:runs]:
        attack.reset()
        attack.put("big.png", black(side))
        attack.check(line, cap=200 * MIB)


STYLES = ["pen", "pencil", "lines", "engraving", "stipple"]
WORK = [["enhance"], ["shape"], ["relight", "--light", "135,40"], *(["hatch", "--style", style] for style in STYLES)]


def tiles(attack, runs):
    """Joined borders with every command, at every scale: no more memory or time than without."""
    scales = ["0", "0.5", "4", "30", "300", "1000"]
    cases = [(line, "frame.exr", ["--scale", scale], out) for line in WORK for scale in scales for out in ("exr", "png", "svg")
             if out != "svg" or line[-1] in STYLES and line[-1] != "pencil"]
    maps = ["curvature", "convex,concave,edges", "height", "occlusion"]
    cases += [(["map", "--map", name], "plain.png", ["--scale", scale], out) for name in maps for scale in scales for out in ("exr", "png")
              if out == "exr" or "," not in name]
    cases += [(["map", "--map", "occlusion"], "plain.png", ["--occlusion-radius", radius], "png") for radius in ("1", "64", "1024")]
    cases += [(["hatch", "--style", style], "frame.exr", ["--enlarge", "3", "--layers", "results"], out) for style in STYLES for out in ("exr", "png")]
    cases = [(*case, wrap) for case in cases for wrap in ("x", "y", "xy", "auto")]
    for line, picture, more, out, wrap in attack.random.sample(cases, min(runs, len(cases))):
        attack.reset()
        attack.check([line[0], picture, *line[1:], *more, "--wrap", wrap, "-o", f"out.{out}", "--max-memory", str(CAP)], seconds=2)


def coverage(attack, runs):
    """Coverage, masks and maps with samples far beyond 0 and 1, in every command and style."""
    wild = [1e10, -math.inf, math.inf, 1e38, -1e38, math.nan, 0.5, 65504.0, -1e-30, 2.0]
    roles = {"A": None, "mask.Y": ["--mask", "mask"], "occ.Y": ["--occlusion", "occ"], "imp.Y": ["--importance", "imp"]}
    cases = [(line, channel, share, out) for line in WORK for channel in roles for share in (0.02, 0.3, 1.0) for out in ("exr", "png", "svg")
             if out != "svg" or line[-1] in STYLES and line[-1] != "pencil"]
    pick = attack.random
    for line, channel, share, out in pick.sample(cases, min(runs, len(cases))):
        attack.reset()
        of_few = pick.sample(wild, 3)
        samples = [[pick.choice(of_few) if pick.random() < share else float(x > 8) for x in range(24)] for _ in range(18)]
        layers = files.bumps()
        # Depth would show coverage instead.
        if channel in ("A", "occ.Y"):
            del layers["Z"]
        layers[channel] = lambda x, y: samples[y][x]
        attack.put("wild.exr", files.exr(layers, 24, 18))
        words = [line[0], "wild.exr", *line[1:], *(roles[channel] or []), "-o", f"out.{out}", "--compression", "none", "--max-memory", str(CAP)]
        # What lies in the picture's own alpha is carried through.
        attack.check(words, seconds=2, spoiled=True)


def metadata(attack, runs):
    """Metadata that is far larger than its file, or says what cannot be."""
    bomb = zlib.compress(bytes(300 * MIB), 9)
    chunks = {"profile": files.chunk(b"iCCP", b"x\0\0" + bomb), "text": files.chunk(b"zTXt", b"Comment\0\0" + bomb),
              "wide text": files.chunk(b"iTXt", b"Comment\0\1\0\0\0" + bomb), "many": files.chunk(b"tEXt", b"a\0b") * 100000}
    rational = lambda tag, at: (tag, 5, 1, struct.pack("<I", at))
    blocks = {"no resolution": files.exif([rational(282, 38), rational(283, 38)]) + struct.pack("<2I", 0, 1),
              "by nothing": files.exif([rational(282, 38), rational(283, 38)]) + struct.pack("<2I", 300, 0),
              "65535 entries": files.exif([rational(282, 38)], 65535) + bytes(12 * 4000),
              "itself": files.exif([(0x8769, 4, 1, struct.pack("<I", 8))]), "beyond": files.exif([(34665, 4, 1, b"\xff" * 4), (274, 3, 1, b"\xff" * 4)])}
    jpeg = attack.clean["photo.jpg"]
    makers = [("odd.png", lambda part=part: files.colored_png(24, 18, part)) for part in chunks.values()]
    makers += [("odd.png", lambda block=block: files.colored_png(24, 18, files.chunk(b"eXIf", block))) for block in blocks.values()]
    makers += [("odd.jpg", lambda block=block: files.with_exif(jpeg, block)) for block in blocks.values()]
    roles = [["inspect", "F"], ["shape", "F", "--normal", "plain.png", "-o", "out.png"], ["shape", "plain.png", "--normal", "F", "-o", "out.jpg"],
             ["relight", "frame.exr", "--environment", "F", "-o", "out.png"], ["relight", "frame.exr", "--lit-sphere", "F", "-o", "out.png"],
             *(["enhance", "F", "--normal", "plain.png", "-o", f"out.{kind}"] for kind in ("jpg", "png", "tif", "exr"))]
    cases = [(maker, role) for maker in makers for role in roles]
    for (name, make), role in attack.random.sample(cases, min(runs, len(cases))):
        attack.reset()
        attack.put(name, make())
        words = [name if w == "F" else w for w in role]
        outcome = attack.check(words, seconds=2)
        written = attack.desk / "out.jpg"
        if outcome.code == 0 and written.exists() and (wrong := zero_resolution(written.read_bytes())):
            attack.fail(words, wrong)


def zero_resolution(jpeg):
    """What is wrong with the resolution that the EXIF of a JPEG tells, if anything."""
    at = jpeg.find(b"Exif\0\0")
    if at < 0:
        return None
    block = jpeg[at + 6:]
    order = "<" if block[:2] == b"II" else ">"
    first = struct.unpack_from(order + "I", block, 4)[0]
    for entry in range(struct.unpack_from(order + "H", block, first)[0]):
        tag, kind, _, place = struct.unpack_from(order + "HHII", block, first + 2 + 12 * entry)
        if tag in (282, 283) and kind == 5 and 0 in struct.unpack_from(order + "2I", block, place):
            return f"its EXIF holds a resolution of {struct.unpack_from(order + '2I', block, place)}"
    return None


def caps(attack, runs):
    """Every command and style within the least memory that its own message names."""
    sides = [(1600, 1200), (3000, 2000)]
    rows = {}

    def large(width, height):
        """Bumps that repeat every 24 rows."""
        if width not in rows:
            layers = files.bumps()
            del layers["Z"]
            names = sorted(layers)
            samples = [struct.pack(f"<{len(names) * width}f", *(layers[n](x, y) for n in names for x in range(width))) for y in range(24)]
            rows[width] = files.exr(layers, width, height, chunks=[struct.pack("<ii", y, len(samples[0])) + samples[y % 24] for y in range(height)])
        return rows[width]

    lines = [[*line, "-o", f"out.{out}"] for line in WORK for out in ("exr", "png", "svg") if out != "svg" or line[-1] in STYLES and line[-1] != "pencil"]
    lines += [["hatch", "--style", style, "--tone", "relight", "-o", "out.png"] for style in STYLES]
    lines += [["shape", "--scale", "2,4,8", "-o", "out.exr"], ["relight", "--environment", "sky.hdr", "--method", "warp", "-o", "out.png"],
              ["shape", "--wrap", "xy", "--scale", "100", "-o", "out.png"]]
    cases = [(line, side) for side in sides for line in lines]
    for line, side in attack.random.sample(cases, min(runs, len(cases))):
        attack.reset()
        attack.put("large.exr", large(*side))
        words = [line[0], "large.exr", *line[1:], "-q", "--max-memory"]
        refused = attack.check([*words, "1M"], cap=CAP, seconds=60)
        named = re.search(rb"--max-memory (\d+)M", refused.said)
        if not named:
            attack.fail([*words, "1M"], "names no memory that is enough")
            continue
        least = int(named.group(1))
        outcome = attack.check([*words, f"{least}M"], cap=least * MIB - START, seconds=120)
        if outcome.code:
            attack.fail([*words, f"{least}M"], "fails with the memory that it asked for")


GROUPS = {"mutations": (mutations, 0.36), "command_lines": (command_lines, 0.36), "kills": (kills, 0.03), "paths": (paths, 0.05),
          "pipes": (pipes, 0.03), "names": (names, 0.03), "sinks": (sinks, 0.02), "limits": (limits, 0.02), "tiles": (tiles, 0.04), "coverage": (coverage, 0.04),
          "metadata": (metadata, 0.02), "memory": (memory, 0.005), "caps": (caps, 0.005)}


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
