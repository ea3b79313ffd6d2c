"""Maps the folders at the top to packages inside `quickreturn`; everything else about the package stands in `pyproject.toml`."""

from setuptools import find_packages, setup

#: Folders at the top of the checkout that install as `quickreturn.NAME`.
INNER = ("reference_model", "engines", "cases", "reports")

setup(
    packages=[
        *find_packages(include=["quickreturn", "quickreturn.*"]),
        *(f"quickreturn.{name}" for name in find_packages(include=[*INNER, *(f"{name}.*" for name in INNER)])),
    ],
    package_dir={f"quickreturn.{name}": name for name in INNER},
)
