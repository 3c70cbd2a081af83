"""Called by pip or another builder of wheels (see pyproject.toml): compiles the library into the wheel.

script/wheels says for which other systems: UNIT5_WHEEL has the wheel's platform tag, the system as sys.platform
calls it, and the target as Zig calls it. Zig is a C compiler for all of them.
"""
import os
import sys
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
        wanted = os.environ.get('UNIT5_WHEEL')
        if wanted:
            tag, system, target = wanted.split()
            name = compiler['NAMES'][system]
            how = {'compiler': [sys.executable, '-m', 'ziglang', 'cc', '-target', target, '-s']}
        else:
            tag, name, how = sysconfig.get_platform().replace('-', '_').replace('.', '_'), compiler['NAME'], {}
        library = os.path.join(self._folder.name, name)
        # On macOS, a library names itself: without this, by the path of the temporary folder.
        own_name = ['-Wl,-install_name,@rpath/' + name] if name.endswith('.dylib') else []
        compiler['compile_to'](library, *own_name, **how)
        build_data['force_include'][library] = os.path.join(folder, name)
        build_data.update(pure_python=False, tag='py3-none-' + tag)
