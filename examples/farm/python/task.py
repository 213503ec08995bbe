#!/usr/bin/env python3
"""Makes a chunk of frames in Python, in the place of `relievo run` on a farm.

    task.py run RECIPE INPUT --frames 1001-1010 -o OUTPUT [--skip-existing] [--keep-going] [--missing-frame error|skip]
            [--progress json] [--threads N]

Takes the arguments that the farm scripts give to relievo, prints the same JSON lines and ends with the same status, so
it is the program that they are told to run. What chooses a look, --save-recipe, is handed to relievo itself. A recipe is
one for `enhance` or `relight`, and frames are EXR files: they keep their layers and get those of layers() beside them.

Needs NumPy, pyrelievo and OpenEXR, all by pip.
"""

import argparse
import json
import os
import re
import signal
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
import OpenEXR

import pyrelievo


def layers(look, frame, engine):
    """The channels that a frame gets, by name. What else a pipeline does with arrays goes here."""
    planes = dict(zip("RGB", np.moveaxis(look(frame, engine=engine), 2, 0), strict=True))
    if frame.alpha is not None:
        planes["A"] = frame.alpha
    return {f"relievo.Picture.{end}": plane.astype(np.float16) for end, plane in planes.items()}


def make(look, engine, pattern, number, output):
    """Makes one frame: whole under its own name, or not there."""
    made = layers(look, pyrelievo.load(pattern, frame=number), engine)
    with OpenEXR.File(numbered(pattern, number), separate_channels=True) as file:
        for name, plane in made.items():
            file.parts[0].channels[name] = OpenEXR.Channel(name, plane)
        for part in file.parts:
            # Lossy compression would take from the layers again.
            part.header["compression"] = OpenEXR.ZIP_COMPRESSION
        handle, partial = tempfile.mkstemp(prefix=".task-", suffix=".part", dir=output.parent)
        os.close(handle)
        try:
            file.write(partial)
            # As another program would have made it.
            os.chmod(partial, 0o666 & ~umask())
            os.replace(partial, output)
        except BaseException:
            os.unlink(partial)
            raise


def numbered(pattern, number):
    """The name of a frame: #### is its number."""
    return re.sub("#+", lambda marks: f"{number:0{len(marks[0])}d}", pattern)


def numbers(text):
    """Frames as in 1001-1240, 1-100x2, 1-100:2 or 1,5,9."""
    found = []
    for part in text.split(","):
        match = re.fullmatch(r"(-?\d+)(?:-(-?\d+)(?:[x:]([1-9]\d*))?)?", part)
        if not match:
            raise argparse.ArgumentTypeError(f"'{part}' is no range of frames")
        first, last, step = (match[1], match[2] or match[1], match[3] or 1)
        found += range(int(first), int(last) + 1, int(step))
    return found


def umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask


class Stop:
    """Set by the first signal, so that the frame in hand is finished; a second one drops it."""

    status = 0

    def __init__(self):
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, self.ask)

    def ask(self, number, _):
        self.status = 128 + number
        signal.signal(number, signal.SIG_DFL)


def run(given):
    """Makes the frames; returns the exit status."""
    stop, engine = Stop(), pyrelievo.Engine(threads=given.threads)
    look = pyrelievo.Recipe.read(given.recipe)
    counts = dict.fromkeys(("done", "skipped", "missing", "failed"), 0)

    def say(event, **more):
        if given.progress == "json":
            print(json.dumps({"event": event, **more}), file=sys.stderr, flush=True)

    total, began = len(given.frames), time.monotonic()
    say("begin", total=total)
    for finished, number in enumerate(given.frames, start=1):
        if stop.status:
            break
        output, more = Path(numbered(given.output, number)), {}
        if given.skip_existing and output.exists():
            status = "skipped"
        elif given.missing_frame == "skip" and not os.path.exists(numbered(given.input, number)):
            status = "missing"
        else:
            try:
                make(look, engine, given.input, number, output)
                status = "done"
            except (OSError, ValueError, RuntimeError) as error:
                status, more = "failed", {"message": str(error)}
                print(f"error: {error}", file=sys.stderr, flush=True)
        counts[status] += 1
        left = (time.monotonic() - began) / finished * (total - finished)
        say("frame", frame=number, status=status, finished=finished, total=total, eta_seconds=left, **more)
        if status == "failed" and not given.keep_going:
            break
    say("end", **counts)
    if stop.status or not counts["failed"]:
        return stop.status
    return 3 if given.keep_going and counts["done"] + counts["skipped"] else 1


def main(arguments):
    if "--save-recipe" in arguments:
        os.execv(sys.executable, [sys.executable, "-m", "pyrelievo", *arguments])
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", choices=["run"])
    parser.add_argument("recipe")
    parser.add_argument("input")
    parser.add_argument("--frames", type=numbers, required=True)
    parser.add_argument("-o", dest="output", required=True)
    parser.add_argument("--skip-existing", action="store_true")
    parser.add_argument("--keep-going", action="store_true")
    parser.add_argument("--missing-frame", choices=["error", "skip"], default="error")
    parser.add_argument("--progress", choices=["json"])
    parser.add_argument("--threads", type=int)
    # A recipe of a whole sequence leaves nothing to be chosen, and one frame is made at a time.
    parser.add_argument("--sample-frames", choices=["none"], help=argparse.SUPPRESS)
    parser.add_argument("--max-memory", help=argparse.SUPPRESS)
    try:
        return run(parser.parse_args(arguments))
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
