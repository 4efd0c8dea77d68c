from glob import glob

from setuptools import find_packages, setup

package_name = "worm_bringup"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(include=[package_name, package_name + ".*"]),
    package_data={"": ["py.typed", "*.html", "*.j2", "*.css", "*.yaml", "*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
        ("share/" + package_name + "/launch", sorted(glob("launch/*.launch.py"))),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="The worm-escape authors",
    maintainer_email="maintainers@worm-escape.example.org",
    description="The graph put together: the worm command, the recorder, launch files.",
    license="MIT",
    entry_points={
        "console_scripts": [
            "worm = worm_bringup.cli:main",
            "recorder = worm_bringup.recorder.recorder_node:main",
        ],
        "pytest11": ["worm_bringup.pytest_plugin = worm_bringup.pytest_plugin"],
    },
)
