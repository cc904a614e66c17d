"""Build of the ament_python package shirube_bags."""

from setuptools import find_packages, setup

NAME = 'shirube_bags'

setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={NAME: ['py.typed', '*.xml']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    maintainer='The shirube engineers',
    maintainer_email='shirube@users.noreply.github.com',
    description='rosbag2 tools: lossless replay, recording, and comparison of poses with ground truth.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={
        'console_scripts': [
            'play = shirube_bags.commands.play:main',
            'record = shirube_bags.commands.record:main',
            'check = shirube_bags.commands.check:main',
        ]
    },
)
