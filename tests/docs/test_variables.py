# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""docs/files_and_variables.md knows what the code reads, sets and writes."""

import ast
from collections.abc import Iterator
from pathlib import Path
import re

from colcon_yamllaunch.control.socket_folder import SUFFIX
from colcon_yamllaunch.observers.log_store import INDEX_NAME
from colcon_yamllaunch.verb.environment_variables import (
    ALL_LOGS_LIMIT,
    KEPT_LOG_FOLDERS,
)
from colcon_yamllaunch.workspace.building.build_lock import LOCK_NAME
from colcon_yamllaunch.workspace.colcon.colcon_cache import CACHE_NAME
from colcon_yamllaunch.workspace.environment.environment_cache import (
    FOLDER_NAME,
    MAXIMUM_RECORDS,
)
from colcon_yamllaunch.workspace.freshness.build_record import RECORD_NAME

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / 'docs/files_and_variables.md').read_text(encoding='utf-8')
VARIABLE = re.compile(r'[A-Z][A-Z0-9]*(_[A-Z0-9]+)+')
#: Look like variables, or are some that make no difference to a user.
OTHERS = {
    'ABS_SYMLINK_OR_COPY',  # a value
    'BOOT_FAIL',  # a state of Slurm, as the next ones
    'NODE_FAIL',
    'OUT_OF_MEMORY',
    'AMENT_IGNORE',  # a file, as the next two
    'CATKIN_IGNORE',
    'COLCON_IGNORE',
    'CMAKE_CACHEFILE_DIR',  # in CMake's cache, as the next one
    'CMAKE_HOME_DIRECTORY',
    'CMAKE_PROJECT_NAME',  # in CMake's files, as the next ones
    'CMAKE_CURRENT_LIST_DIR',
    'CMAKE_CURRENT_SOURCE_DIR',
    'CMAKE_SOURCE_DIR',
    'PROJECT_SOURCE_DIR',
    'NAME_WE',
    'OUTPUT_NAME',
    'PARENT_SCOPE',
    'PROJECT_NAME',
    'COLCON_CURRENT_PREFIX',  # within colcon's scripts
    'COLCON_DEFAULT_EXECUTOR',
    'COLCON_LOG_LEVEL',
    'COLCON_TRACE',
    'COMP_LINE',  # of the shell's completion, as the next one
    'COMP_POINT',
    'LD_LIBRARY_PATH',  # passed on as it is
    'SYSLOG_IDENTIFIER',  # a field of the journal, as the next one
    'SYSLOG_PID',
    'VERSION_ID',  # of a system, in os-release
    'SC_CLK_TCK',  # of the system
    'SC_OPEN_MAX',
    'SC_PAGE_SIZE',
}


def constants() -> Iterator[str]:
    """Return the constants of the code that look like variables."""
    for path in (ROOT / 'colcon_yamllaunch').rglob('*.py'):
        for node in ast.walk(ast.parse(path.read_text(encoding='utf-8'))):
            value = getattr(node, 'value', None)
            if isinstance(value, str) and VARIABLE.fullmatch(value):
                yield value


def test_each_variable_is_told() -> None:
    found = set(constants())
    assert 'COLCON_LAUNCH_ID' in found
    told = set(re.findall(r'`(\w+)`', TEXT))
    assert sorted(found - told - OTHERS) == []


def test_nothing_is_told_that_the_code_does_not_know() -> None:
    first_cells = re.findall(r'^\| (`[A-Z_`, ]+`) \|', TEXT, re.MULTILINE)
    told = set(re.findall(r'`([A-Z_]+)`', ' '.join(first_cells)))
    assert len(told) > 20
    files = (ROOT / 'colcon_yamllaunch').rglob('*.py')
    code = '\n'.join(path.read_text(encoding='utf-8') for path in files)
    assert sorted(name for name in told if f"'{name}'" not in code) == []


def test_each_file_is_told() -> None:
    for name in (
        f'`build/{LOCK_NAME}`',
        f'`build/{CACHE_NAME}`',
        f'`build/{FOLDER_NAME}/`',
        f'`{RECORD_NAME}`',
        f'colcon-launch/PID{SUFFIX}`',
        f'for {MAXIMUM_RECORDS} environments',
        f'a number ({KEPT_LOG_FOLDERS} when nothing is said)',
        f'a size ({ALL_LOGS_LIMIT // 10**9}GB when nothing is said)',
        f'`log/{INDEX_NAME}`',
    ):
        assert name in TEXT
