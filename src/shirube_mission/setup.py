"""Build of the ament_python package shirube_mission."""

from setuptools import find_packages, setup

NAME = 'shirube_mission'

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
    description='End-to-end simulation: all six nodes drive a simulated robot through a room with unknown obstacles.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={'console_scripts': [f'room = {NAME}.commands.room:main']},
)
