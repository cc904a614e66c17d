"""Build of the ament_python package scene_simulator."""

from setuptools import find_packages, setup

NAME = 'scene_simulator'
COMMANDS = {
    'generate_floor': 'floor',
    'record_floor_bag': 'floor',
    'record_lamp_bag': 'lamps',
    'record_room_bag': 'room',
    'record_stereo_bag': 'corridor',
    'render_floor_view': 'floor',
    'render_stereo_pair': 'corridor',
}

setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={NAME: ['py.typed']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    maintainer='The shirube engineers',
    maintainer_email='shirube@users.noreply.github.com',
    description='Rendered worlds with known truth: random-dot floors, a belly camera and a robot drive.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={
        'console_scripts': [f'{name} = {NAME}.commands.{module}:{name}' for name, module in COMMANDS.items()]
    },
)
