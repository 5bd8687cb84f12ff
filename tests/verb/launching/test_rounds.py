# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files that name more packages once others are built."""

from colcon_yamllaunch.verb.prepare import MAXIMUM_ROUNDS
from support.user import built, User

# each package installs the name of the next one
CMAKE = """cmake_minimum_required(VERSION 3.10)
project(p{0} NONE)
file(WRITE ${{CMAKE_BINARY_DIR}}/next p{1})
install(FILES ${{CMAKE_BINARY_DIR}}/next DESTINATION .)
"""


def test_it_goes_round_until_nothing_more_is_named(user: User) -> None:
    count = MAXIMUM_ROUNDS + 1
    name = 'p0'
    for number in range(count):
        user.write(
            f'src/p{number}/CMakeLists.txt', CMAKE.format(number, number + 1)
        )
        if number:
            name = f'$(file-content $(find-pkg-prefix {name})/next)'
    message = f'the last is $(find-pkg-prefix {name})'
    user.write('all.yaml', f"launch: [log: {{message: '{message}'}}]\n")
    output = user.launch('all.yaml', code=1)
    names = [f'p{n}' for n in range(MAXIMUM_ROUNDS)]
    assert built(output) == names
    assert f"cannot read '{user.root}/install/p4/next'" in output
    # what is built stays, so the next launch needs fewer
    output = user.launch('all.yaml')
    assert f'the last is {user.root}/install/p5' in output
