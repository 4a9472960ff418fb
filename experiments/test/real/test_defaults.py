import pytest

from mctrack_experiments.real import defaults
from mctrack_experiments.real.defaults import Search, defaults_table, suits_others
from mctrack_ros.evaluation.figures import Figures


class Known(Search):
    """Settings are worth what a table says; choices add up."""

    def __init__(self, gains):
        super().__init__(data_set=None)
        self.gains = gains

    def score(self, settings, seed):
        gain = sum(self.gains.get(choice, 0.0) for choice in settings.items())
        return 0.8 + gain, 0.7 + gain


GATE, MODEL = ('association.gate', 18.4), ('motion.model', 'interacting')


def test_tuning_keeps_what_adds_something_and_one_value_of_each():
    search = Known({GATE: 0.02, ('association.gate', 9.2): 0.01, MODEL: 0.03})
    assert search.tuned() == dict([GATE, MODEL])
    assert Known({GATE: -0.01}).tuned() == {}


def test_settings_for_a_data_set_are_chosen_on_the_others_alone():
    searches = {'a': Known({MODEL: 0.5}), 'b': Known({GATE: 0.1}), 'c': Known({GATE: 0.1})}
    tuned = {name: search.tuned() for name, search in searches.items()}
    assert suits_others('a', searches, tuned) == dict([GATE])
    assert MODEL in suits_others('b', searches, tuned).items()


@pytest.mark.parametrize(('tuned', 'verdict'), [(0.905, 'yes'), (0.93, '**no**')])
def test_table_says_whether_defaults_are_near_enough(tuned, verdict):
    kinds = {defaults.DEFAULT: 0.9, defaults.TUNED: tuned, defaults.LEFT_OUT: 0.9}
    figures = {
        f'{name}.{kind}.{prefix}{figure}': value
        for name in defaults.TITLES
        for kind, value in kinds.items()
        for prefix in ('', 'recorded.')
        for figure in defaults.FIGURES
    }
    figures |= {f'{n}.lost.{f}': tuned - 0.9 for n in defaults.TITLES for f in defaults.FIGURES}
    settings = {name: {defaults.TUNED: dict([GATE])} for name in defaults.TITLES}
    table = defaults_table(Figures('defaults', '', {'settings': settings}, figures))
    row = next(line for line in table if line.startswith('| CMC2'))
    assert '`association.gate` 18.4' in row
    assert row.endswith(f'| {verdict} |')
