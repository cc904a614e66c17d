"""Build of the ament_python package floor_localizer."""

from setuptools import find_packages, setup

NAME = 'floor_localizer'

setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={NAME: ['py.typed', 'maps/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    maintainer='The shirube engineers',
    maintainer_email='shirube@users.noreply.github.com',
    description='Pose of a robot from the random dots of the floor under it.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={
        'console_scripts': [
            f'node = shirube_ros.start:{NAME}',
            f'locate = {NAME}.commands.locate:main',
            f'inspect_map = {NAME}.commands.inspect_map:main',
            f'index_map = {NAME}.commands.index_map:main',
            f'print_mat = {NAME}.commands.print_mat:main',
            f'calibrate_camera = {NAME}.commands.calibrate_camera:main',
            f'compare_maps = {NAME}.commands.compare_maps:main',
            f'build_map = {NAME}.commands.build_map:main',
        ]
    },
)
