"""Build of the ament_python package stereo_landmark."""

from setuptools import find_packages, setup

NAME = 'stereo_landmark'
COMMANDS = ('locate', 'teach')

setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={NAME: ['py.typed', 'files/*.json', 'page/static/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    maintainer='The shirube engineers',
    maintainer_email='shirube@users.noreply.github.com',
    description='Stereo localization relative to taught places by natural landmarks, without markers.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={
        'console_scripts': [
            f'node = shirube_ros.start:{NAME}',
            *(f'{command} = {NAME}.commands.{command}:main' for command in COMMANDS),
        ]
    },
)
