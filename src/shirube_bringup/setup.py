"""Build of the ament_python package shirube_bringup."""

from pathlib import Path

from setuptools import find_packages, setup

NAME = 'shirube_bringup'

setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={NAME: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
        (f'share/{NAME}/launch', sorted(map(str, Path('launch').glob('*.launch.py')))),
        (f'share/{NAME}/urdf', ['urdf/demo_robot.urdf.xacro']),
        (f'share/{NAME}/rviz', ['rviz/shirube.rviz']),
        (f'share/{NAME}/foxglove', ['foxglove/shirube.json']),
        # `config` is a link to the folder at the repository's root, where robot owners look for it.
        (f'share/{NAME}/config', sorted(map(str, Path('config').glob('*.yaml')))),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    maintainer='The shirube engineers',
    maintainer_email='shirube@users.noreply.github.com',
    description='Launch files and example parameter files of all nodes, and a simulated mission of all of them.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={'console_scripts': [f'room = {NAME}.commands.room:main']},
)
