"""The times of a video's images, where its file states them and where it does not."""

from __future__ import annotations

from mctrack_ros.interfaces import RESTART_NS

_GAP_S, _GAP_PERIODS = 1.0, 10


class ImageTimes:
    """
    Rising times for the images of one file.

    An image without a time comes one period after the last. One whose time is not later than
    the last is left out. Where times step back by more than a second the file begins anew (a
    recorder that started again, files that were joined): it goes on one period after the last.

    Parameters
    ----------
    period_s : float
        Time between two images where the file says nothing, s.
    constant : bool
        Whether all images are a period apart, whatever the file says.

    """

    def __init__(self, period_s: float, *, constant: bool) -> None:
        self._period_s, self._constant = period_s, constant
        self._last_s: float | None = None
        self._shift_s, self._index = 0.0, 0
        self._untimed, self._unordered, self._restarts, self._gaps = 0, 0, 0, 0
        self._first_restart = self._first_gap = ''

    def time_of(self, stated_s: float | None) -> float | None:
        """
        Return the time of the next image, s; None: it is left out.

        Parameters
        ----------
        stated_s : float, optional
            What the file says, s.

        """
        last_s, self._index = self._last_s, self._index + 1
        if self._constant:
            return (self._index - 1) * self._period_s
        if stated_s is None:
            self._untimed += 1
            time_s = 0.0 if last_s is None else last_s + self._period_s
        else:
            time_s = stated_s + self._shift_s
        if last_s is not None:
            if time_s < last_s - RESTART_NS / 1e9:
                time_s = self._begin_anew(time_s, last_s)
            elif time_s <= last_s:
                self._unordered += 1
                return None
            self._note_gap(time_s, last_s)
        self._last_s = time_s
        return time_s

    def pass_over(self, count: int) -> None:
        """Count images that cannot be decoded: each took its period all the same."""
        self._index += count

    def notes(self) -> list[str]:
        """Return what was made up or left out, a line each."""
        repairs = [
            (self._untimed, 'without a time, put one period after the image before'),
            (self._unordered, 'left out: their times are not later than those before'),
        ]
        lines = [f'{count} image{"s" if count > 1 else ""} {what}' for count, what in repairs]
        lines += [
            f'its times step back {self._restarts} times, first {self._first_restart}: '
            'it goes on one period after the last image',
            f'its times leap {self._gaps} times, first {self._first_gap}: the gap is kept',
        ]
        counts = [self._untimed, self._unordered, self._restarts, self._gaps]
        return [line for count, line in zip(counts, lines) if count]

    def _begin_anew(self, time_s: float, last_s: float) -> float:
        self._first_restart = self._first_restart or f'from {last_s:.3f} to {time_s:.3f} s'
        self._restarts += 1
        self._shift_s += last_s + self._period_s - time_s
        return last_s + self._period_s

    def _note_gap(self, time_s: float, last_s: float) -> None:
        if time_s - last_s > max(_GAP_S, _GAP_PERIODS * self._period_s):
            self._first_gap = self._first_gap or f'from {last_s:.3f} to {time_s:.3f} s'
            self._gaps += 1
