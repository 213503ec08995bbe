"""The command line: ``python -m pyrelievo``, or ``relievo``."""

import sys

from . import _relievo


def main() -> None:
    """Runs the command line with the arguments of this process, and ends it."""
    sys.exit(_relievo.run_command_line(["relievo", *sys.argv[1:]]))


if __name__ == "__main__":
    main()
