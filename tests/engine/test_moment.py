# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.engine.moment import Moment


def test_what_comes_late_has_the_time_at_which_it_was() -> None:
    moment = Moment(lambda: 7.0)
    assert moment() == 7.0
    moment.past = 3.0
    assert moment() == 3.0
    moment.past = None
    assert moment() == 7.0
