from setuptools import setup
setup(
    name='pylib', version='0.1.0', packages=['pylib'],
    data_files=[
        ('share/ament_index/resource_index/packages', ['resource/pylib']),
        ('share/pylib', ['package.xml']),
    ],
    entry_points={'console_scripts': []},
)
