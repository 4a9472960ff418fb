"""Work that goes to processes, done in this one: to start one costs more than short work does."""

from concurrent.futures import Future


class Here:
    """An executor that does what it is given at once."""

    def __init__(self, *_):
        pass

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def submit(self, work, *arguments):
        future = Future()
        future.set_result(work(*arguments))
        return future

    def map(self, work, jobs):
        return map(work, jobs)

    def shutdown(self, **_):
        pass


class RenderingHere(Here):
    """One for `simulate`: it begins with the world that is to be shown."""

    def __init__(self, count, context, begin, arguments):
        from mctrack_ros.simulation import recording

        recording._workers[:] = [recording._Worker(*arguments)]
