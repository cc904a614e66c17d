"""Build of the ament_python package shirube_camera."""

from setuptools import find_packages, setup

NAME = 'shirube_camera'

setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={NAME: ['py.typed', '*.html']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    maintainer='The shirube engineers',
    maintainer_email='shirube@users.noreply.github.com',
    description='Publishes images of USB cameras, videos and folders, and calibrates lenses and stereo pairs.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={
        'console_scripts': [
            f'camera = shirube_ros.start:{NAME}',
            f'calibrate = {NAME}.commands.calibrate:main',
        ]
    },
)
