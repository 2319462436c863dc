#!/usr/bin/env python3
"""Prints how many cycles each relight kernel needs for a slot of 16 records when only the number of
execution ports limits it: llvm-mca's "Block RThroughput" of the kernel's innermost loop.

Usage: port_cycles.py BUILD_DIR > FILE, then relume bench --port-cycles FILE. Needs objdump and
llvm-mca (Debian package llvm). The first line names the processor models, which stand in for this
machine's: llvm-mca knows few processors.
"""

import pathlib
import re
import subprocess
import sys

SETS = ["scalar", "sse42", "avx2", "avx512"]
FORMATS = ["exact", "standard", "compact"]
LABELS = {"sse42": "sse4.2"}


def is_amd():
    return "AuthenticAMD" in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8")


def model_of(isa):
    # No AMD model of LLVM 14 knows AVX-512; Ice Lake has the two 512-bit pipes of Zen 5.
    return "znver3" if is_amd() and isa != "avx512" else "icelake-server"


def disassemble(path):
    """Yields (name, [(address, instruction)]) of every function."""
    text = subprocess.run(["objdump", "-d", "--no-show-raw-insn", "-w", str(path)], check=True,
                          capture_output=True, text=True).stdout
    for part in re.split(r"\n(?=[0-9a-f]+ <)", text):
        head = re.match(r"[0-9a-f]+ <(.*)>:\n", part)
        if not head:
            continue
        lines = re.findall(r"^\s*([0-9a-f]+):\t(.*)$", part, re.M)
        yield head.group(1), [(int(a, 16), i.split("#")[0].strip()) for a, i in lines]


def hot_loop(code):
    """The longest loop that holds no other loop: the one over slots."""
    index = {address: i for i, (address, _) in enumerate(code)}
    loops = []
    for i, (_, instruction) in enumerate(code):
        jump = re.match(r"j\w+\s+([0-9a-f]+)\b", instruction)
        if jump and index.get(int(jump.group(1), 16), i + 1) <= i:
            loops.append((index[int(jump.group(1), 16)], i))
    inner = [(a, b) for a, b in loops
             if not any((c, d) != (a, b) and a <= c and d <= b for c, d in loops)]
    a, b = max(inner, key=lambda loop: loop[1] - loop[0])
    return [instruction for _, instruction in code[a:b + 1]]


def port_cycles(loop, model):
    lines = [re.sub(r"^(j\w+)\s+.*", r"\1 .Lend", i) for i in loop]
    lines = [re.sub(r"\s*<[^>]*>", "", i) for i in lines]
    result = subprocess.run(["llvm-mca", f"-mcpu={model}", "-instruction-info=0",
                             "-resource-pressure=0", "-iterations=1"],
                            input="\n".join(lines) + "\n.Lend:\n", capture_output=True, text=True,
                            check=False)
    found = re.search(r"Block RThroughput:\s*([0-9.]+)", result.stdout)
    if not found:
        sys.exit(f"llvm-mca: {result.stderr[:500]}")
    return float(found.group(1))


def records(loop, lights):
    """Records that one turn of the loop shades: three sums are stored for each and each light."""
    floats = 0
    for instruction in loop:
        store = re.match(r"v?mov(\w+)\s+%([xyz])mm\d+,[^%]*\((?!%r[sb]p)", instruction)
        if store:
            kind, register = store.groups()
            floats += {"ss": 1, "lps": 2, "hps": 2, "sd": 2}.get(kind) or \
                {"x": 4, "y": 8, "z": 16}[register]
    return floats / 3 / lights


def main():
    objects = pathlib.Path(sys.argv[1]) / "core/CMakeFiles/relume_core.dir/relight"
    print("llvm-mca: " + ", ".join(f"{isa} as {model_of(isa)}" for isa in SETS))
    for isa in SETS:
        path = objects / f"kernel_{isa}.cpp.o"
        if not path.exists():
            continue
        for name, code in disassemble(path):
            kernel = re.search(r"shade_slotsINS_\d+([A-Za-z]+)ELNS_\d+CacheFormatE(\d+)"
                               r"ELNS_\d+LightKernelE(\d+)ELi(\d+)E", name)
            if not kernel or name.endswith(".cold"):
                continue
            shader, cache_format, kind, lights = kernel.groups()
            shader = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", shader).lower()
            loop = hot_loop(code)
            cycles = port_cycles(loop, model_of(isa)) * 16 / records(loop, int(lights))
            print(LABELS.get(isa, isa), shader, FORMATS[int(cache_format)], kind, lights,
                  f"{cycles:.1f}")


if __name__ == "__main__":
    main()
