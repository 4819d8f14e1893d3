"""What a worker process may be made to do; a module of its own and light, because such a process imports it."""

import ctypes
import os
import signal
import sys
import time


def hang():
    time.sleep(3600)


def crash():
    """As a fault in compiled code does."""
    os.kill(os.getpid(), signal.SIGSEGV)


def crash_in_c():
    """A real one: the C library reads the string at address 0."""
    ctypes.string_at(0)


def eat():
    """100 MB every two hundredths of a second."""
    eaten = []
    while True:
        eaten.append(b"1" * 100_000_000)
        time.sleep(0.02)


def leave():
    sys.exit(3)


def refuse():
    raise RuntimeError("not today")


def chatter():
    """Print where answers go, from Python and from below it."""
    print("hello")
    os.write(1, b"hello")


DEEDS = {deed.__name__: deed for deed in (hang, crash, crash_in_c, eat, leave, refuse, chatter)}


def do(deed, value):
    """Do something bad on request, else say the value and by which process."""
    if deed:
        DEEDS[deed]()
    return value, os.getpid()


def read_only(array):
    """Whether an array came read-only, and the array."""
    return not array.flags.writeable, array
