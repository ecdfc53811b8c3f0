"""The command ``sphvar``."""

import signal
import sys


def main() -> None:
    """Run the command with the arguments of the process and exit with its status."""
    from ._sphvar import run_command

    # The command handles Ctrl-C itself. A signal that the process was started to ignore, as `nohup` and shells
    # do, stays ignored.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    sys.exit(run_command(sys.argv[1:]))


if __name__ == "__main__":
    main()
