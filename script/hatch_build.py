"""Called by pip or another builder of wheels (see pyproject.toml): compiles libunit5.so into the wheel."""
import os
import sysconfig
import tempfile
from runpy import run_path

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class Hook(BuildHookInterface):
    """Makes a wheel for one platform. Any version of Python can call the library."""

    def initialize(self, version, build_data):
        """Compile the library into a temporary folder, so that the source folder stays as it is."""
        if version == 'editable':  # that is no wheel of its own: the package stays in the source folder
            return
        self._folder = tempfile.TemporaryDirectory()
        folder = os.path.join('aruco_ar', 'compiled')
        compiler = run_path(os.path.join(self.root, 'src', folder, 'compiler.py'))
        library = os.path.join(self._folder.name, compiler['NAME'])
        compiler['compile_to'](library)
        build_data['force_include'][library] = os.path.join(folder, compiler['NAME'])
        platform = sysconfig.get_platform().replace('-', '_').replace('.', '_')
        build_data.update(pure_python=False, tag='py3-none-' + platform)
