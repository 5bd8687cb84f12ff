from glob import glob

from setuptools import setup

setup(
    version='0.1.0',
    packages=['talk'],
    data_files=[('share/talk/launch', glob('launch/*.yaml'))],
    entry_points={
        'console_scripts': [
            'talker = talk.talker:main',
            'listener = talk.listener:main',
        ],
    },
)
