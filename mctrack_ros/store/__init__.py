"""The trajectory database: where tracks and events are kept, and asked for."""

from mctrack_ros.store.bags import run_of_bag, store_bag, write_bag
from mctrack_ros.store.database import Database
from mctrack_ros.store.errors import StoreError
from mctrack_ros.store.live.feed import FeedOptions
from mctrack_ros.store.live.live_store import LiveStore
from mctrack_ros.store.queries.areas import crossings, events, heat_map, occupancy
from mctrack_ros.store.queries.run import Run, View
from mctrack_ros.store.queries.runs import runs
from mctrack_ros.store.queries.tracks import meetings, near, summaries, trajectory
from mctrack_ros.store.queries.videos import VideoFile, link_videos, showings
from mctrack_ros.store.runs import NewRun
from mctrack_ros.store.upkeep.check import check
from mctrack_ros.store.upkeep.forget_track import forget_track
from mctrack_ros.store.upkeep.retention import Keep, forget_old, forget_run
from mctrack_ros.store.writer import TrajectoryWriter

__all__ = [
    'Database',
    'FeedOptions',
    'Keep',
    'LiveStore',
    'NewRun',
    'Run',
    'StoreError',
    'TrajectoryWriter',
    'VideoFile',
    'View',
    'check',
    'crossings',
    'events',
    'forget_old',
    'forget_run',
    'forget_track',
    'heat_map',
    'link_videos',
    'meetings',
    'near',
    'occupancy',
    'run_of_bag',
    'runs',
    'showings',
    'store_bag',
    'summaries',
    'trajectory',
    'write_bag',
]
