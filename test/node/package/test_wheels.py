"""script/wheels: what is in the wheels for other systems, and what their libraries do where they can be run."""
import os
import re
import shutil
import subprocess
import zipfile

import cv2
import numpy as np
import pytest
from aruco_ar.compiled import binding
from aruco_ar.compiled.compiler import HERE, version_of_sources
from rig import VERSION
from rig.systems.mach_o import read_library

pytestmark = [pytest.mark.long, pytest.mark.xdist_group('wheels')]

LINUX, ARM = 'manylinux_2_17_x86_64.manylinux2014_x86_64', 'manylinux_2_17_aarch64.manylinux2014_aarch64'
WINDOWS, MACS = 'win_amd64', ['macosx_10_13_x86_64', 'macosx_11_0_arm64']
LIBRARIES = {LINUX: 'libunit5.so', ARM: 'libunit5.so', WINDOWS: 'unit5.dll',
             **dict.fromkeys(MACS, 'libunit5.dylib')}
CALLER = os.path.join(os.path.dirname(read_library.__code__.co_filename), 'caller.c')
SYSROOT = '/usr/aarch64-linux-gnu'  # of Debian's libc6-arm64-cross
WINE = next(filter(os.path.exists, ['/usr/lib/wine/wine64', '/usr/bin/wine64', '/usr/bin/wine']), None)


@pytest.fixture
def library(wheels, tmp_path):
    """A function of a wheel's tag: takes the library out of it, and returns its path."""
    def taken(tag):
        wheel = wheels / ('aruco_ar-%s-py3-none-%s.whl' % (VERSION, tag))
        if tag == WINDOWS and not wheel.exists():
            pytest.skip('script/wheels has not been run here, and takes ten minutes for Windows')
        with zipfile.ZipFile(str(wheel)) as archive:
            names = [name for name in archive.namelist() if re.search(r'\.(so|dll|dylib|pyd|pdb|lib)$', name)]
            assert names == ['aruco_ar/compiled/' + LIBRARIES[tag]]
            return archive.extract(names[0], str(tmp_path))
    return taken


def output_of(*command, **named):
    done = subprocess.run(command, capture_output=True, text=True, **named)
    assert done.returncode == 0, done.stderr
    return done.stdout


def names_of_ours():
    with open(os.path.join(HERE, 'unit5.h')) as header:
        return set(re.findall(r'\bunit5_\w+', header.read()))


def test_there_is_one_wheel_for_each_system(wheels):
    made = {'aruco_ar-%s-py3-none-%s.whl' % (VERSION, tag) for tag in LIBRARIES}
    may_lack = {'aruco_ar-%s-py3-none-%s.whl' % (VERSION, WINDOWS)}
    assert made - may_lack <= {path.name for path in wheels.iterdir()} <= made


def test_another_folder_makes_the_same_bytes(wheels, package, tmp_path):
    source = shutil.copytree(package, str(tmp_path / 'elsewhere'), symlinks=True, ignore=shutil.ignore_patterns(
        '.git', '.venv', 'build', 'bags', 'dist', '__pycache__'))
    os.mkdir(source + '/build')
    os.symlink(package + '/build/wheels', source + '/build/wheels')  # Zig
    output_of(source + '/script/wheels', '--quick', env={**os.environ, 'SOURCE_DATE_EPOCH': '1700000000'})
    for path in wheels.iterdir():
        with open(os.path.join(source, 'dist', path.name), 'rb') as again:
            assert again.read() == path.read_bytes(), path.name


@pytest.mark.parametrize('tag', [LINUX, ARM])
def test_on_linux_only_our_names_are_shown_and_an_old_system_is_enough(library, tag):
    if shutil.which('readelf') is None:
        pytest.skip('there is no readelf')
    path = library(tag)
    symbols = output_of('readelf', '-W', '--dyn-syms', path)
    shown = re.findall(r'(?:GLOBAL|WEAK) +\w+ +(?!UND)\w+ (\S+)', symbols)
    assert set(shown) == names_of_ours()
    needed = re.findall(r'NEEDED.*\[(.*)\]', output_of('readelf', '-W', '-d', path))
    assert set(needed) <= {'libc.so.6', 'libm.so.6'}
    versions = re.findall(r'GLIBC_(\d+)\.(\d+)', output_of('readelf', '-W', '-V', path))
    assert versions and max((int(major), int(minor)) for major, minor in versions) <= (2, 17)


def test_on_windows_only_our_names_are_shown_and_only_the_system_is_needed(library):
    if shutil.which('objdump') is None or 'pei-x86-64' not in output_of('objdump', '-i'):
        pytest.skip('there is no objdump for Windows')
    told = output_of('objdump', '-p', library(WINDOWS))
    names = re.findall(r'^\t\[ *\d+\] (?:\+base\[ *\d+\]  ?\w+ )?(\w+)$', told, re.MULTILINE)
    assert set(names) == names_of_ours()
    needed = re.findall(r'DLL Name: (\S+)', told)
    assert needed and all(re.match(r'api-ms-win-crt-|KERNEL32\.dll', name) for name in needed), needed


@pytest.mark.parametrize('tag', MACS)
def test_on_macos_only_our_names_are_shown_and_only_the_system_is_needed(library, tag):
    with open(library(tag), 'rb') as file:
        found = read_library(file.read())
    # Zig's linker adds two names of the library's first byte. The system looks for names in this library only.
    assert found.shown == names_of_ours() | {'_mh_dylib_header', '__dso_handle'}
    assert found.loaded == ['/usr/lib/libSystem.B.dylib'] and found.own_name == '@rpath/libunit5.dylib'
    assert found.is_signed or tag == MACS[0]  # macOS on ARM loads nothing that is not


@pytest.mark.parametrize('tag, target, runner', [
    (LINUX, 'x86_64-linux-gnu.2.17', []), (ARM, 'aarch64-linux-gnu.2.17', ['qemu-aarch64', '-L', SYSROOT]),
    (WINDOWS, 'x86_64-windows-gnu', [WINE])], ids=['linux', 'arm', 'windows'])
def test_it_finds_the_same_quadrilaterals_as_here(library, package, frame, tmp_path, tag, target, runner):
    if tag == ARM and (shutil.which('qemu-aarch64') is None or not os.path.isdir(SYSROOT)):
        pytest.skip('there is no qemu-aarch64, or no C library for it: apt install qemu-user libc6-arm64-cross')
    if tag == WINDOWS and WINE is None:
        pytest.skip('there is no wine: apt install wine64')
    folder = os.path.dirname(library(tag))
    gray = cv2.cvtColor(frame, cv2.COLOR_BGR2GRAY)
    gray.tofile(folder + '/image')
    zig = [package + '/build/wheels/bin/python', '-m', 'ziglang', 'cc', '-target', target, '-O3', '-s']
    output_of(*zig, '-I', HERE, '-o', folder + '/caller.exe', CALLER)
    name = LIBRARIES[tag] if tag == WINDOWS else './' + LIBRARIES[tag]
    wine = {'WINEPREFIX': str(tmp_path / 'wine'), 'WINEDEBUG': '-all', 'LD_PRELOAD': ''}
    version, levels, *corners = output_of(
        *runner, folder + '/caller.exe', name, 'image', *map(str, gray.shape[::-1]), cwd=folder,
        env={**os.environ, **wine}).splitlines()
    assert version == version_of_sources() and int(levels) == binding.LEVELS
    expected = binding.find_quads(gray, 13, 80)
    found = np.float32([line.split() for line in corners]).reshape(-1, 4, 2)
    assert len(expected) >= 4 and found.shape == expected.shape
    assert np.abs(found - expected).max() < 0.01
