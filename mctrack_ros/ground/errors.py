"""What the files between pixels and metres can be wrong in."""


class CalibrationError(ValueError):
    """A calibration or its file that cannot be used; names the file and the reason."""


class GridError(CalibrationError):
    """A transformation grid that cannot be used."""


class SceneError(CalibrationError):
    """A scene file that cannot be used."""
