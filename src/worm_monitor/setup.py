from setuptools import find_packages, setup

package_name = "worm_monitor"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(include=[package_name, package_name + ".*"]),
    package_data={"": ["py.typed", "*.html", "*.css", "*.js", "*.svg"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="The worm-escape authors",
    maintainer_email="maintainers@worm-escape.example.org",
    description="The page on which a lab watches a trial: picture, plots, numbers, controls.",
    license="MIT",
    entry_points={"console_scripts": ["monitor = worm_monitor.monitor_node:main"]},
)
