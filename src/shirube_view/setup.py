"""Build of the ament_python package shirube_view."""

from setuptools import find_packages, setup

NAME = 'shirube_view'

setup(
    name=NAME,
    version='0.1.0',
    packages=find_packages(exclude=['test']),
    package_data={NAME: ['py.typed', 'static/*']},
    data_files=[
        ('share/ament_index/resource_index/packages', [f'resource/{NAME}']),
        (f'share/{NAME}', ['package.xml']),
    ],
    install_requires=['setuptools'],
    extras_require={'test': ['pytest']},
    zip_safe=False,
    maintainer='The shirube engineers',
    maintainer_email='shirube@users.noreply.github.com',
    description='Live page in the browser: map, robot, cameras and diagnostics; goals, driving by hand, replay.',
    license='Apache-2.0',
    tests_require=['pytest'],
    entry_points={'console_scripts': ['view = shirube_view.commands.view:main']},
)
