# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

from colcon_yamllaunch.workspace.freshness.build_products import Products
import pytest


@pytest.mark.hostile
def test_a_file_name_may_have_any_character_but_a_line_break(tmp_path):
    build, install = tmp_path / 'build', tmp_path / 'install'
    share = install / 'share'
    for folder in (build / 'one', share):
        folder.mkdir(parents=True)
    # of another package, and called like the beginning of ours
    foreign = share / 'notes'
    own = share / 'notes\u2028old\x0bfile'
    for path in (foreign, own):
        path.touch()
    manifest = build / 'one' / 'install_manifest.txt'
    manifest.write_text(f'{own}\n', encoding='utf-8')
    assert Products(build, install, True).listed('one') == {own}
