import pytest

from mctrack_experiments import ablations

TABLES = {name: table for name, table in vars(ablations).items() if name.endswith('RULES')}


@pytest.mark.parametrize('table', TABLES)
def test_what_a_rule_replaces_is_there(table):
    for rule in TABLES[table].values():
        for module, name in rule.patches:
            assert hasattr(module, name), (rule.what, name)
