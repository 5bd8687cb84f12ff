#!/usr/bin/env python3
# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
Time reading and evaluating trees of launch files.

usage: benchmarks/language.py [RUNS]

For each size a tree of launch files of some fifty lines each is made, one of
them including the others. Printed are the median times, in milliseconds, of
`yaml.safe_load` (PyYAML's pure Python one and, where it is there, that of the
C library) on the same bytes, and of the whole evaluation, each in a process
that has imported everything before.
"""

from collections.abc import Callable, Iterable
from pathlib import Path
import statistics
import sys
import tempfile
import time

from colcon_yamllaunch.language.evaluation.request import Request
from colcon_yamllaunch.language.policies.evaluate import evaluate
import yaml

#: The numbers of lines that trees are made with.
SIZES = (1_000, 5_000, 20_000, 50_000)
#: Lines of one launch file.
FILE_LINES = 50

HEAD = """\
launch:
  - arg: {name: rate, default: '10'}
  - arg: {name: side, default: left}
"""
NODE = """\
  - group:
      - push_ros_namespace: {namespace: $(var side)}
      - node:
          pkg: drivers
          exec: driver
          name: driver_NUMBER
          if: $(not $(equals $(var side) right))
          args: "--config $(dirname)/NUMBER.yaml --rate $(var rate)"
          param:
            - name: rate
              value: $(var rate)
            - {name: frame, value: "$(var side)_base"}
          remap:
            - {from: scan, to: /$(var side)/scan}
"""


class AnyPackages:
    """Packages that have everything."""

    def prefix(self, name: str) -> str | None:
        """Return a prefix for every package."""
        return f'/opt/{name}'

    def names(self) -> Iterable[str]:
        """Return no name."""
        return ()

    def executable(self, package: str, name: str) -> str | None:
        """Return a path for every program."""
        return f'/opt/{package}/lib/{package}/{name}'

    def explain_executable(self, package: str, name: str) -> str:
        """Explain nothing."""
        return f'{package} {name}'

    def locate(self, path: str) -> tuple[str, str] | None:
        """Find every file where it is."""
        return path, path

    def may_appear(self, path: str) -> bool:
        """Expect every path to appear."""
        return bool(path)

    def similar(self, path: str) -> Iterable[str]:
        """Return nothing."""
        return (path,)[:0]


def make_tree(folder: Path, lines: int) -> list[Path]:
    """Write launch files with so many lines together."""
    per_file = FILE_LINES // NODE.count('\n')
    files = []
    for number in range(max(1, lines // FILE_LINES)):
        nodes = ''.join(
            NODE.replace('NUMBER', f'{number}_{i}') for i in range(per_file)
        )
        path = folder / f'part{number}.yaml'
        path.write_text(HEAD + nodes)
        files.append(path)
    top = folder / 'top.yaml'
    includes = '\n'.join(
        f'  - include: {{file: $(dirname)/{path.name},'
        f' arg: [{{name: rate, value: "{i}"}}]}}'
        for i, path in enumerate(files)
    )
    top.write_text(f'launch:\n{includes}\n')
    return [top, *files]


def milliseconds(runs: int, work: Callable[[], object]) -> float:
    """Return the median time of several runs."""
    times = []
    for _ in range(runs):
        start = time.perf_counter()
        work()
        times.append(time.perf_counter() - start)
    return 1000 * statistics.median(times)


def load_all(texts: list[str], loader: type) -> None:
    """Read the files as plain YAML."""
    for text in texts:
        yaml.load(text, loader)


def plan(top: Path) -> None:
    """Read, check and evaluate a tree."""
    evaluation = evaluate(
        Request(
            str(top),
            str(top),
            packages=AnyPackages(),
            environment={'PATH': '/usr/bin:/bin'},
            arguments={},
            cwd=str(top.parent),
            log_folder='/tmp',
        ),
    )
    assert not evaluation.errors, evaluation.errors


def main() -> None:
    """Print the table."""
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 5
    fast = getattr(yaml, 'CSafeLoader', None)
    print('lines  files  safe_load  C safe_load  evaluate  ratio to C')
    for size in SIZES:
        with tempfile.TemporaryDirectory() as name:
            files = make_tree(Path(name), size)
            texts = [path.read_text() for path in files]
            lines = sum(text.count('\n') for text in texts)
            slow = milliseconds(
                1, lambda t=texts: load_all(t, yaml.SafeLoader)
            )
            quick = slow
            if fast is not None:
                quick = milliseconds(runs, lambda t=texts: load_all(t, fast))
            ours = milliseconds(runs, lambda f=files: plan(f[0]))
        print(
            f'{lines:5}  {len(files):5}  {slow:9.1f}  {quick:11.1f}'
            f'  {ours:8.1f}  {ours / quick:10.2f}'
        )


if __name__ == '__main__':
    main()
