"""Build of the ament_python package shirube_core."""

from setuptools import find_packages, setup

NAME = 'shirube_core'

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
    description='What all packages share, without ROS: poses, cameras, typed settings, files, lamp waveforms.',
    license='Apache-2.0',
    tests_require=['pytest'],
)
