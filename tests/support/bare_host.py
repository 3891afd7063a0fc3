"""Steps an FMU with the standard library alone: bare_host.py FMU START NAMES, both JSON.

Python 3.8 or newer, with nothing installed; prints the values of NAMES after 50 steps of 0.01 s.
"""

import ctypes
import importlib.util
import json
import sys
import tempfile
import zipfile
from pathlib import Path
from xml.etree import ElementTree

STEPS, H = 50, 0.01
TEXT = ctypes.c_char_p
LOGGER = ctypes.CFUNCTYPE(None, ctypes.c_void_p, TEXT, ctypes.c_int, TEXT, TEXT)
FREE = ctypes.CFUNCTYPE(None, ctypes.c_void_p)
PROCESS = ctypes.CDLL(None)
PROCESS.calloc.restype = ctypes.c_void_p


class Callbacks(ctypes.Structure):
    _fields_ = [
        ("logger", LOGGER),
        ("allocate", ctypes.c_void_p),
        ("free", ctypes.c_void_p),
        ("finished", ctypes.c_void_p),
        ("environment", ctypes.c_void_p),
    ]


def address(function):
    return ctypes.cast(function, ctypes.c_void_p).value


def steps(folder, start, names):
    root = ElementTree.parse(str(folder / "modelDescription.xml")).getroot()
    [kind] = root.iter("CoSimulation")
    identifier = kind.attrib["modelIdentifier"]
    variables = root.iter("ScalarVariable")
    references = {v.attrib["name"]: int(v.attrib["valueReference"]) for v in variables}
    fmu = ctypes.CDLL(str(folder / "binaries" / "linux64" / (identifier + ".so")))
    fmu.fmi2Instantiate.restype = ctypes.c_void_p
    logger = LOGGER(lambda *said: print(*said, file=sys.stderr))
    callbacks = Callbacks(logger, address(PROCESS.calloc), address(PROCESS.free), None, None)
    where = (folder / "resources").as_uri().encode()
    guid = root.attrib["guid"].encode()
    model = ctypes.c_void_p(
        fmu.fmi2Instantiate(b"model", 1, guid, where, ctypes.byref(callbacks), 0, 1)
    )
    if not model:
        raise SystemExit("it cannot be instantiated")
    one = ctypes.c_size_t(1)

    def real(name):
        return (ctypes.c_uint * 1)(references[name])

    def check(status):
        if status:
            raise SystemExit(f"the FMU answered {status}")

    for name, value in start.items():
        check(fmu.fmi2SetReal(model, real(name), one, (ctypes.c_double * 1)(value)))
    zero = ctypes.c_double(0.0)
    check(fmu.fmi2SetupExperiment(model, 0, zero, zero, 0, zero))
    check(fmu.fmi2EnterInitializationMode(model))
    check(fmu.fmi2ExitInitializationMode(model))
    for k in range(STEPS):
        check(fmu.fmi2DoStep(model, ctypes.c_double(k * H), ctypes.c_double(H), 1))
    values = []
    for name in names:
        value = (ctypes.c_double * 1)()
        check(fmu.fmi2GetReal(model, real(name), one, value))
        values.append(value[0])
    check(fmu.fmi2Terminate(model))
    fmu.fmi2FreeInstance(model)
    return values


def main():
    for name in ("m4e_fmi", "pythonfmu", "numpy", "fmpy"):
        if importlib.util.find_spec(name) is not None:
            raise SystemExit(name + " is installed here")
    with tempfile.TemporaryDirectory() as folder:
        with zipfile.ZipFile(sys.argv[1]) as archive:
            archive.extractall(folder)
        print(json.dumps(steps(Path(folder), json.loads(sys.argv[2]), json.loads(sys.argv[3]))))


main()
