#!/usr/bin/env python3
"""Runs a command of relievo and tells an Open Job Description session how far it is.

    progress.py [--also OPTIONS] COMMAND [ARGUMENT ...]

COMMAND is run with `--progress json` among its arguments. Its JSON lines become `openjd_progress`, `openjd_status` and
`openjd_fail`; all else it prints goes through as it is. OPTIONS is one text of further arguments, quoted as for a shell.
The exit status is the command's own, or 128 and the number of the signal that ended it.
"""

import json
import shlex
import signal
import subprocess
import sys

# A message of failure names this many frames.
FRAMES_NAMED = 5


class Teller:
    """Turns lines of relievo's stderr into lines for the session."""

    def __init__(self):
        self.last_error = None
        self.failed = []

    def line(self, line):
        try:
            event = json.loads(line)
        except ValueError:
            event = None
        told = self.told(event) if isinstance(event, dict) else None
        if told is None:
            if line.startswith("error: "):
                self.last_error = line.removeprefix("error: ")
            told = [line]
        for text in told:
            print(text, flush=True)

    def told(self, event):
        """The lines that say what the event says; None where it is of no known kind."""
        match event.get("event"):
            case "begin":
                return ["openjd_progress: 0", f"openjd_status: {event['total']} frames to make"]
            case "frame":
                frame, status = event["frame"], event["status"]
                finished, total = event["finished"], event["total"]
                lines = [f"openjd_progress: {100 * finished / total:.1f}"]
                told = f"frame {frame} {status}, {finished} of {total}"
                left = event.get("eta_seconds")
                if left is not None and finished < total:
                    told += f", {left:.0f} s left"
                lines.append(f"openjd_status: {told}")
                if status == "failed":
                    self.failed.append(f"{frame}: {event.get('message', 'no reason given')}")
                return lines
            case "end":
                counts = ", ".join(f"{event[key]} {key}" for key in ("done", "skipped", "missing", "failed"))
                return [f"openjd_status: {counts}"]
        return None

    def fail(self, status):
        """Says why the command failed: the frames, else its last error. A command told to stop has not failed."""
        if status == 0 or status in (128 + signal.SIGINT, 128 + signal.SIGTERM):
            return
        if self.failed:
            named = "; ".join(self.failed[:FRAMES_NAMED])
            more = len(self.failed) - FRAMES_NAMED
            why = f"{len(self.failed)} failed: {named}" + (f"; and {more} more" if more > 0 else "")
        else:
            why = self.last_error or f"ended with status {status}"
        print(f"openjd_fail: {why}", flush=True)


def main(arguments):
    also = []
    if arguments[:1] == ["--also"]:
        also = shlex.split(arguments[1])
        arguments = arguments[2:]
    if not arguments:
        sys.exit(__doc__)

    child = None
    asked = told = False

    def stop():
        nonlocal told
        if asked and child is not None and not told:
            told = True
            child.send_signal(signal.SIGTERM)

    # A farm that cancels tells this process alone: the command is told to finish the frames in hand. Once: a second signal
    # would drop them.
    def terminate(*_):
        nonlocal asked
        asked = True
        stop()

    signal.signal(signal.SIGTERM, terminate)
    # A terminal tells both.
    signal.signal(signal.SIGINT, lambda *_: None)
    child = subprocess.Popen([*arguments, *also], stderr=subprocess.PIPE, text=True, encoding="utf-8", errors="replace")
    stop()
    teller = Teller()
    for line in child.stderr:
        teller.line(line.rstrip("\n"))
    status = child.wait()
    if status < 0:
        status = 128 - status
    teller.fail(status)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
