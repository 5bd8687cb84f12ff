from setuptools import setup
setup(
    name='brain', version='0.1.0', packages=['brain'],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/brain']),
        ('share/brain', ['package.xml']),
    ],
    entry_points={'console_scripts': ['mind = brain.think:main']},
)
