# SPDX-License-Identifier: Apache-2.0
"""The peers: what each one needs, how it is installed beside the benchmark, how it is run."""
import dataclasses
import os
import pathlib
import subprocess
import sys
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
CASADI = "casadi==3.8.2"
ACADOS = "comma-deps-acados==0.2.2.post92"


@dataclasses.dataclass(frozen=True)
class Peer:
    name: str
    environment: str  # its folder
    packages: tuple
    program: str
    options: str
    built: str  # beside what its wheel holds


COMPILED, SOLVER = "generated C", "generated solver"


def of_casadi(name, program, options, built="", version=CASADI):
    return Peer(name, version.replace("==", "-"), (version,), program, options, built)


def of_package(name, package, program, options):
    """A peer whose package needs CasADi for the derivatives."""
    return Peer(name, package.split("==")[0], (CASADI, package), program, options, COMPILED)


PEERS = (
    of_casadi("Ipopt (CasADi 3.6.7), the script's options", "with_ipopt.py", "script",
              version="casadi==3.6.7"),
    of_casadi("Ipopt (CasADi 3.8.2), the script's options", "with_ipopt.py", "script"),
    of_casadi("Ipopt (CasADi 3.8.2), best options", "with_ipopt.py", "best", COMPILED),
    of_package("SSQP 0.1.2 with HPIPM, in Python", "ssqp==0.1.2", "with_ssqp.py", "hpipm"),
    of_package("alpaqa 1.1.0a2, PANOC", "alpaqa==1.1.0a2", "with_alpaqa.py", "panoc"),
    of_package("alpaqa 1.1.0a2, ZeroFPR", "alpaqa==1.1.0a2", "with_alpaqa.py", "zerofpr"),
    Peer("acados, SQP to 1e-4", "acados", (CASADI,), "with_acados.py", "sqp", SOLVER),
    Peer("acados, RTI", "acados", (CASADI,), "with_acados.py", "rti", SOLVER),
    Peer("acados, RTI, exact Hessian", "acados", (CASADI,), "with_acados.py", "rti_exact", SOLVER),
    of_package("Uno 0.4.16, interior point", "unopy==0.4.16", "with_uno.py", "ipopt"),
    of_package("Uno 0.4.16, filter SQP", "unopy==0.4.16", "with_uno.py", "filtersqp"),
    of_casadi("fatrop (CasADi 3.8.2), default options", "with_fatrop.py", "default", COMPILED),
    of_casadi("fatrop (CasADi 3.8.2), best options", "with_fatrop.py", "best", COMPILED),
)


def unpack_acados(python, folder):
    """Its folder alone: the wheel also holds a CasADi without what the other peers need."""
    subprocess.run([python, "-m", "pip", "download", "--quiet", "--no-deps", "--dest", folder, ACADOS],
                   check=True)
    for wheel in folder.glob("*.whl"):
        with zipfile.ZipFile(wheel) as archive:
            for member in archive.infolist():
                _, found, inside = member.filename.partition("/purelib/acados/")
                if found and not member.is_dir():
                    target = folder / "acados" / inside
                    target.parent.mkdir(parents=True, exist_ok=True)
                    target.write_bytes(archive.read(member))
        wheel.unlink()
    (folder / "acados" / "install" / "bin" / "t_renderer").chmod(0o755)


def install(build, peer):
    """Its Python, in a virtual environment of its own; made once."""
    folder = build / "peers" / peer.environment
    python, done = folder / "bin" / "python", folder / "installed"
    if not done.exists():
        print("Installing", *peer.packages, "into", folder, file=sys.stderr)
        subprocess.run([sys.executable, "-m", "venv", folder], check=True)
        subprocess.run([python, "-m", "pip", "install", "--quiet", "numpy", *peer.packages], check=True)
        if peer.environment == "acados":
            unpack_acados(python, folder)
        done.touch()
    return python


def environment(build, peer, march="native"):
    """Environment variables of its process; `march`: processor that generated code is compiled for."""
    out = {**os.environ, "PEERS_MARCH": march, "PYTHONDONTWRITEBYTECODE": "1"}
    if peer.environment != "acados":
        return out
    folder = build / "peers" / "acados" / "acados"
    return {**out, "ACADOS_SOURCE_DIR": str(folder / "install"), "PYTHONPATH": str(folder),
            "ACADOS_PYTHON_INTERFACE_PATH": str(folder / "acados_template"),
            "LD_LIBRARY_PATH": str(folder / "install" / "lib")}


def command(build, peer, steps, march="native"):
    return [install(build, peer), HERE / peer.program, peer.options, "--steps", str(steps), "--cache",
            build / "peers" / "cache" / march]


def loadable(build):
    """The peers that run here; says why one does not."""
    found = []
    for peer in PEERS:
        try:
            subprocess.run(command(build, peer, 2), env=environment(build, peer), check=True,
                           capture_output=True, text=True)
            found.append(peer)
        except (subprocess.CalledProcessError, OSError) as error:
            said = (getattr(error, "stderr", None) or str(error)).strip().splitlines()
            print(f"Left out: {peer.name}: {said[-1]}")
    return found
