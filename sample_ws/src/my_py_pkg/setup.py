from glob import glob

from setuptools import find_packages
from setuptools import setup

package_name = 'my_py_pkg'

setup(
    name=package_name,
    version='0.1.0',
    packages=find_packages(),
    data_files=[
        # This empty file is how ROS 2 finds the package.
        (
            'share/ament_index/resource_index/packages',
            [f'resource/{package_name}'],
        ),
        (f'share/{package_name}', ['package.xml']),
        # As install(DIRECTORY launch …) in a CMake package.
        (f'share/{package_name}/launch', glob('launch/*.yaml')),
    ],
    install_requires=['setuptools'],
    zip_safe=True,
    maintainer='The maintainers',
    maintainer_email='maintainers@example.com',
    description='A pure Python package with a node as entry point.',
    license='Apache-2.0',
    entry_points={
        # As install(PROGRAMS …) in a CMake package: the program `square` calls
        # main() of my_py_pkg/square.py.
        'console_scripts': ['square = my_py_pkg.square:main'],
    },
)
