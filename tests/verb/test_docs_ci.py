# Copyright 2026 The colcon-yamllaunch authors
# Licensed under the Apache License, Version 2.0

"""What CI runs, and what docs/ci.md tells others to run, works."""

from collections.abc import Callable
from pathlib import Path
import re
import shlex
import shutil
import sysconfig
from typing import Any

import pytest
from support.user import User
import yaml

ROOT = Path(__file__).parents[2]


@pytest.fixture
def workspace(
    user: User, copy_sample_ws: Callable[[], Path], ros_domain_id: int
) -> User:
    """Return a user with the sample workspace and the ROS wheels."""
    pytest.importorskip('rclpy', reason='needs the ROS wheels')
    copy_sample_ws()
    user.environment |= {
        'ROS_DOMAIN_ID': str(ros_domain_id),
        'ROS_AUTOMATIC_DISCOVERY_RANGE': 'LOCALHOST',
    }
    return user


def blocks(language: str) -> list[str]:
    text = (ROOT / 'docs/ci.md').read_text(encoding='utf-8')
    return re.findall(rf'^```{language}\n(.*?)^```$', text, re.M | re.S)


def run(user: User, *command: str) -> None:
    launch = user.start(*command)
    assert launch.end() == 0, launch.output


def test_the_plain_example(workspace: User) -> None:
    (script,) = blocks('bash')
    assert script.count('colcon launch') == 4
    run(workspace, 'bash', '-c', script)
    reports = workspace.root / 'reports'
    names = sorted(path.name for path in reports.iterdir())
    assert names == ['my_pkg.xml', 'my_py_pkg.xml']


def on_github(user: User) -> None:
    user.environment |= {
        'GITHUB_ACTIONS': 'true',
        'GITHUB_WORKSPACE': str(user.root),
    }


def jobs() -> list[Any]:
    """Return the steps of each example for GitHub."""
    texts = [text for text in blocks('yaml') if 'jobs:' in text]
    return [yaml.safe_load(text)['jobs']['launch']['steps'] for text in texts]


def test_six_lines_check_all_launch_files(workspace: User) -> None:
    (text,) = [t for t in blocks('yaml') if '--check=github' in t]
    assert len(text.splitlines()) == 6
    *_, install, check = yaml.safe_load(text)
    assert install['run'].startswith('pip install')
    on_github(workspace)
    run(workspace, 'bash', '-e', '-c', check['run'])
    workspace.write('flow/launch/wrong.yaml', 'launch: [{nod: {}}]\n')
    launch = workspace.start('bash', '-e', '-c', check['run'])
    assert launch.end() == 1
    assert '::error file=flow/launch/wrong.yaml,line=1' in launch.output


def test_the_example_for_github_without_the_action(workspace: User) -> None:
    scripts = [step['run'] for step in jobs()[1] if 'run' in step]
    on_github(workspace)
    assert scripts[0].startswith('pip install')
    for script in scripts[1:]:
        run(workspace, 'bash', '-e', '-c', script)
    assert (workspace.root / 'reports/my_pkg.xml').exists()


def test_the_example_for_github_with_the_action(workspace: User) -> None:
    action = yaml.safe_load((ROOT / 'action.yml').read_text(encoding='utf-8'))
    (given,) = [step['with'] for step in jobs()[0] if './' in step['uses']]
    inputs = {
        name: str(entry['default']) for name, entry in action['inputs'].items()
    }
    assert given.keys() <= inputs.keys()
    inputs |= {name: str(value) for name, value in given.items()}
    on_github(workspace)
    workspace.environment['GITHUB_ACTION_PATH'] = str(ROOT)
    steps = [step for step in action['runs']['steps'] if 'run' in step]
    assert [step['name'] for step in steps] == ['Install', 'Check', 'Launch']
    # the other test installs
    for step in steps[1:]:
        for name, value in step.get('env', {}).items():
            found = re.fullmatch(r'\$\{\{ inputs\.([\w-]+) \}\}', value)
            assert found is not None
            workspace.environment[name] = inputs[found[1]]
        run(workspace, 'bash', '-e', '-c', step['run'])
    reports = workspace.root / 'log/reports'
    assert 'errors="0"' in (reports / 'my_pkg.xml').read_text()
    assert 'which double is' in (reports / 'my_pkg.txt').read_text()


def test_the_action_fails_with_the_launch(workspace: User) -> None:
    on_github(workspace)
    workspace.environment |= {
        'PACKAGE': 'flow',
        'LAUNCH_FILE': 'flow.yaml',
        'UNTIL': 'Never\n',
        'TIMEOUT': '1',
        'REPORTS': 'reports',
    }
    launch = workspace.start('bash', str(ROOT / '.ci/action'), 'launch')
    assert launch.end() == 1
    assert (workspace.root / 'reports/flow.xml').exists()


def test_the_action_installs(user: User, tmp_path: Path) -> None:
    """Without the network, with the dependencies of this environment."""
    ignored = shutil.ignore_patterns('__pycache__')
    clone = tmp_path / 'clone'
    for name in ('colcon_yamllaunch', '.ci'):
        shutil.copytree(ROOT / name, clone / name, ignore=ignored)
    for name in ('README.md', 'LICENSE', 'setup.cfg', 'setup.py'):
        shutil.copy(ROOT / name, clone)
    paths = tmp_path / 'paths'
    user.environment |= {
        'EXTRAS': 'common',
        'GITHUB_PATH': str(paths),
        'RUNNER_TEMP': str(tmp_path),
        'PIP_NO_INDEX': '1',
        'PIP_NO_DEPS': '1',
        'PIP_NO_BUILD_ISOLATION': '0',
        'PYTHONPATH': sysconfig.get_path('purelib'),
    }
    run(user, 'bash', str(clone / '.ci/action'), 'install')
    site = tmp_path / 'colcon-launch'
    assert paths.read_text() == f'{site}/bin\n'
    assert list(site.glob('lib/python3*/site-packages/colcon_yamllaunch'))


def test_the_example_for_gitlab(workspace: User) -> None:
    (text,) = [text for text in blocks('yaml') if 'before_script:' in text]
    job = yaml.safe_load(text)['launch']
    assert job['before_script'][0].startswith('pip install')
    for script in job['script']:
        run(workspace, 'bash', '-e', '-c', script)
    assert list(workspace.root.glob(job['artifacts']['reports']['junit']))
    assert (workspace.root / job['artifacts']['paths'][0]).is_dir()


def test_the_example_for_jenkins(workspace: User) -> None:
    (text,) = blocks('groovy')
    install, launch = re.findall(r"sh '''\n(.*?)'''", text, re.S)
    assert 'pip install' in install
    run(workspace, 'sh', '-e', '-x', '-c', launch)
    assert (workspace.root / 'reports/my_pkg.xml').exists()
    assert (workspace.root / 'log/latest_launch').is_dir()


def test_the_hook_checks_each_changed_file(workspace: User) -> None:
    hooks = (ROOT / '.pre-commit-hooks.yaml').read_text(encoding='utf-8')
    (hook,) = yaml.safe_load(hooks)
    assert hook['id'] in (ROOT / 'docs/ci.md').read_text(encoding='utf-8')
    names = [
        str(path.relative_to(workspace.root))
        for path in sorted(workspace.root.rglob('*'))
        if re.search(hook['files'], str(path.relative_to(workspace.root)))
    ]
    assert {Path(name).name for name in names} >= {'demo.yaml', 'flow.yaml'}
    assert not any('config/' in name for name in names)
    entry = shlex.split(hook['entry'])
    run(workspace, *entry, *names)
    (name,) = [name for name in names if name.endswith('gauge.yaml')]
    broken = workspace.root / name
    broken.write_text('launch: [{nod: {}}]\n')
    launch = workspace.start(*entry, *names)
    assert launch.end() == 1
    assert "'nod'" in launch.output
    assert launch.output.count('no problems') == len(names) - 1


def test_the_script_of_our_own_ci(workspace: User) -> None:
    run(workspace, 'bash', str(ROOT / '.ci/launch_sample_ws'))
    reports = sorted((workspace.root / 'log/reports').iterdir())
    assert [report.stem for report in reports] == [
        'demo',
        'flow',
        'gauge',
        'square',
        'talk',
    ]
    for report in reports:
        assert 'failures="0" errors="0"' in report.read_text()
