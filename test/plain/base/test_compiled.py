"""The library in C: how it is found and compiled, and that one of another version is never used."""
import os
import re
import shutil
import subprocess
import sys

import pytest
from aruco_ar.compiled.compiler import HERE, compile_to, flags

FIT = '''
import cv2, numpy
from aruco_ar import Detector, draw_tag
tag, = Detector().detect(cv2.copyMakeBorder(draw_tag('DICT_6X6_250', 7), 50, 50, 50, 50, 0, value=255))
assert tag.id == 7 and abs(tag.corners - 399.5).max() < 350.6
'''
MAPPED = FIT + '''
paths = {line.split()[-1] for line in open('/proc/self/maps') if 'libunit5' in line}
print(*paths)
'''
# An older library: it has our functions, but would end the process.
OTHER = '''
#include <stdlib.h>
const char *unit5_version(void) { return "0123456789abcdef"; }
const double unit5_nearest, unit5_seam;
const int unit5_plane_count, unit5_profile_count, unit5_block_width, unit5_block_height, unit5_levels,
    unit5_widest_window;
const float unit5_profile_positions[1];
void unit5_fit_tags(void) { abort(); }
void unit5_draw_mask(void) { abort(); }
void unit5_find_levels(void) { abort(); }
void unit5_warp_picture(void) { abort(); }
void unit5_mix_picture(void) { abort(); }
void unit5_light_picture(void) { abort(); }
void unit5_refine_pose_pairs(void) { abort(); }
void unit5_light_wall(void) { abort(); }
void unit5_compare_wall(void) { abort(); }
void unit5_learn_wall(void) { abort(); }
'''
WITHOUT_VERSION = 'void unit5_fit_tags(void) {}'

pytestmark = pytest.mark.long
needs_compiler = pytest.mark.skipif(shutil.which('cc') is None, reason='no C compiler')


@pytest.fixture
def copied(package, tmp_path):
    """A function that runs a script with a copy of aruco_ar, and returns (exit code, output).

    Its own folder is the cache. ``environment``: more variables.
    """
    shutil.copytree(package + '/src/aruco_ar', str(tmp_path / 'aruco_ar'),
                    ignore=shutil.ignore_patterns('__pycache__'))

    def run(script=FIT, before=(), **environment):
        clean = {key: value for key, value in os.environ.items() if not key.startswith('LD_')}
        clean.update({'PYTHONPATH': str(tmp_path), 'XDG_CACHE_HOME': str(tmp_path / 'cache'), **environment})
        done = subprocess.run([*before, sys.executable, '-c', script], env=clean, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True)
        return done.returncode, done.stdout
    return run


def compiled(source, folder):
    """The path of a libunit5.so made of this source, in a new folder."""
    folder.mkdir()
    (folder / 'source.c').write_text(source)
    path = str(folder / 'libunit5.so')
    subprocess.run(['cc', '-shared', '-fPIC', '-o', path, str(folder / 'source.c')], check=True)
    return path


@needs_compiler
def test_it_is_compiled_only_once(copied, tmp_path):
    before = sorted(path for path in (tmp_path / 'aruco_ar').rglob('*') if path.suffix != '.pyc')
    assert copied(PYTHONDONTWRITEBYTECODE='1') == (0, '')
    assert len(list((tmp_path / 'cache' / 'unit5').glob('*-libunit5.so'))) == 1
    assert copied(PATH='', PYTHONDONTWRITEBYTECODE='1') == (0, '')  # no compiler is found now
    assert sorted((tmp_path / 'aruco_ar').rglob('*')) == before


@needs_compiler
def test_changed_sources_are_compiled_again(copied, tmp_path):
    assert copied() == (0, '')
    for already, changed in enumerate(('image.h', 'compiler.py'), 1):
        with open(str(tmp_path / 'aruco_ar' / 'compiled' / changed), 'a') as file:
            file.write('\n')
        code, output = copied(PATH='')
        assert code == 1 and 'SetupError: unit5 is not built' in output
        assert copied() == (0, '')
        assert len(list((tmp_path / 'cache' / 'unit5').glob('*-libunit5.so'))) == already + 1


def test_without_a_compiler_one_sentence_says_what_to_do(copied):
    code, output = copied(PATH='')
    assert code == 1
    assert 'SetupError: unit5 is not built, and there is no C compiler "cc"' in output.splitlines()[-1]
    assert 'sudo apt install build-essential' in output


@needs_compiler
@pytest.mark.parametrize('source', [OTHER, WITHOUT_VERSION], ids=['other version', 'no version'])
def test_a_library_of_another_version_is_not_used(copied, tmp_path, source):
    old = compiled(source, tmp_path / 'old')
    code, output = copied(PATH='', LD_LIBRARY_PATH=str(tmp_path / 'old'))
    assert code == 1 and '"%s" is of another version' % old in output.splitlines()[-1]
    assert copied(LD_LIBRARY_PATH=str(tmp_path / 'old')) == (0, '')


@needs_compiler
def test_a_library_of_this_version_is_used_even_behind_another_one(copied, tmp_path):
    compiled(OTHER, tmp_path / 'old')
    (tmp_path / 'built').mkdir()
    compile_to(str(tmp_path / 'built' / 'libunit5.so'))
    code, output = copied(MAPPED, PATH='', LD_LIBRARY_PATH='%s/old::%s/built' % (tmp_path, tmp_path))
    assert code == 0 and str(tmp_path / 'built' / 'libunit5.so') in output.split(), output


def test_it_is_compiled_with_our_flags(tmp_path, monkeypatch):
    """test_package.py asks the same of catkin's build."""
    (tmp_path / 'cc').write_text('#!/bin/sh\nprintf "%s\\n" "$@" > "$0.txt"\n')
    (tmp_path / 'cc').chmod(0o755)
    monkeypatch.setenv('PATH', str(tmp_path))
    compile_to('libunit5.so')
    assert (tmp_path / 'cc.txt').read_text().splitlines()[:len(flags())] == flags()


@needs_compiler
def test_an_array_on_the_stack_has_a_fixed_size(copied, tmp_path):
    with open(str(tmp_path / 'aruco_ar' / 'compiled' / 'version.c'), 'a') as file:
        file.write('int unit5_last(int count) { int many[count]; return many[count - 1]; }\n')
    code, output = copied()
    assert code == 1 and 'SetupError: The C compiler "cc" cannot build' in output and '-Werror=vla' in output


@needs_compiler
def test_only_names_of_unit5_can_be_seen(tmp_path):
    compile_to(str(tmp_path / 'libunit5.so'))
    shown = subprocess.run(['nm', '-D', '--defined-only', str(tmp_path / 'libunit5.so')], check=True, text=True,
                           stdout=subprocess.PIPE)
    names = {line.split()[-1] for line in shown.stdout.splitlines()}
    with open(os.path.join(HERE, 'unit5.h')) as header:
        assert names == set(re.findall(r'\bunit5_\w+', header.read()))


@needs_compiler
def test_where_the_cache_cannot_be_written_it_is_compiled_into_a_temporary_folder(copied, tmp_path):
    (tmp_path / 'cache').write_text('no folder')
    (tmp_path / 'temporary').mkdir()
    assert copied(TMPDIR=str(tmp_path / 'temporary')) == (0, '')
    assert list((tmp_path / 'temporary').iterdir()) == []


@needs_compiler
def test_folders_in_which_nothing_may_be_run(copied, tmp_path):
    """The cache, or also the temporary folder, is mounted so that no library can be loaded from it."""
    (tmp_path / 'noexec').mkdir()
    mounted = ['unshare', '--map-root-user', '--mount', 'bash', '-c',
               'mount -t tmpfs -o noexec none "$0" && exec "$@"', str(tmp_path / 'noexec')]
    if shutil.which('unshare') is None or subprocess.run([*mounted, 'true'], stdout=subprocess.DEVNULL,
                                                         stderr=subprocess.DEVNULL).returncode:
        pytest.skip('folders cannot be mounted here')
    noexec = str(tmp_path / 'noexec')
    assert copied(before=mounted, XDG_CACHE_HOME=noexec) == (0, '')
    code, output = copied(before=mounted, XDG_CACHE_HOME=noexec, TMPDIR=noexec)
    last = output.splitlines()[-1]
    assert code == 1 and 'SetupError: unit5 is not built, and there is no folder in which' in last, output
    assert noexec in last and 'set XDG_CACHE_HOME to a folder in which programs may be run' in last
