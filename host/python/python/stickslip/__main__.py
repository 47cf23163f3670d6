"""The command `stickslip`."""

import signal
import sys

from ._stickslip import command


def main() -> None:
    """Runs the command line of this process."""
    if sys.argv[1:2] == ["demo"]:
        sys.exit("demo builds and runs the firmware: `make demo` in a clone of the repository")
    # Python would only note Ctrl-C until the command ends.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(command(sys.argv[1:]))


if __name__ == "__main__":
    main()
