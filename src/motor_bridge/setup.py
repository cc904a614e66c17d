"""Build of the ament_python package motor_bridge."""

from setuptools import find_packages, setup

NAME = 'motor_bridge'
COMMANDS = ('calibrate', 'firmware_emulator')

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
    description='Drives a differential drive robot over a serial motor controller and publishes wheel odometry.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={
        'console_scripts': [
            f'node = shirube_ros.start:{NAME}',
            *(f'{command} = {NAME}.commands.{command}:main' for command in COMMANDS),
        ]
    },
)
