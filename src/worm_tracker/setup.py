from setuptools import find_packages, setup

package_name = "worm_tracker"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(include=[package_name, package_name + ".*"]),
    package_data={"": ["py.typed", "*.html", "*.j2", "*.css", "*.yaml", "*.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="The worm-escape authors",
    maintainer_email="maintainers@worm-escape.example.org",
    description="A frame in, a BodyState out: picture sources, chamber calibration, tracking.",
    license="MIT",
    entry_points={
        "console_scripts": [
            "replay = worm_tracker.sources.replay_node:main",
            "camera = worm_tracker.sources.camera_node:main",
            "tracker = worm_tracker.tracker_node:main",
        ]
    },
)
