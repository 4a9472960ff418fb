"""
Other people's readers of exported tracks, for the environment of `make readers`.

`python track_readers.py READER FOLDER` prints what a reader finds in the folder's files, as JSON:
for each file rows of id, time, x and y as the reader gives them, and more where there is more.
"""

import json
import sys
import warnings
from pathlib import Path


def kloppy(folder):
    """Read TRACAB and EPTS."""
    from kloppy import metrica, tracab

    files = {
        'tracab': (tracab.load, folder / 'tracab.dat', {'coordinates': 'tracab'}),
        'epts': (metrica.load_tracking_epts, folder / 'epts.txt', {}),
    }
    found = {}
    for form, (load, path, options) in files.items():
        metadata = path.with_name(f'{path.stem}_metadata.xml')
        data = load(meta_data=str(metadata), raw_data=str(path), **options)
        rows = [
            (_number(player.player_id), frame.frame_id, there.coordinates.x, there.coordinates.y)
            for frame in data.records
            for player, there in frame.players_data.items()
            if there.coordinates is not None and there.coordinates.x == there.coordinates.x
        ]
        ball = data.records[-1].ball_coordinates
        found[form] = {
            'rate': data.metadata.frame_rate,
            'rows': rows,
            'ball': [ball.x, ball.y, ball.z],
            'away': sorted(_number(player.player_id) for player in data.metadata.teams[1].players),
        }
    return found


def floodlight(folder):
    """Read TRACAB."""
    from floodlight.io.tracab import read_position_data_dat

    path = folder / 'tracab.dat'
    metadata = path.with_name('tracab_metadata.xml')
    places, _, _, sheets, pitch = read_position_data_dat(str(path), str(metadata))
    rows = []
    for team in ('Home', 'Away'):
        for jersey, column in sheets[team].get_links('jID', 'xID').items():
            for frame, (x, y) in enumerate(places['HT1'][team].player(column)):
                if x == x:
                    rows.append((int(jersey), frame, x, y))
    return {'tracab': {'rows': rows, 'pitch': [*pitch.xlim, *pitch.ylim]}}


def movingpandas(folder):
    """Read Moving Features in both encodings."""
    import pandas
    from movingpandas import read_mf_dict, read_mf_json

    found = {'mf-json': list(read_mf_json(folder / 'mf-json.json', 'track_id').trajectories)}
    lines = json.loads((folder / 'geojson.geojson').read_text())['features']
    found['geojson'] = [read_mf_dict(feature) for feature in lines]
    began = pandas.Timestamp(0)
    return {
        form: {
            'rows': [
                (int(row.track_id), (time - began).value, row.geometry.x, row.geometry.y)
                for each in trajectories
                for time, row in each.df.iterrows()
            ],
            'pieces': len(trajectories),
        }
        for form, trajectories in found.items()
    }


def pedpy(folder):
    """Read trajectories of pedestrian research."""
    from pedpy import load_trajectory

    read = load_trajectory(trajectory_file=folder / 'pedpy.txt')
    rows = read.data[['id', 'frame', 'x', 'y']].to_numpy().tolist()
    return {'pedpy': {'rate': read.frame_rate, 'rows': rows}}


def _number(player_id):
    return int(player_id.removeprefix('track_'))


if __name__ == '__main__':
    warnings.simplefilter('ignore')
    print(json.dumps(globals()[sys.argv[1]](Path(sys.argv[2]))))
