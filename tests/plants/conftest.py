"""FMUs made for the tests: the exported finger, small good and bad ones in C, and ones made by pythonfmu."""

import inspect
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

FMUS = Path(__file__).resolve().parent / "fmus"
STATE2 = 'canGetAndSetFMUstate="true" canSerializeFMUstate="true"'
DESCRIPTION2 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="small" guid="small" numberOfEventIndicators="{indicators}">
  <{kind} modelIdentifier="small" {state}/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input" variability="continuous">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output" variability="continuous">
      <Real/></ScalarVariable>
    <ScalarVariable name="steps" valueReference="0" causality="output" variability="discrete">
      <Integer/></ScalarVariable>
    <ScalarVariable name="x" valueReference="2" variability="continuous"><Real/></ScalarVariable>
    <ScalarVariable name="der(x)" valueReference="3" variability="continuous">
      <Real derivative="4"/></ScalarVariable>
    <ScalarVariable name="v" valueReference="4" variability="continuous"><Real/></ScalarVariable>
    <ScalarVariable name="der(v)" valueReference="5" variability="continuous">
      <Real derivative="6"/></ScalarVariable>
    <ScalarVariable name="h" valueReference="6" causality="parameter" variability="fixed">
      <Real start="0"/></ScalarVariable>
    <ScalarVariable name="w" valueReference="7" causality="output" variability="continuous">
      <Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure>
    <Outputs><Unknown index="2"/><Unknown index="3"/><Unknown index="9"/></Outputs>
    {derivatives}
  </ModelStructure>
</fmiModelDescription>
"""
DESCRIPTION3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="small" instantiationToken="small">
  <CoSimulation modelIdentifier="small" canGetAndSetFMUState="true" canSerializeFMUState="true" {extra}/>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="u" valueReference="1" causality="input" start="{start}">
      <Dimension {dimension}/></Float64>
    <UInt64 name="N" valueReference="4" causality="structuralParameter" variability="fixed" start="3"/>
    <Float64 name="y" valueReference="2" causality="output" initial="calculated">
      <Dimension start="3"/></Float64>
    <Float64 name="h" valueReference="3" causality="parameter" variability="fixed" start="0"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="2"/></ModelStructure>
</fmiModelDescription>
"""


def compiled(sources, library, *definitions):
    """Shared library of C sources."""
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    fmpy = Path(__import__("fmpy").__file__).parent
    command = ["gcc", "-std=gnu11", "-O1", "-fPIC", "-shared", f"-I{fmpy / 'c-code'}",
               *(f"-D{definition}" for definition in definitions), *map(str, sources)]
    subprocess.run([*command, "-o", str(library), "-lm"], check=True, capture_output=True)


def missing_functions(cls, prefix, source):
    """C stubs for the interface functions that FMPy looks up and a source does not define."""
    text = source.read_text()
    names = (name for name, _ in inspect.getmembers(cls) if name.startswith(prefix))
    return "".join(f"int {name}(void) {{ return 3; }}\n" for name in names if f"{name}(" not in text)


def packed(target, files):
    """A zip of contents by name."""
    with zipfile.ZipFile(target, "w") as archive:
        for name, content in files.items():
            archive.writestr(name, content)
    return target


@pytest.fixture(scope="session")
def small2(tmp_path_factory):
    """Makes the small FMI 2.0 FMU of small2.c, compiled with definitions."""
    from fmpy.fmi2 import FMU2Model, FMU2Slave

    def make(*definitions, kind="CoSimulation", state=STATE2, indicators=0, states=0):
        folder = tmp_path_factory.mktemp("small2")
        stubs = folder / "stubs.c"
        source = FMUS / "small2.c"
        lines = {line for cls in (FMU2Slave, FMU2Model)
                 for line in missing_functions(cls, "fmi2", source).splitlines()}
        stubs.write_text("\n".join(sorted(lines)))
        compiled([source, stubs], folder / "small.so", *definitions)
        unknowns = "".join(f'<Unknown index="{index}"/>' for index in (5, 7)[:states])
        derivatives = f"<Derivatives>{unknowns}</Derivatives>" if states else ""
        text = DESCRIPTION2.format(kind=kind, state=state, indicators=indicators, derivatives=derivatives)
        return packed(folder / "small.fmu", {
            "modelDescription.xml": text, "binaries/linux64/small.so": (folder / "small.so").read_bytes()})

    return make


@pytest.fixture(scope="session")
def small3(tmp_path_factory):
    """Makes the small FMI 3.0 FMU of small3.c, compiled with definitions."""
    from fmpy.fmi3 import FMU3Slave

    def make(*definitions, extra="", start="0 0 0", dimension='start="3"'):
        folder = tmp_path_factory.mktemp("small3")
        stubs = folder / "stubs.c"
        stubs.write_text(missing_functions(FMU3Slave, "fmi3", FMUS / "small3.c"))
        compiled([FMUS / "small3.c", stubs], folder / "small.so", *definitions)
        return packed(folder / "small.fmu", {
            "modelDescription.xml": DESCRIPTION3.format(
                extra=extra, start=start, dimension=dimension),
            "binaries/x86_64-linux/small.so": (folder / "small.so").read_bytes()})

    return make


@pytest.fixture(scope="session")
def python_fmu(tmp_path_factory):
    """Makes an FMU with pythonfmu (2) or pythonfmu3 (3) from its script in the folder of FMUs."""

    def make(version, *options, script="lag"):
        module = {2: "pythonfmu", 3: "pythonfmu3"}[version]
        pytest.importorskip(module)
        folder = tmp_path_factory.mktemp(module)
        source = FMUS / f"{script}_python{version}.py"
        command = [sys.executable, "-m", module, "build", "-f", str(source), "-d", str(folder), *options]
        subprocess.run(command, check=True, capture_output=True)
        return next(folder.glob("*.fmu"))

    return make


@pytest.fixture(scope="session")
def finger_fmu(tmp_path_factory):
    """The default finger as an FMU with a binary."""
    from plants.fmu.export import build_finger_fmu

    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    return build_finger_fmu(tmp_path_factory.mktemp("finger") / "finger.fmu", binary=True).path
