# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""The pictures of the documentation, which programs make."""

from pathlib import Path
import re
from xml.etree import ElementTree

import pytest

ROOT = Path(__file__).resolve().parents[2]
PICTURES = sorted(ROOT.glob('docs/*.svg'))
#: Bytes of a picture at most.
SIZE = 48 * 1024


@pytest.mark.parametrize('picture', PICTURES, ids=lambda path: path.name)
def test_a_picture(picture: Path) -> None:
    svg = ElementTree.parse(picture).getroot()
    assert svg.get('aria-label')
    assert picture.stat().st_size < SIZE
    # it tells nothing of the machine that it was made on
    text = ''.join(svg.itertext())
    assert not re.search(r'/(home|root|tmp|usr|var)\b', text)
    # as it is shown where nothing from elsewhere is loaded
    assert 'http' not in text


def test_each_picture_is_shown() -> None:
    assert PICTURES
    pages = [ROOT / 'README.md', *ROOT.glob('docs/*.md')]
    shown = {
        (page.parent / target).resolve()
        for page in pages
        for target in re.findall(
            r'!\[[^\]]+\]\(([^)]+\.svg)\)', page.read_text(encoding='utf-8')
        )
    }
    assert shown == {*PICTURES}
