# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Launch files that name more packages once others are built."""

from support.user import built, User

# each package installs the name of the next one
CMAKE = """cmake_minimum_required(VERSION 3.10)
project(p{0} NONE)
file(WRITE ${{CMAKE_BINARY_DIR}}/next p{1})
install(FILES ${{CMAKE_BINARY_DIR}}/next DESTINATION .)
"""


def test_it_goes_round_until_nothing_more_is_named(user: User) -> None:
    count, name = 7, 'p0'
    for number in range(count):
        user.write(
            f'src/p{number}/CMakeLists.txt', CMAKE.format(number, number + 1)
        )
        if number:
            name = f'$(file-content $(find-pkg-prefix {name})/next)'
    message = f'the last is $(find-pkg-prefix {name})'
    user.write('all.yaml', f"launch: [log: {{message: '{message}'}}]\n")
    output = user.launch('all.yaml')
    # in the order of the rounds, as each one needs what the last one built
    assert built(output) == [f'p{n}' for n in range(count)]
    assert f'the last is {user.root}/install/p{count - 1}' in output
