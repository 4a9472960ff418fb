"""Compilation of the inner loops that a node calls, before its first message."""

from __future__ import annotations

import signal
import threading

from mctrack_ros.compiled import prepare


def compile_loops(package: str, *but: str) -> None:
    """
    Compile the inner loops that a node calls; meanwhile a signal ends the process at once.

    It does so by the system's own action: a handler in Python would wait seconds for LLVM.

    Parameters
    ----------
    package, *but : str
        What is compiled and what is not; see `prepare`.

    """
    if threading.current_thread() is not threading.main_thread():
        prepare(package, *but)
        return
    signals = signal.SIGINT, signal.SIGTERM
    handlers = [signal.signal(number, signal.SIG_DFL) for number in signals]
    try:
        prepare(package, *but)
    finally:
        for number, handler in zip(signals, handlers, strict=True):
            signal.signal(number, handler)
