# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""Which launch file, which workspace, which arguments, which packages."""

from pathlib import Path

import pytest
from support.user import built, User

ECHO = """\
launch:
  - arg: {name: who, default: nobody}
  - executable: {cmd: echo hello $(var who)}
"""


@pytest.mark.parametrize(
    'name', ['a.launch.yaml', 'a.launch', 'a', 'launch/a.launch.yaml']
)
def test_file_is_named_as_users_do(user: User, name: str) -> None:
    user.package('one', ECHO)
    user.write('src/one/launch/a.launch.yaml', ECHO)
    assert 'hello nobody' in user.launch('one', name)


def test_several_launch_files_fit(user: User) -> None:
    user.package('one', ECHO)
    user.write('src/one/launch/left/a.yaml', ECHO)
    user.write('src/one/launch/right/a.yaml', ECHO)
    output = user.launch('one', 'a', code=1)
    assert 'launch/left/a.yaml' in output
    assert 'launch/right/a.yaml' in output
    assert not (user.root / 'build').exists()


def test_no_launch_file_fits_and_the_nearest_comes_first(user: User) -> None:
    user.package('one', ECHO)
    user.write('src/one/launch/zebra.yaml', ECHO)
    output = user.launch('one', 'zebar', code=1)
    listed = [
        line.strip() for line in output.splitlines() if 'launch/' in line
    ]
    assert listed == ['launch/zebra.yaml', 'launch/one.yaml']


def test_launch_file_is_missing_on_the_command_line(user: User) -> None:
    user.package('one', ECHO)
    assert 'launch/one.yaml' in user.launch('one', code=1)


def test_unknown_package_names_the_nearest(user: User) -> None:
    user.package('my_package')
    output = user.launch('my_pakcage', 'x', code=1)
    assert "did you mean 'my_package'?" in output


def test_path_of_a_launch_file(user: User) -> None:
    user.package('one', ECHO)
    output = user.launch('src/one/launch/one.yaml', 'who:=you')
    assert 'hello you' in output
    assert built(output) == []


def test_below_the_root_nothing_is_littered(user: User) -> None:
    user.package('one')
    folder = user.root / 'src/one/launch'
    output = user.launch('one', 'one', cwd=folder)
    assert 'hello from one' in output
    assert sorted(p.name for p in folder.iterdir()) == ['one.yaml']
    names = {'build', 'install', 'log', 'src'}
    assert {p.name for p in user.root.iterdir()} == names


def test_workspace_option_from_elsewhere(user: User, tmp_path: Path) -> None:
    user.package('one')
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    options = ['--workspace', str(user.root)]
    output = user.launch(*options, 'one', 'one', cwd=elsewhere)
    assert 'hello from one' in output
    assert list(elsewhere.iterdir()) == []
    assert (user.root / 'log/latest_launch/launch.log').is_file()


def test_path_of_a_launch_file_from_outside_the_workspace(
    user: User, tmp_path: Path
) -> None:
    user.package('one')
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    path = user.root / 'src/one/launch/one.yaml'
    output = user.launch(str(path), cwd=elsewhere)
    assert 'hello from one' in output
    assert list(elsewhere.iterdir()) == []


def test_path_of_an_xml_file_from_outside_the_workspace(
    user: User, tmp_path: Path
) -> None:
    user.package('one')
    path = user.write(
        'src/one/launch/one.launch.xml',
        '<launch><executable '
        'cmd="$(find-pkg-prefix one)/lib/one/hello.sh"/></launch>',
    )
    elsewhere = tmp_path / 'elsewhere'
    elsewhere.mkdir()
    assert 'hello from one' in user.launch(str(path), cwd=elsewhere)


def test_without_a_workspace(user: User, tmp_path: Path) -> None:
    folder = tmp_path / 'plain'
    folder.mkdir()
    (folder / 'a.yaml').write_text(ECHO)
    assert 'hello you' in user.launch('a.yaml', 'who:=you', cwd=folder)
    assert [p.name for p in folder.iterdir()] == ['a.yaml']


def test_launch_arguments_stand_anywhere(user: User) -> None:
    user.package('one', ECHO)
    paths = ['--paths', 'src/one', 'who:=you:=all']
    assert 'hello you:=all' in user.launch('one', 'one', *paths)
    assert 'hello me' in user.launch('who:=me', 'one', 'one', '--no-build')


def test_unknown_launch_argument_is_a_warning(user: User) -> None:
    user.package('one', ECHO)
    output = user.launch('one', 'one', 'whom:=you')
    assert "did you mean 'who'?" in output


def test_paths_that_took_everything(user: User) -> None:
    user.package('one', ECHO)
    output = user.launch('--paths', 'src/one', 'one', 'one', code=1)
    assert 'put it behind PKG and FILE' in output
    output = user.launch('--paths', 'src/one', '--', 'one', 'one')
    assert 'hello nobody' in output


def test_only_needed_packages_are_built(user: User) -> None:
    for name in ('needed', 'other'):
        user.package(name)
    include = '$(find-pkg-share needed)/launch/needed.yaml'
    user.package('top', f'launch: [include: {{file: {include}}}]\n')
    output = user.launch('top', 'top')
    assert built(output) == ['needed', 'top']
    assert 'hello from needed' in output
    assert built(user.launch('top', 'top')) == []
    assert built(user.launch('top', 'top', '--build-all')) == ['other']


def test_branches_that_are_not_taken_build_nothing(user: User) -> None:
    user.package('rarely')
    run = 'executable: {cmd: $(find-pkg-prefix rarely)/lib/rarely/hello.sh'
    user.package(
        'top',
        'launch:\n'
        '- arg: {name: rare, default: "false"}\n'
        f'- {run}, if: $(var rare)}}\n',
    )
    assert built(user.launch('top', 'top')) == ['top']
    assert built(user.launch('top', 'top', 'rare:=true')) == ['rarely']


def test_paths_build_just_these(user: User) -> None:
    user.package('one')
    user.package('two')
    launch = ['one', 'one']
    assert built(user.launch(*launch, '--paths', 'src/*')) == ['one', 'two']
    user.write('src/one/new.cpp', '')
    user.write('src/two/new.cpp', '')
    folder = user.root / 'src'
    paths = ['--paths', 'two']
    assert built(user.launch(*launch, *paths, cwd=folder)) == ['two']


def test_paths_leave_out_a_needed_package(user: User) -> None:
    user.package('one')
    user.package('two')
    output = user.launch('one', 'one', '--paths', 'src/two', code=1)
    assert 'the package one is not built' in output
    assert 'hello' not in output


def test_no_build_in_a_workspace_that_was_never_built(user: User) -> None:
    user.package('one')
    output = user.launch('one', 'one', '--no-build', code=1)
    assert 'leave out --no-build' in output
    assert not (user.root / 'build').exists()


def test_build_arguments(user: User) -> None:
    user.package('one')
    user.launch('one', 'one', '--build-args', '--merge-install')
    assert (user.root / 'install/lib/one/hello.sh').is_symlink()


def test_refused_build_arguments_forget_no_build(user: User) -> None:
    user.package('one')
    user.launch('one', 'one')
    merged = ('--build-args', '--merge-install')
    output = user.launch('one', 'one', *merged, code=1)
    assert "was created with the layout 'isolated'" in output
    assert user.launch('one', 'one').startswith('1 package up to date\n')


def test_build_defaults_hold(user: User) -> None:
    pytest.importorskip('colcon_defaults')
    user.package('one')
    defaults = Path(user.environment['HOME']) / '.colcon/defaults.yaml'
    defaults.parent.mkdir()
    defaults.write_text('build: {merge-install: true}\n')
    user.launch('one', 'one')
    assert (user.root / 'install/lib/one/hello.sh').is_symlink()
