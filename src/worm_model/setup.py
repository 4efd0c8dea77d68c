from setuptools import find_packages, setup

package_name = "worm_model"

setup(
    name=package_name,
    version="0.1.0",
    packages=find_packages(include=[package_name, package_name + ".*"]),
    package_data={
        "": ["py.typed", "*.html", "*.j2", "*.css", "*.yaml", "*.xml", "*.npz", "LICENSE-*"]
    },
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/" + package_name]),
        ("share/" + package_name, ["package.xml"]),
    ],
    install_requires=["setuptools"],
    zip_safe=False,
    maintainer="The worm-escape authors",
    maintainer_email="maintainers@worm-escape.example.org",
    description="Models of the worm: the boundary walk, and the synthetic rig that films a worm.",
    license="MIT",
    entry_points={"console_scripts": ["model = worm_model.model_node:main"]},
)
