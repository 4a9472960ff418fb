"""Only what dead processes left is removed."""

import fcntl

from mctrack_ros.ros.graph.shared_memory import remove_leftovers


def segment(folder, name):
    (folder / name).write_bytes(b'data')
    (folder / f'{name}_el').touch()


def test_segments_without_a_process_are_removed_and_others_stay(tmp_path):
    segment(tmp_path, 'fastrtps_0123456789abcdef')
    segment(tmp_path, 'fastrtps_fedcba9876543210')
    segment(tmp_path, 'fastrtps_port7411')
    (tmp_path / 'something_else').touch()
    with (tmp_path / 'fastrtps_fedcba9876543210_el').open() as held:
        fcntl.flock(held, fcntl.LOCK_EX)
        assert remove_leftovers(tmp_path) == 1
        assert sorted(path.name for path in tmp_path.iterdir()) == [
            'fastrtps_fedcba9876543210',
            'fastrtps_fedcba9876543210_el',
            'fastrtps_port7411',
            'fastrtps_port7411_el',
            'something_else',
        ]


def test_a_system_without_shared_memory_has_no_leftovers(tmp_path):
    assert remove_leftovers(tmp_path / 'nowhere') == 0
