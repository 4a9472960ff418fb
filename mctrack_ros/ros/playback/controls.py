"""Services and keys by which a player is paused, stepped and moved."""

from __future__ import annotations

import os
import sys
import termios
import threading
import tty
from collections.abc import Callable, Mapping
from importlib import import_module
from types import ModuleType
from typing import Any

from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.service import Service
from std_srvs.srv import Trigger

from mctrack_ros.ros.playback.pacing import SECOND_NS, Transport

_FACTOR = 1.1
"""By so much a key changes the speed, as in rosbag2."""
_SKIP_S = {'left': -5.0, 'right': 5.0}
"""Distance that these keys jump, s."""
_ESCAPE, _OPENINGS, _FIRST_END, _LAST_END = '\x1b', ('[', 'O'), '@', '~'
"""Of a key's escape sequence (ECMA-48): how it opens, and between what its end lies."""
_ARROWS = {'C': 'right', 'D': 'left'}
"""How the escape sequences of keys end."""
_ALL = 2**63
"""More messages than a bag holds: rosbag2 asks for all by 0."""


class Controls:
    """
    Services of a player below its name, of rosbag2's types where they are installed.

    Where they are not, `pause`, `resume`, `toggle_paused`, `play_next` and `burst` are
    `std_srvs/Trigger`; speed and place are parameters of the node.

    Parameters
    ----------
    node : Node
        The player.
    transport : Transport
        What is set.
    burst : int
        Messages that go at once where the service has no field for how many.
    seek : callable
        Goes to a log time, ns; tells whether that is in what is played.
    skip : callable
        Goes so many seconds on, or back.

    """

    def __init__(
        self,
        node: Node,
        transport: Transport,
        burst: int,
        seek: Callable[[int], bool],
        skip: Callable[[float], None],
    ) -> None:
        self._node, self._transport, self._burst = node, transport, burst
        self._seek, self._skip = seek, skip
        self._services: list[Service[Any, Any]] = []

    def open(self) -> None:
        """Offer the services, and listen to keys if the standard input is a pipe or a terminal."""
        own, rosbag2 = self._transport, _rosbag2()
        self._offer('pause', 'Pause', lambda _: own.pause(True))
        self._offer('resume', 'Resume', lambda _: own.pause(False))
        self._offer('toggle_paused', 'TogglePaused', lambda _: own.pause(not own.is_paused))
        self._offer('play_next', 'PlayNext', lambda _: self._gone(own.burst(1)))
        self._offer('burst', 'Burst', self._on_burst)
        if rosbag2 is not None:
            self._offer('set_rate', 'SetRate', self._on_set_rate)
            self._offer('seek', 'Seek', self._on_seek)
            self._offer('get_rate', 'GetRate', lambda _: {'rate': own.rate})
            self._offer('is_paused', 'IsPaused', lambda _: {'paused': own.is_paused})
        self._keys = _KeyInput()
        threading.Thread(target=self._listen, name='keys', daemon=True).start()

    def close(self) -> None:
        """Offer nothing any more."""
        if self._services:
            self._keys.close()
        for service in self._services:
            self._node.destroy_service(service)
        self._services.clear()

    def _offer(self, name: str, kind: str, act: Callable[[Any], Mapping[str, Any] | None]) -> None:
        """Offer a service that does something; that returns what is not simply a success."""
        rosbag2 = _rosbag2()
        of_kind = Trigger if rosbag2 is None else getattr(rosbag2, kind)

        def answer(request: Any, response: Any) -> Any:
            for field, value in {'success': True, **(act(request) or {})}.items():
                if hasattr(response, field):
                    setattr(response, field, value)
            return response

        service = self._node.create_service(of_kind, f'~/{name}', answer)
        self._services.append(service)

    def _on_burst(self, request: Any) -> dict[str, Any]:
        count = int(getattr(request, 'num_messages', self._burst))
        return self._gone(self._transport.burst(count or _ALL))

    def _gone(self, count: int) -> dict[str, Any]:
        """Return an answer that tells how many messages went."""
        answer = f'messages that went: {count}'
        return {'success': count > 0, 'message': answer, 'actually_burst': count}

    def _on_set_rate(self, request: Any) -> dict[str, Any]:
        return {'success': self._set_rate(request.rate)}

    def _set_rate(self, rate: float) -> bool:
        """Set the parameter `rate`, which the speed follows; say why not."""
        (result,) = self._node.set_parameters([Parameter('rate', value=float(rate))])
        if not result.successful:
            self._node.get_logger().warning(f'the speed stays: {result.reason}')
        return bool(result.successful)

    def _on_seek(self, request: Any) -> dict[str, Any]:
        return {'success': self._seek(request.time.sec * SECOND_NS + request.time.nanosec)}

    def _listen(self) -> None:
        """Follow keys until the input ends."""
        while key := self._keys.next():
            self.press(key)

    def press(self, key: str) -> None:
        """Do what a key means."""
        own = self._transport
        if key == ' ':
            own.pause(not own.is_paused)
        elif key == 'n':
            own.step(1)
        elif key in _SKIP_S:
            self._skip(_SKIP_S[key])
        elif key in '+-':
            self._set_rate(own.rate * (_FACTOR if key == '+' else 1 / _FACTOR))


class _KeyInput:
    """Single keys of the standard input: of a pipe, or of the terminal that this process has."""

    def __init__(self) -> None:
        self._modes: list[Any] | None = None
        try:
            self._number = sys.stdin.fileno()
            if sys.stdin.isatty() and os.tcgetpgrp(self._number) == os.getpgrp():
                self._modes = termios.tcgetattr(self._number)
                tty.setcbreak(self._number)
        except (OSError, ValueError, termios.error):
            self._number = -1

    def next(self) -> str:
        """Return the next key: a character or `left`, `right`, `other`; empty: no more."""
        if self._number < 0 or (self._modes is None and os.isatty(self._number)):
            return ''
        key = self._character()
        if key != _ESCAPE or (key := self._character()) not in _OPENINGS:
            return key
        while (end := self._character()) and not _FIRST_END <= end <= _LAST_END:
            pass  # numbers, of a key with shift for example
        return end and _ARROWS.get(end, 'other')

    def _character(self) -> str:
        """Return one character; empty: there are no more."""
        try:
            return os.read(self._number, 1).decode(errors='replace')
        except OSError:
            return ''

    def close(self) -> None:
        """Leave the terminal as it was."""
        if self._modes is not None:
            termios.tcsetattr(self._number, termios.TCSADRAIN, self._modes)


def _rosbag2() -> ModuleType | None:
    """Return the services of rosbag2, if they are installed."""
    try:
        return import_module('rosbag2_interfaces.srv')
    except ImportError:
        return None
