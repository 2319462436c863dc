"""The commands that write files, each with its right files of before and after, for kill_writers and fail_writers."""

import os
import pathlib
import shutil
import subprocess
import time

MARK = ".relume-tmp-"  # in the names of temporaries, as core/base/file.cpp has it
SIZE = ["--width", "64", "--height", "64"]
SAVES = 3


def read_folder(folder):
    """The bytes of all files, by name, temporaries apart; and the number of these."""
    files, temporaries = {}, 0
    for entry in sorted(folder.iterdir()):
        if MARK in entry.name:
            temporaries += 1
        elif entry.is_file():
            files[entry.name] = entry.read_bytes()
    return files, temporaries


class Writer:
    """A command that writes into a folder. `before` and each of `after` are folders' files: what stands there when it starts,
    and what it may have written."""

    def __init__(self, name, program, faults, work):
        self.name, self.program, self.faults = name, str(program), faults
        self.folder = work / name
        self.inputs = work / "inputs"
        self.environment = dict(os.environ, MESA_SHADER_CACHE_DISABLE="true", XDG_DATA_HOME=str(work / "home"),
                                XDG_CONFIG_HOME=str(work / "home"), XDG_CACHE_HOME=str(work / "home"))

    def arguments(self, seed):
        """The command that writes the files of `seed` into self.folder."""
        raise NotImplementedError

    def is_extra(self, name):
        """Whether a file that stays after a kill is no result: what the next run goes on from."""
        return False

    def start(self, seed, fault=None, log=None):
        environment = dict(self.environment)
        if fault or log:
            environment["LD_PRELOAD"] = str(self.faults)
        if fault:
            environment["RELUME_FAULT"] = fault
        if log:
            environment["RELUME_FAULT_LOG"] = str(log)
        return subprocess.Popen([str(a) for a in self.arguments(seed)], env=environment, stdout=subprocess.DEVNULL,
                                stderr=subprocess.PIPE, text=True)

    def run(self, seed, fault=None, log=None):
        """Exit code and standard error."""
        process = self.start(seed, fault, log)
        told = process.communicate(timeout=120)[1]
        return process.returncode, told

    def clear(self):
        shutil.rmtree(self.folder, ignore_errors=True)
        self.folder.mkdir(parents=True)

    def put(self, files):
        """Makes the folder hold these files; temporaries stay."""
        for entry in self.folder.iterdir():
            if MARK not in entry.name:
                entry.unlink()
        for name, content in files.items():
            (self.folder / name).write_bytes(content)

    def make_states(self):
        """What stands before and after, and how long the command takes. The command runs alone."""
        states = []
        for seed in (1, 2):
            self.clear()
            begin = time.monotonic()
            code, told = self.run(seed)
            self.seconds = time.monotonic() - begin
            assert code == 0, (self.name, told)
            files, temporaries = read_folder(self.folder)
            assert files and temporaries == 0, (self.name, list(files), temporaries)
            states.append(files)
        self.before, self.after = states[0], [states[1]]
        assert self.before != states[1], self.name
        self.count_calls()

    def count_calls(self):
        """The calls that change files, in order, of a run over the old files."""
        log = self.inputs / f"{self.name}.calls"
        log.unlink(missing_ok=True)
        self.clear()
        self.put(self.before)
        code, told = self.run(2, log=log)
        assert code == 0, (self.name, told)
        self.calls = log.read_text().splitlines()

    def find_fault(self, files, started_with):
        """A sentence on the first file that is neither old nor new, or None."""
        for name in sorted(set(files) | set(self.before)):
            right = [state.get(name) for state in [started_with, *self.after]]
            if files.get(name) not in right and not self.is_extra(name):
                size = len(files[name]) if name in files else None
                return f"{self.name}: {name} ({size} bytes) is neither the old nor the new one"
        return None


class PrepareWriter(Writer):
    def arguments(self, seed):
        return [self.program, "prepare", "spheres", "-o", self.folder / "a.relume", "--spp", 9, "--records", 4, "--seed", seed,
                "--width", 128, "--height", 128, "-q"]


class RenderWriter(Writer):
    """The caches are made once."""

    def make_states(self):
        for seed in (1, 2):
            cache = self.inputs / f"{seed}.relume"
            subprocess.run([self.program, "prepare", "spheres", "-o", cache, "--seed", str(seed), "--spp", "4", "-q",
                            "--width", "160", "--height", "160"], check=True, stdout=subprocess.DEVNULL)
        super().make_states()

    def arguments(self, seed):
        return [self.program, "render", self.inputs / f"{seed}.relume", "-o", self.folder / "a.exr", "--shadow", "none", "-q"]


class SessionWriter(Writer):
    """The viewer saves a session several times, each time with another light gain."""

    def make_states(self):
        subprocess.run([self.program, "prepare", "spheres", "-o", self.inputs / "view.relume", "--spp", "4", "-q", *SIZE],
                       check=True, stdout=subprocess.DEVNULL)
        after = []
        self.saves = SAVES
        super().make_states()
        for self.saves in range(1, SAVES + 1):
            self.clear()
            code, told = self.run(2)
            assert code == 0, told
            after.append(read_folder(self.folder)[0])
        self.after = after
        assert len({state["a.json"] for state in after}) == SAVES

    def arguments(self, seed):
        script = self.inputs / f"{seed}.{self.saves}.txt"
        steps = ["key ctrl+s", f"type {self.folder / 'a'}", "key enter"]
        if seed == 1:
            steps = ["key ,"] + steps
        steps += ["key .", "key ctrl+s"] * (self.saves - 1)
        script.write_text("\n".join(steps) + "\n")
        return [self.program, "view", self.inputs / "view.relume", "--offscreen", self.inputs / "screens", "--script", script,
                "--shadow", "none"]


class StudyWriter(Writer):
    def arguments(self, seed):
        return [self.program, "study", "rates", "spheres", "--methods", "kmeans", "--records", 2, "--lights", 2, "--spp", 4,
                "--width", 64, "--height", 64, "--seed", seed, "-o", self.folder]

    def is_extra(self, name):
        return name == "rates.trials"


class InPlaceWriter(Writer):
    """What no command of ours does: writes over the old file. For the check of the check."""

    def make_states(self):
        for seed in (1, 2):
            (self.inputs / f"{seed}.bin").write_bytes(bytes([seed]) * 65536)
        super().make_states()

    def arguments(self, seed):
        return ["dd", f"if={self.inputs}/{seed}.bin", f"of={self.folder}/a.bin", "bs=4096"]


WRITERS = {"prepare": PrepareWriter, "render": RenderWriter, "session": SessionWriter, "study": StudyWriter}


def make_writers(program, faults, work, names=None):
    work.mkdir(parents=True, exist_ok=True)
    (work / "inputs").mkdir(exist_ok=True)
    known = {**WRITERS, "in-place": InPlaceWriter}
    writers = [known[name](name, program, faults, work) for name in (names or WRITERS)]
    for writer in writers:
        writer.make_states()
    return writers
