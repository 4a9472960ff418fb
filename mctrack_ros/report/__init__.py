"""What a run looked like: a page and a video."""

from mctrack_ros.report.birdseye import write_birdseye
from mctrack_ros.report.dropped import drops_of
from mctrack_ros.report.page import write_report
from mctrack_ros.report.session import Session, load_session

__all__ = ['Session', 'drops_of', 'load_session', 'write_birdseye', 'write_report']
