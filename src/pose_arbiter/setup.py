"""Build of the ament_python package pose_arbiter."""

from setuptools import find_packages, setup

NAME = 'pose_arbiter'

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
    description='Fuses the poses of several localizers and wheel odometry into one pose (EKF with outlier rejection).',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={'console_scripts': [f'node = shirube_ros.start:{NAME}']},
)
