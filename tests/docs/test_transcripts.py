# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The transcripts in docs/run_and_create.md are what a terminal shows."""

from collections.abc import Callable
from pathlib import Path

from support.transcript import blocks, Reader

PAGE = Path(__file__).parents[2] / 'docs/run_and_create.md'


def test_creating(
    make_reader: Callable[[Path], Reader], tmp_path: Path
) -> None:
    _, _, creating = PAGE.read_text(encoding='utf-8').partition(
        '## `colcon create`'
    )
    reader = make_reader(tmp_path)
    made, added, warned, copied, shown = blocks(creating)
    for block in (made, added, warned, copied, shown):
        reader.do(block)
