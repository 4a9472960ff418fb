"""The calibration page: the event-tracking paper's TG-creator."""
