"""The command `flatnet`, and `python -m flatnet`: what ends it is heeded from its first moment."""

from __future__ import annotations

import os
import signal
import sys
from contextlib import suppress
from types import FrameType


def main() -> int:
    """Run the command.

    Its imports take a second, and some libraries swallow an exception that comes up while they are imported: until
    they are done, Ctrl-C and the like end the process at once.
    """
    before = {}
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)  # Windows has no SIGHUP
        if number is not None and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            before[number] = signal.signal(number, _end_at_once)
    from flatnet.cli import main as command

    for number, handler in before.items():
        signal.signal(number, handler)
    return command()


def _end_at_once(number: int, frame: FrameType | None) -> None:
    with suppress(OSError):  # nobody listens
        os.write(2, b"interrupted; nothing was written.\n")
    os._exit(130)


if __name__ == "__main__":
    sys.exit(main())
