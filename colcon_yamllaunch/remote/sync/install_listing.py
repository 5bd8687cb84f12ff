# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""
What is installed here, as it is to be on a machine of the same kind.

Links that lead out of it, as `--symlink-install` makes them, are resolved.
Python packages that are used from their build folder then, by an `.egg-link`,
are put where they would be installed. Texts that name the workspace here name
that there, as colcon's setup scripts do; programs in Python whose interpreter
is not there get that which is.
"""

from collections.abc import Collection
from collections.abc import Mapping
import os
from pathlib import Path
import re
import stat

from colcon_yamllaunch.common.errors import UserError
from colcon_yamllaunch.common.fingerprint import digest
from colcon_yamllaunch.remote.sync.source_listing import Digests
from colcon_yamllaunch.remote.sync.source_listing import FileTree
from colcon_yamllaunch.remote.sync.source_listing import Walk
from colcon_yamllaunch.remote.sync.tree_entries import Entries
from colcon_yamllaunch.remote.sync.tree_entries import file_entry
from colcon_yamllaunch.remote.sync.tree_entries import FOLDER
from colcon_yamllaunch.remote.sync.tree_entries import tree_digest

#: What Python makes anew where it is used.
_LEFT_OUT = frozenset({'__pycache__'})
#: How a Python package is installed that is used from its build folder.
_EGG_LINK = '.egg-link'
#: The lines of colcon's scripts that lead to that folder.
_DEVELOP = b'pythonpath_develop'
_SCRIPT = re.compile(r'(^|/)package\.(sh|bash|zsh|ps1|dsv)$')
#: What runs a program in Python that has no interpreter there.
_ANY_PYTHON = b'/usr/bin/env python3'
_SHEBANG = re.compile(rb'#!\s*(/\S*python[\d.]*)')


class InstallListing:
    """
    The install space here.

    :param root: The workspace
    :param install_base: Where packages are installed
    :param names: The packages that are needed
    :param merged: Whether all packages share one prefix
    """

    def __init__(
        self,
        root: Path,
        install_base: Path,
        names: Collection[str],
        digests: Digests,
        *,
        merged: bool,
    ) -> None:
        self._root = root
        self._given = (root, install_base, frozenset(names), digests)
        base = os.path.relpath(install_base, root)
        self._base = base, str(install_base)
        self._folders = {base: str(install_base)}
        self._merged = merged
        if not merged:
            for name in sorted(names):
                self._folders[f'{base}/{name}'] = str(install_base / name)
        missing = [
            name
            for name in sorted(names)
            if not (install_base if merged else install_base / name).is_dir()
        ]
        if missing:
            raise UserError(
                'not built here, which `sync: install` needs: '
                f'{", ".join(missing)}'
            )
        self._digests = digests
        self._walk = Walk(self._folders, digests, _is_left_out)
        self._found = {p: self._entries(p) for p in self._folders}
        self._texts = {
            place: self._find_texts(entries, elsewhere, self._folders[place])
            for place, (entries, elsewhere) in self._found.items()
        }

    def anew(self) -> 'InstallListing':
        """Look again."""
        return InstallListing(*self._given, merged=self._merged)

    @property
    def interpreters(self) -> list[str]:
        """The Pythons that programs name."""
        return sorted(
            {
                os.fsdecode(match[1])
                for texts in self._texts.values()
                for text in texts.values()
                if (match := _SHEBANG.match(text))
            }
        )

    @property
    def pythons(self) -> list[str]:
        """The versions of Python that modules are installed for."""
        found = {
            part.removeprefix('python')
            for entries, _ in self._found.values()
            for path in entries
            for part in path.split('/')[1:2]
            if re.fullmatch(r'python3\.\d+', part)
        }
        return sorted(found)

    def trees(
        self, root_there: str, missing: Collection[str]
    ) -> tuple[FileTree, ...]:
        """
        Return what is to be there.

        :param missing: The interpreters that are not there
        """
        trees = []
        for place, (found, elsewhere) in self._found.items():
            entries = dict(found)
            contents = {}
            for inner, text in self._texts[place].items():
                changed = self._changed(inner, text, root_there, missing)
                if changed != text:
                    contents[inner] = changed
                    executable = bool(entries[inner][1])
                    entries[inner] = file_entry(executable, digest(changed))
            self._digests.save()
            folder = self._folders[place]
            trees.append(
                FileTree(
                    place,
                    folder,
                    entries,
                    tree_digest(entries),
                    elsewhere,
                    contents,
                )
            )
        return tuple(trees)

    def _entries(self, place: str) -> tuple[Entries, dict[str, str]]:
        if place == self._base[0] and not self._merged:
            return self._top(), {}
        entries = self._walk.entries(place)
        elsewhere: dict[str, str] = {}
        for inner in [i for i in entries if i.endswith(_EGG_LINK)]:
            link = Path(self._folders[place], inner)
            del entries[inner]
            self._add_developed(inner, link, entries, elsewhere)
        return entries, elsewhere

    def _top(self) -> Entries:
        """Return the files that lie beside the prefixes of packages."""
        entries: Entries = {'': FOLDER}
        with os.scandir(self._base[1]) as found:
            for entry in found:
                status = entry.stat()
                if stat.S_ISREG(status.st_mode):
                    entries |= self._walk.file(entry.name, entry.path, status)
        return entries

    def _add_developed(
        self,
        inner: str,
        link: Path,
        entries: Entries,
        elsewhere: dict[str, str],
    ) -> None:
        """Add a Python package that is used from its build folder."""
        lines = link.read_text(errors='replace').splitlines()
        folder = Path(lines[0]) if lines else Path()
        eggs = sorted(folder.glob('*.egg-info'))
        if not lines or not eggs:
            raise UserError(
                f'{link} leads to no Python package: build it here again'
            )
        names = [egg.name for egg in eggs]
        for egg in eggs:
            top = egg / 'top_level.txt'
            if top.is_file():
                for name in top.read_text().split():
                    names += [
                        path.name
                        for path in (folder / name, *folder.glob(f'{name}.*'))
                        if path.exists() and path.suffix != '.egg-info'
                    ]
        site = os.path.dirname(inner)
        for name in dict.fromkeys(names):
            path = folder / name
            target = f'{site}/{name}'
            if path.is_file():
                entries |= self._walk.file(target, str(path), path.stat())
                elsewhere[target] = str(path)
                continue
            walk = Walk({'': str(path)}, self._digests, _is_left_out)
            for below, entry in walk.entries('').items():
                at = f'{target}/{below}'.rstrip('/')
                entries[at] = entry
                if entry[0] == 'f':
                    elsewhere[at] = str(path / below)

    def _find_texts(
        self, entries: Entries, elsewhere: Mapping[str, str], folder: str
    ) -> dict[str, bytes]:
        """Return the texts that may have to change, by their paths."""
        texts = {}
        for inner, entry in entries.items():
            path = elsewhere.get(inner) or os.path.join(folder, inner)
            if entry[0] != 'f' or not self._digests.is_text(path, self._root):
                continue
            texts[inner] = Path(path).read_bytes()
        return texts

    def _changed(
        self,
        inner: str,
        text: bytes,
        root_there: str,
        missing: Collection[str],
    ) -> bytes:
        match = _SHEBANG.match(text)
        if match and os.fsdecode(match[1]) in missing:
            text = b'#!' + _ANY_PYTHON + text[match.end() :]
        if _SCRIPT.search(inner) and _DEVELOP in text:
            lines = text.splitlines(keepends=True)
            text = b''.join(line for line in lines if _DEVELOP not in line)
        here, there = os.fsencode(self._root), os.fsencode(root_there)
        if here == there:
            return text
        # not of a folder beside it whose name begins so
        return re.sub(re.escape(here) + rb'(?![\w.-])', lambda _: there, text)


def _is_left_out(entry: os.DirEntry[str]) -> bool:
    return entry.name in _LEFT_OUT
