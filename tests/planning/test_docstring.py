import doctest

import cohelm.planning


def test_the_example_of_the_package_runs():
    result = doctest.testmod(cohelm.planning)
    assert result.attempted > 10
    assert result.failed == 0
