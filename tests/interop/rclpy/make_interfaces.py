# SPDX-License-Identifier: Apache-2.0
"""make_interfaces.py FOLDER...: makes the modules of packages of messages for the rclpy of this Python, by the
generators in its wheels, and installs them beside it. FOLDER is called like the package and has action/*.action.
"""
import contextlib
import importlib
import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig
import tempfile

PREFIX = pathlib.Path(sys.prefix)
SHARE = PREFIX / 'share'
# What `rosidl generate` runs, which refuses these wheels because they name each generator twice.
GENERATORS = {'generator_c': 'GenerateC', 'typesupport_introspection_c': 'GenerateIntrospectionCTypesupport',
              'typesupport_fastrtps_c': 'GenerateFastRTPSCTypesupport'}
PYTHON_TYPESUPPORT = 'rosidl_typesupport_c'


def extension(module, name):
    return getattr(importlib.import_module(f'rosidl_{module}.cli'), name)(module)


def generate(package, folder, out):
    """Writes the sources of each library into a folder of `out` called like it."""
    from rosidl_adapter.action import convert_action_to_idl
    from rosidl_cli.command.helpers import legacy_generator_arguments_file
    from rosidl_generator_py import generate_py
    from rosidl_typesupport_c import generate_c
    idl_folder = out / 'idl/action'
    for file in sorted(folder.glob('action/*.action')):
        convert_action_to_idl(folder, package, file.relative_to(folder), idl_folder)
    idl = [f'{out}/idl:action/{file.name}' for file in sorted(idl_folder.glob('*.idl'))]
    include = [str(SHARE)]
    hashes = extension('generator_type_description', 'HashTypeDescription').generate_type_hashes(
        package, idl, include, out / 'hashes')
    for part, generator in GENERATORS.items():
        more = [hashes] if part == 'generator_c' else []
        extension(part, generator).generate(package, idl, include, out / part / package, *more)

    def arguments(part):
        return legacy_generator_arguments_file(
            package_name=package, interface_files=idl, include_paths=include,
            templates_path=SHARE / f'rosidl_{part}/resource', output_path=out / part / package)
    with arguments('typesupport_c') as file:
        generate_c(file, [f'rosidl_{part}' for part in GENERATORS if part.startswith('typesupport')])
    with arguments('generator_py') as file:
        generate_py(file, [PYTHON_TYPESUPPORT])


def compile_library(out, part, library, libraries):
    import numpy
    include = [*(out / part for part in GENERATORS), PREFIX / 'include', *(PREFIX / 'include').iterdir(),
               sysconfig.get_path('include'), numpy.get_include()]
    objects = []
    for source in [*(out / part).rglob('*.c'), *(out / part).rglob('*.cpp')]:
        objects.append(out / f'{part}_{len(objects)}.o')
        compiler = ['g++', '-std=c++17'] if source.suffix == '.cpp' else ['gcc', '-std=c11']
        subprocess.run([*compiler, '-fPIC', '-O0', '-w', '-c', source, '-o', objects[-1],
                        *(f'-I{folder}' for folder in include)], check=True)
    subprocess.run(['g++', '-shared', '-Wl,--as-needed', '-Wl,-rpath,' + str(PREFIX / 'lib'), *objects, '-o', library,
                    *libraries], check=True)


def make(folder):
    package = folder.name
    with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(sys.stderr):
        out = pathlib.Path(name)
        generate(package, folder.resolve(), out)
        parts = ('generator_c', 'generator_py', *GENERATORS, 'typesupport_c')
        libraries = [file for part in parts for file in PREFIX.glob(f'lib/lib*__rosidl_{part}.so')
                     if not file.name.startswith(f'lib{package}__')]
        libraries += PREFIX.glob('lib/librosidl_*.so')
        libraries += [PREFIX / 'lib/libfastcdr.so', PREFIX / 'lib/librcutils.so']
        for part in (*GENERATORS, 'typesupport_c'):
            libraries.append(PREFIX / f'lib/lib{package}__rosidl_{part}.so')
            compile_library(out, part, libraries[-1], libraries[:-1])
        module = out / 'generator_py' / package
        compile_library(out, 'generator_py', module / f'{package}_s__{PYTHON_TYPESUPPORT}.so', libraries)
        shutil.copytree(module, pathlib.Path(sysconfig.get_path('platlib')) / package, dirs_exist_ok=True)


if __name__ == '__main__':
    os.environ['AMENT_PREFIX_PATH'] = str(PREFIX)
    for argument in sys.argv[1:]:
        make(pathlib.Path(argument))
