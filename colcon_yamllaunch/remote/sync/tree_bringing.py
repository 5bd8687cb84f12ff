# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Trees of files brought to a machine, as far as they are not there."""

from collections.abc import Callable
from collections.abc import Collection
from collections.abc import Iterator
from collections.abc import Mapping
from collections.abc import Sequence
import os
from pathlib import Path
import tempfile
from typing import Any

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.remote.sync.file_transfer import is_installed
from colcon_yamllaunch.remote.sync.file_transfer import transfer
from colcon_yamllaunch.remote.sync.remote_connection import Connection
from colcon_yamllaunch.remote.sync.remote_connection import Say
from colcon_yamllaunch.remote.sync.source_listing import FileTree
from colcon_yamllaunch.remote.sync.tree_entries import packed
from colcon_yamllaunch.remote.sync.tree_entries import shown
from colcon_yamllaunch.remote.sync.tree_entries import unpacked

#: From which size on it is told, as it takes a while (bytes).
_LARGE = 10_000_000
#: How often what is changed while it is brought is brought again.
_ROUNDS = 3
#: How many of the files that are in the way are told.
_SHOWN = 5


def bring(
    connection: Connection,
    root: str,
    origin: str,
    trees: Sequence[FileTree],
    places: Collection[str] | None,
    changed: Collection[str],
    look_again: Callable[[], Sequence[FileTree]],
    say: Say,
) -> int:
    """
    Bring trees, and return how many files were brought or deleted.

    :param root: The workspace there
    :param origin: What tells the workspace here from others
    :param trees: What is to be there
    :param places: The folders of all packages here; what was brought to others
      is deleted. None to delete nothing of others
    :param changed: The places of the trees that are not there
    :param look_again: Returns the trees as they are, when they were changed
      meanwhile
    :raises UserError: when it cannot be done; then nothing is built
    :raises ValueError: when the machine answers what makes no sense, and
      KeyError or TypeError likewise
    """
    count = 0
    for _ in range(_ROUNDS):
        wanted = [tree for tree in trees if tree.place in changed]
        done, differ = _bring(connection, root, origin, wanted, places, say)
        count += done
        if not differ:
            return count
        trees = look_again()
        changed = {tree.place for tree in trees}
    raise UserError(
        f'{shown(differ[0])} was changed each time that it was brought: '
        'launch again when that has ended'
    )


def _bring(
    connection: Connection,
    root: str,
    origin: str,
    trees: Sequence[FileTree],
    places: Collection[str] | None,
    say: Say,
) -> tuple[int, list[str]]:
    entries = {tree.place: tree.entries for tree in trees}
    answer = connection.ask(
        'sources_there.prepare',
        {
            'root': root,
            'origin': origin,
            'trees': packed(entries),
            'places': None if places is None else list(places),
        },
        say,
    )
    conflicts = unpacked(answer['conflicts'])
    if conflicts:
        raise UserError(_in_the_way(conflicts, root))
    wanted: Mapping[str, list[str]] = unpacked(answer['wanted'])
    by_place = {tree.place: tree for tree in trees}
    for place, paths in wanted.items():
        # what a machine asks for is all that it gets
        if any(by_place[place].entries[path][0] != 'f' for path in paths):
            raise ValueError('it wants what is no file')
    count = sum(map(len, wanted.values()))
    if not count:
        return int(answer['deleted']), []
    sizes = (
        _size(by_place[place], path)
        for place, paths in wanted.items()
        for path in paths
    )
    _tell(count, sum(sizes), answer, say)
    for place, paths in wanted.items():
        tree = by_place[place]
        here = [path for path in paths if not _is_staged(tree, path)]
        staged = [path for path in paths if _is_staged(tree, path)]
        for folder, names in _folders(tree, here, staged):
            transfer(
                connection,
                folder,
                names,
                f'{root}/{place}' if place else root,
                by_rsync=bool(answer['rsync']),
                python_there=str(answer['python']),
            )
    finished = connection.ask(
        'sources_there.finish',
        {
            'root': root,
            'trees': packed({place: entries[place] for place in wanted}),
        },
        say,
    )
    return count + int(answer['deleted']), unpacked(finished['differ'])


def _is_staged(tree: FileTree, path: str) -> bool:
    return path in tree.contents or path in tree.elsewhere


def _folders(
    tree: FileTree, here: list[str], staged: list[str]
) -> Iterator[tuple[str, list[str]]]:
    """Iterate over the folders to bring files from, and these files."""
    if here:
        yield tree.folder, here
    if not staged:
        return
    with tempfile.TemporaryDirectory(prefix='colcon-launch-') as folder:
        for path in staged:
            file = Path(folder, path)
            file.parent.mkdir(parents=True, exist_ok=True)
            if path in tree.contents:
                file.write_bytes(tree.contents[path])
            else:
                # it is followed
                file.symlink_to(tree.elsewhere[path])
        yield folder, staged


def _size(tree: FileTree, path: str) -> int:
    if path in tree.contents:
        return len(tree.contents[path])
    try:
        here = tree.elsewhere.get(path) or os.path.join(tree.folder, path)
        return os.stat(here).st_size
    except OSError:
        return 0


def _tell(count: int, size: int, answer: Mapping[str, Any], say: Say) -> None:
    files = 'one file' if count == 1 else f'{count} files'
    if size >= _LARGE:
        files += f' ({size / 1e6:,.0f} MB)'
    where = [
        name
        for name, has in (('here', is_installed()), ('there', answer['rsync']))
        if not has
    ]
    how = ''
    if where:
        how = (
            f' without rsync, which is not installed {" and ".join(where)}: '
            "'sudo apt install rsync' makes it faster"
        )
    say(f'bringing {files}{how}')


def _in_the_way(conflicts: Sequence[str], root: str) -> str:
    paths = ''.join(f'\n  {shown(path)}' for path in conflicts[:_SHOWN])
    more = len(conflicts) - _SHOWN
    if more > 0:
        paths += f'\n  and {more} more'
    return (
        f'in {root} there is something else that no launch has brought, or '
        f'that was changed there since:{paths}\n'
        'Nothing was changed. Save there what is to be kept and delete these '
        'files, or leave the code there to somebody else by `sync: none`'
    )
