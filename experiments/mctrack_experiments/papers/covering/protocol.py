"""How the figures of the covering graph were made, in words."""

from __future__ import annotations

from collections.abc import Sequence

from mctrack_experiments.papers.covering import joint_particles, mean_shift, scenes
from mctrack_experiments.papers.covering.assignment import UNASSIGNED
from mctrack_experiments.papers.covering.code_cost import PIXELS_PER_METRE


def protocol(pitches: Sequence[int], carparks: Sequence[int]) -> dict[str, str]:
    """Return the protocol."""
    return {
        'detections': 'of the camera pipelines, run once without feedback: all trackers get the '
        'same, in which nobody is named; lab6p: stored detections, no images',
        'pitch': f'{scenes.PITCH_S:g} s, cam1, backgrounds given, seeds '
        f'{", ".join(map(str, pitches))}; 1 m',
        'beside, facing': 'the same with cam1 and cam3 (next along the touch line), cam1 and cam2 '
        '(opposite); two: both, one: cam1 alone, over the area of both; gain: the difference',
        'carpark': f'{scenes.CARPARK_S:g} s, people and cars that are not parked, seeds '
        f'{", ".join(map(str, carparks))}; {scenes.CARPARK_GATE_M:g} m',
        'pets': 'S2.L1 view 1 from pixels, frames 398-795; 1 m, in the rectangle of the truth',
        'terrace': f'the first {scenes.TERRACE_S:g} s of both clips; no truth exists',
        'lab6p': 'four cameras, truth once a second; 0.5 m',
        'tuning': 'pitches 1-6, car parks 1-3 and 31, PETS frames 1-397; settings of fusion are '
        "the sites'",
        'scores': 'of rows in the area that the cameras watch; mean of the recordings, switches '
        'added up; motp: 1 - distance / gate',
        'covering_text, covering_code': 'covering graph, flag matrix, greedy exchange; cost: '
        'squared Mahalanobis distance; 0.7 x distance + 0.3 x 100 x (1 - Bhattacharyya), '
        f'{PIXELS_PER_METRE:g} px for a metre',
        'kf_nn': 'fusion with nearest neighbour by distance alone',
        'weighed_gnn, jpda': 'fusion with the default associator, and with JPDA',
        'ms_mt': 'mode seeking on the density of detections, weighted by appearance, Gaussian '
        f'kernel of {mean_shift.BANDWIDTH_M:g} m; Kalman filter',
        'pf_js': f'{joint_particles.PARTICLES} particles of all targets, drawn target by target',
        'assignment': 'greedy exchange and the least sum of costs (scipy) on the same pairs of '
        'every sensor with two tracks or more; a track without a detection costs '
        f'{UNASSIGNED["covering_text"]:g} (text), {UNASSIGNED["covering_code"]:g} (code); '
        'time per tick, in the same process; share_of_tick: of processor time, images included: '
        'greedy: flags and exchange; association: gate, costs and C, too; fusion: all of a tick; '
        'optimal: tracked with the optimum instead; late: more rounds than tracks',
    }
