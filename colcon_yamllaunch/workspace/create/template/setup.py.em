from glob import glob

from setuptools import find_packages
from setuptools import setup

package_name = '@(name)'

setup(
    name=package_name,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    data_files=[
        # By this file ROS 2 finds the package.
        (
            'share/ament_index/resource_index/packages',
            [f'resource/{package_name}'],
        ),
        (f'share/{package_name}', ['package.xml']),
        (f'share/{package_name}/config', glob('config/*')),
        (f'share/{package_name}/launch', glob('launch/*')),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=True,
    maintainer=@(repr(maintainer_name)),
    maintainer_email=@(repr(maintainer_email)),
    description=@(repr(description)),
    license=@(repr(license)),
    entry_points={
        # What can be run and launched: `name = module:function`.
        'console_scripts': [
            '@(node) = @(module).@(node):main',
        ],
    },
)
