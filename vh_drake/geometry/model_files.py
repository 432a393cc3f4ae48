"""Where the package's robots, hands and tables lie."""

from pathlib import Path

from pydrake.multibody.parsing import PackageMap, Parser

from vh_drake.errors import BadInput

PACKAGE_NAME = "vh_drake_models"


def models_folder() -> Path:
    """The folder with package.xml, in a checkout and in an installed package alike."""
    folder = Path(__file__).parent.parent / "models"
    if not (folder / "package.xml").is_file():
        raise BadInput(f"no package.xml in {folder}; install vh_drake again")
    return folder.resolve()


def models_package_map() -> PackageMap:
    """A package map that resolves `package://vh_drake_models/...`."""
    packages = PackageMap()
    packages.Add(PACKAGE_NAME, str(models_folder()))
    return packages


def add_models(parser: Parser) -> None:
    """Let `parser` resolve `package://vh_drake_models/...`; a second call changes nothing."""
    packages = parser.package_map()
    if not packages.Contains(PACKAGE_NAME):
        packages.Add(PACKAGE_NAME, str(models_folder()))
