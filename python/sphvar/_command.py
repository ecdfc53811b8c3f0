"""The command ``sphvar``."""

import signal
import sys


def main() -> None:
    """Run the command with the arguments of the process."""
    from ._sphvar import run_command

    # The command handles Ctrl-C itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run_command(sys.argv[1:]))


if __name__ == "__main__":
    main()
