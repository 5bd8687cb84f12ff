# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
A page about the options of the verbs, made from what their parsers know.

Each option has an anchor that names the verb and the option, such as
`launch-watch`, which stays when options are added or move.

usage: python tools/options_page.py > docs/options.md
"""

import argparse
from collections.abc import Iterator
from functools import partial
from importlib.metadata import entry_points
import sys
from typing import Any

_PACKAGE = 'colcon_yamllaunch.'
# knows no terminal, so that the page is the same everywhere
_FORMATTER = partial(argparse.HelpFormatter, width=79)


def reference_page() -> str:
    """Return the page, in Markdown."""
    return '\n'.join(_page()) + '\n'


def _page() -> Iterator[str]:
    yield '# Options'
    yield ''
    yield 'Made by `python tools/options_page.py` from what the parsers know.'
    yield 'Each option has a link to itself.'
    found = entry_points(group='colcon_core.verb')
    ours = [entry for entry in found if entry.value.startswith(_PACKAGE)]
    for entry in sorted(set(ours), key=lambda entry: entry.name):
        yield ''
        yield from _verb(entry.name, entry.load()())


def _verb(name: str, verb: Any) -> Iterator[str]:
    parser = argparse.ArgumentParser(
        prog=f'colcon {name}', formatter_class=_FORMATTER
    )
    verb.add_arguments(parser=parser)
    yield f'## colcon {name}'
    yield ''
    yield (type(verb).__doc__ or '').strip()
    yield ''
    for line in parser.format_usage().removeprefix('usage:').splitlines():
        yield f'    {line.strip()}'
    for group in parser._action_groups:
        yield from _group(group, name, parser.prog)
    if parser.epilog:
        yield from ('', '### Examples', '')
        for line in parser.epilog.splitlines():
            if line != 'examples:':
                yield f'    {line.strip()}'


def _group(group: Any, verb: str, prog: str) -> Iterator[str]:
    rows = [
        (_anchored(_usage(action), action, verb), _help(action, prog))
        for action in group._group_actions
        if action.help != argparse.SUPPRESS
    ]
    if not rows:
        return
    title = group.title or 'Options'
    yield from ('', f'### {title[:1].upper()}{title[1:]}', '')
    if group.description:
        yield from (group.description, '')
    for row in [('option', 'meaning'), ('---', '---'), *rows]:
        cells = ' | '.join(cell.replace('|', '\\|') for cell in row)
        yield f'| {cells} |'


def _anchored(usage: str, action: argparse.Action, verb: str) -> str:
    """Return `usage` as a link to an anchor before it."""
    name = (action.option_strings or [action.dest])[-1].lstrip('-')
    anchor = f'{verb}-{name.replace("_", "-")}'
    return f'<a id="{anchor}"></a>[{usage}](#{anchor})'


def _usage(action: argparse.Action) -> str:
    """Return how an option is written."""
    if not action.option_strings:
        return f'`{action.metavar or action.dest}`'
    # up to Python 3.12, --help has the value behind each form of the option
    value = _FORMATTER('')._format_args(action, action.dest.upper())
    return f'`{" ".join([", ".join(action.option_strings), value]).strip()}`'


def _help(action: argparse.Action, prog: str) -> str:
    text = (action.help or '') % {**vars(action), 'prog': prog}
    return text[:1].upper() + text[1:] + '.' * (text[-1:] != '.')


if __name__ == '__main__':
    sys.stdout.write(reference_page())
