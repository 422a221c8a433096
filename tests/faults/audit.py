#!/usr/bin/env python3
"""The fault audit: builds a copy of the project with many faults at once, each behind a switch, and runs
the tests with one after the other switched on. See docs/testing.md.

    tests/faults/audit.py FOLDER [--sample N] [--seed N] [--only TEXT]... [--faults FILE] [--root]

FOLDER, outside of the project, holds a copy of what is committed, its build and the answer, results.jsonl. What
it has answered already is not run again: the audit can be stopped at any time, and gone on with, with more faults
too. Needs git, cargo, cargo-mutants, which lists the faults, and a system with the limits of POSIX.
"""

import argparse
import collections
import json
import os
import pathlib
import random
import re
import resource
import shutil
import subprocess
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent.parent
PACKAGES = ["eigentone-modes", "eigentone-response"]
ROOT_TESTS = ["laws", "certified", "truth", "motion", "theory"]
# A fault that fills the memory ends by itself.
MEMORY = 8 << 30
# The switch is read once, by what both packages build on.
SWITCH = """
/// The fault that is made.
#[inline(always)]
pub fn active_fault() -> u32 {
    static ACTIVE: std::sync::LazyLock<u32> = std::sync::LazyLock::new(|| {
        std::env::var("FAULT").ok().and_then(|x| x.parse().ok()).unwrap_or(0)
    });
    *ACTIVE
}
"""


def listed(folder):
    """All faults that cargo-mutants makes."""
    kept = folder / "mutants.json"
    if not kept.exists():
        command = ["cargo", "mutants", "--list", "--json"]
        for package in PACKAGES:
            command += ["-p", package]
        listing = subprocess.run(command, cwd=folder / "source", check=True, stdout=subprocess.PIPE).stdout
        kept.write_bytes(listing)
    return json.loads(kept.read_text())


def drawn(mutants, options):
    """A sample from each file, in turns, so that what has run when it is stopped is a sample too. What is drawn
    from one file depends neither on the others nor on how much is drawn."""
    by_file = collections.OrderedDict()
    for mutant in mutants:
        by_file.setdefault(mutant["file"], []).append(mutant)
    samples = []
    for file, faults in by_file.items():
        random.Random(f"{options.seed} {file}").shuffle(faults)
        samples.append(faults[: options.sample])
    turns = range(max(map(len, samples), default=0))
    return [sample[turn] for turn in turns for sample in samples if turn < len(sample)]


def chosen(folder, options):
    """The faults by hand, those asked for and those drawn."""
    faults = json.loads((HERE / "by_hand.json").read_text())
    if options.faults:
        faults += json.loads(options.faults.read_text())
    faults = [fault for fault in faults if wanted(fault, options)]
    faults += drawn([mutant for mutant in listed(folder) if wanted(mutant, options)], options)
    for fault in faults:
        fault.pop("diff", None)
        fault.setdefault("name", f"{fault['file']}: {fault.get('fault')}")
    return list({fault["name"]: fault for fault in faults}.values())


def wanted(fault, options):
    return not options.only or any(text in fault["file"] for text in options.only)


class Copy:
    """Sources with switches, and what of them does not compile."""

    def __init__(self, folder, tool, faults):
        self.folder, self.tool, self.faults = folder, tool, faults
        self.pristine, self.source = folder / "source", folder / "switched"
        self.left_out = folder / "left_out.txt"
        self.left_out.touch()
        if not self.source.exists():
            shutil.copytree(self.pristine, self.source)
        (folder / "faults.json").write_text(json.dumps(faults))

    def excluded(self):
        return set(self.left_out.read_text().splitlines())

    def exclude(self, numbers, why):
        names = sorted(self.faults[number - 1]["name"] for number in numbers)
        with self.left_out.open("a") as file:
            file.writelines(f"{name}\n" for name in names)
        print(f"{len(names)} faults {why}", flush=True)

    def switched(self):
        """Writes all switches but those left out; which faults stand in which lines, and which nowhere."""
        fresh, numbers = self.folder / "fresh", self.folder / "numbers.txt"
        shutil.rmtree(fresh, ignore_errors=True)
        shutil.copytree(self.pristine, fresh, ignore=shutil.ignore_patterns(".git", "docs"))
        for manifest in [fresh / "Cargo.toml", *fresh.glob("crates/*/Cargo.toml")]:
            # What is rewritten is no model of style.
            text = re.sub(r"(?ms)^\[(workspace\.)?lints.*?(?=^\[|\Z)", "", manifest.read_text())
            manifest.write_text(text)
        digits = fresh / "crates/digits/src/lib.rs"
        digits.write_text(digits.read_text() + SWITCH)
        excluded = self.excluded()
        out = [number for number, fault in enumerate(self.faults, 1) if fault["name"] in excluded]
        numbers.write_text("".join(f"{number}\n" for number in out))
        command = [self.tool, fresh, self.folder / "faults.json", numbers]
        lines = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
        # Only what differs is written, or all would be compiled again.
        for new in fresh.rglob("*"):
            old = self.source / new.relative_to(fresh)
            if new.is_file() and (not old.exists() or old.read_bytes() != new.read_bytes()):
                old.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(new, old)
        arms, sites, unplaced = collections.defaultdict(set), collections.defaultdict(list), []
        for line in lines.splitlines():
            kind, *words = line.split(" ")
            if kind == "arm":
                arms[words[0], int(words[1])].add(int(words[2]))
            elif kind == "site":
                sites[words[0]].append((int(words[1]), int(words[2]), [int(word) for word in words[3:]]))
            else:
                unplaced.append(int(words[0]))
        return arms, sites, unplaced

    def built(self, what):
        """Test programs with all faults that compile: folder, name, path."""
        while True:
            arms, sites, unplaced = self.switched()
            if unplaced:
                self.exclude(unplaced, "are not placed")
                for number in unplaced:
                    if "old" in self.faults[number - 1]:
                        print("unplaced:", self.faults[number - 1]["name"])
            command = ["cargo", "test", "--release", "--no-run", "--message-format=json", *what]
            environment = dict(os.environ, CARGO_TARGET_DIR=str(self.folder / "target"))
            run = subprocess.run(command, cwd=self.source, env=environment, stdout=subprocess.PIPE, text=True)
            messages = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
            if run.returncode == 0:
                tests = [m for m in messages if m.get("executable") and m["profile"]["test"]]
                return [(str(pathlib.Path(m["manifest_path"]).parent), m["target"]["name"], m["executable"]) for m in tests]
            errors = [m["message"] for m in messages if m["reason"] == "compiler-message"]
            errors = [error for error in errors if error["level"] == "error"]
            drop = set().union(*(blamed(error, arms, sites) for error in errors))
            if not drop:
                raise SystemExit("\n".join(error["rendered"] for error in errors))
            self.exclude(drop, "do not compile")


def blamed(message, arms, sites):
    """The faults that an error of the compiler is about."""
    spans = [span for span in message["spans"] if span["is_primary"]]
    found = set()
    for span in spans:
        for line in range(span["line_start"], span["line_end"] + 1):
            found |= arms.get((span["file_name"], line), set())
    for span in spans if not found else []:
        around = [site for site in sites[span["file_name"]] if site[0] <= span["line_start"] <= site[1]]
        if around:
            found |= set(min(around, key=lambda site: site[1] - site[0])[2])
    return found


def run(program, fault, limit, only=()):
    """How the tests end with this fault, the first that fails, and how long that takes."""
    folder, _, path = program
    # The first case that fails will do, and none of one fault is kept for another.
    environment = dict(
        os.environ, FAULT=str(fault), PROPTEST_RNG_SEED="20261121", PROPTEST_MAX_SHRINK_ITERS="0",
    )
    process = subprocess.Popen(
        [path, *only], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        text=True, errors="replace",
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY)),
    )
    began = time.monotonic()
    timer = threading.Timer(limit, process.kill)
    timer.start()
    failed = None
    for line in process.stdout:
        match = re.match(r"^test (\S+).* \.\.\. FAILED", line)
        if match:
            failed = match[1]
            process.kill()
            break
    process.stdout.close()
    code, took = process.wait(), time.monotonic() - began
    timer.cancel()
    if failed or code != 0:
        regressions = ":(top,glob)**/proptest-regressions/**"
        subprocess.run(["git", "checkout", "-q", "--", regressions], cwd=folder, check=True)
        subprocess.run(["git", "clean", "-fdqx", "--", regressions], cwd=folder, check=True)
        return ("endless" if not failed and took >= limit else "caught"), failed or f"exit {code}", took
    return "missed", None, took


def beside(fault):
    """The name of the module that a fault is in: its own tests are the quickest that may notice."""
    path = pathlib.PurePath(fault["file"]).with_suffix("").parts[3:]
    return "::".join(part for part in path if part != "mod") + "::"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--sample", type=int, default=12, help="faults drawn from each file")
    parser.add_argument("--seed", type=int, default=20261121)
    parser.add_argument("--only", action="append", help="files whose path holds this")
    parser.add_argument("--faults", type=pathlib.Path, help="these too, as cargo-mutants lists them (mutants.json)")
    parser.add_argument("--root", action="store_true", help="what the packages miss meets the root's tests too")
    options = parser.parse_args()
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    if not (folder / "source").exists():
        subprocess.run(["git", "clone", "-q", PROJECT, folder / "source"], check=True)
    tool_target = folder / "switches"
    build = ["cargo", "build", "--release", "--locked", "--manifest-path", HERE / "Cargo.toml", "--target-dir", tool_target]
    subprocess.run(build, check=True)
    faults = chosen(folder, options)
    copy = Copy(folder, tool_target / "release/fault-switches", faults)

    own = [word for package in PACKAGES for word in ("-p", package)] + ["--lib", "--tests"]
    programs = copy.built(own)
    root = []
    if options.root:
        root = copy.built([word for test in ROOT_TESTS for word in ("--test", test)])
    usual = {}
    for program in programs + root:
        outcome, failed, usual[program] = run(program, 0, 3600)
        if outcome != "missed":
            raise SystemExit(f"{program[1]} fails without a fault: {failed}")
    results = folder / "results.jsonl"
    lines = results.read_text().splitlines() if results.exists() else []
    known = {entry["name"]: entry for entry in map(json.loads, lines)}
    # What the packages alone have missed meets the root's tests as soon as these are asked for.
    done = {entry["name"] for entry in known.values() if entry["outcome"] != "missed" or entry["root"] >= options.root}
    left = copy.excluded() | done
    for number, fault in enumerate(faults, 1):
        if fault["name"] in left:
            continue
        crate = "/".join(pathlib.PurePath(fault["file"]).parts[:2])
        of_crate = sorted((p for p in programs if p[0].endswith(crate)), key=usual.get)
        tests = [(p, [beside(fault)]) for p in of_crate if p[1].startswith("eigentone")]
        tests += [(p, []) for p in of_crate + sorted(root, key=usual.get)]
        outcome, failed, by = "missed", None, None
        for program, only in tests:
            outcome, failed, _ = run(program, number, 60 + 8 * usual[program], only)
            if outcome != "missed":
                by = program[1]
                break
        entry = {"name": fault["name"], "file": fault["file"], "outcome": outcome, "by": by, "test": failed, "root": options.root}
        known[entry["name"]] = entry
        with results.open("a") as file:
            file.write(json.dumps(entry, ensure_ascii=False) + "\n")
    counts = collections.defaultdict(collections.Counter)
    for entry in known.values():
        counts[entry["file"]][entry["outcome"]] += 1
    for file, of_file in counts.items():
        print(file, dict(of_file))
    for entry in known.values():
        if entry["outcome"] == "missed":
            print("missed:", entry["name"])


if __name__ == "__main__":
    main()
