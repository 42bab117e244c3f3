"""Recipe for Spack. Not built where it was written: it has never been run.

Copy it to packages/contensou in a repository of Spack, then: spack install contensou
"""

from spack.package import MesonPackage, depends_on, license, variant, version  # type: ignore


class Contensou(MesonPackage):
    """Rigid bodies that touch: Hertz contacts with Contensou-Erismann friction."""

    # There is no release archive as yet: sources are those of a checkout, by `spack develop`.
    version("0.1.0")

    license("MIT")

    variant("tests", default=False, description="Build the unit tests")

    depends_on("c", type="build")
    depends_on("fortran", type="build")
    depends_on("meson@1.0:", type="build")
    depends_on("pkgconfig", type="build")
    depends_on("gsl")
    depends_on("hdf5+hl~mpi")
    depends_on("sundials@6.4:6+cvode+f2003+klu~mpi")
    depends_on("zlib-api")
    depends_on("python@3.10:", type="run")
    depends_on("py-h5py", type="run")
    depends_on("py-matplotlib", type="run")

    def meson_args(self):
        """Options of the build."""
        return [
            f"-Dsundials_prefix={self.spec['sundials'].prefix}",
            "-Dstatic_hdf5=disabled",
            "-Ddefault_library=both",
            f"-Dtests={'true' if self.spec.satisfies('+tests') else 'false'}",
        ]
