"""The command line: ``python -m torquewise``, or the script ``torquewise``."""

import sys

from ._core import command_line


def main() -> int:
    """Runs the command that the words of the command line name; returns the code to exit with."""
    return command_line(["torquewise", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
