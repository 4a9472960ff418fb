"""Errors that the user can mend; they are shown as one line."""


def expected_errors() -> tuple[type[BaseException], ...]:
    """Return the exceptions that bad input raises."""
    from mctrack_ros.codec import CodecError
    from mctrack_ros.config import ConfigError
    from mctrack_ros.ground import CalibrationError
    from mctrack_ros.recording import BagError, MotTextError
    from mctrack_ros.replay.lockstep import ReplayError
    from mctrack_ros.store.errors import StoreError

    return (
        BagError,
        CalibrationError,
        CodecError,
        ConfigError,
        MotTextError,
        ReplayError,
        StoreError,
        OSError,
        ValueError,
    )
