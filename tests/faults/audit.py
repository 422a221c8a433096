#!/usr/bin/env python3
"""The fault audit: builds a copy of the project with many faults at once, each behind a switch, and runs
the tests with one after the other switched on. See docs/testing.md.

    tests/faults/audit.py FOLDER [--sample N] [--seed N] [--only TEXT]... [--root]

FOLDER holds the copy, its build and the answer, results.jsonl; what it has answered already is not run again.
Needs git, cargo and cargo-mutants, which lists the faults.
"""

import argparse
import collections
import json
import os
import pathlib
import random
import re
import subprocess
import threading
import time

HERE = pathlib.Path(__file__).resolve().parent
PROJECT = HERE.parent.parent
PACKAGES = ["eigentone-modes", "eigentone-response"]
ROOT_TESTS = ["laws", "certified", "truth", "motion", "estimated", "response_laws", "theory"]
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


def chosen(source, options):
    """The faults by hand, then a sample of those that cargo-mutants lists, file by file."""
    listed = ["cargo", "mutants", "--list", "--json"]
    for package in PACKAGES:
        listed += ["-p", package]
    mutants = json.loads(subprocess.run(listed, cwd=source, check=True, stdout=subprocess.PIPE).stdout)
    by_file = collections.OrderedDict()
    for mutant in mutants:
        mutant.pop("diff", None)
        if not options.only or any(text in mutant["file"] for text in options.only):
            by_file.setdefault(mutant["file"], []).append(mutant)
    draw = random.Random(options.seed)
    sample = []
    for faults in by_file.values():
        count = min(options.sample, len(faults))
        sample += [faults[at] for at in sorted(draw.sample(range(len(faults)), count))]
    by_hand = json.loads((HERE / "by_hand.json").read_text())
    for fault in by_hand:
        fault["name"] = fault["fault"]
    return by_hand + sample


def switched(source, folder, tool):
    """Fresh sources with all switches but those left out; which faults stand in which lines."""
    subprocess.run(["git", "checkout", "-q", "--", "."], cwd=source, check=True)
    for manifest in [source / "Cargo.toml", *source.glob("crates/*/Cargo.toml")]:
        # What is rewritten is no model of style.
        text = re.sub(r"(?ms)^\[(workspace\.)?lints.*?(?=^\[|\Z)", "", manifest.read_text())
        manifest.write_text(text)
    digits = source / "crates/digits/src/lib.rs"
    digits.write_text(digits.read_text() + SWITCH)
    command = [tool, source, folder / "faults.json", folder / "left_out.txt"]
    lines = subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True).stdout
    arms, sites = collections.defaultdict(set), collections.defaultdict(list)
    for line in lines.splitlines():
        kind, *words = line.split(" ")
        if kind == "arm":
            arms[words[0], int(words[1])].add(int(words[2]))
        elif kind == "site":
            sites[words[0]].append((int(words[1]), int(words[2]), [int(word) for word in words[3:]]))
    return arms, sites


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


def built(source, folder, tool, what):
    """Test programs with all faults that compile: package, name, path."""
    left_out = folder / "left_out.txt"
    while True:
        arms, sites = switched(source, folder, tool)
        command = ["cargo", "test", "--release", "--no-run", "--message-format=json", *what]
        environment = dict(os.environ, CARGO_TARGET_DIR=str(folder / "target"))
        run = subprocess.run(command, cwd=source, env=environment, stdout=subprocess.PIPE, text=True)
        messages = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
        if run.returncode == 0:
            tests = [m for m in messages if m.get("executable") and m["profile"]["test"]]
            return [(m["manifest_path"], m["target"]["name"], m["executable"]) for m in tests]
        errors = [m["message"] for m in messages if m["reason"] == "compiler-message"]
        drop = set()
        for error in errors:
            if error["level"] == "error":
                drop |= blamed(error, arms, sites)
        if not drop:
            raise SystemExit("\n".join(e["rendered"] for e in errors if e["level"] == "error"))
        with left_out.open("a") as file:
            file.writelines(f"{fault}\n" for fault in sorted(drop))
        print(f"{len(drop)} faults do not compile", flush=True)


def run(program, fault, limit):
    """How the tests end with this fault, and the first that fails."""
    manifest, _, path = program
    environment = dict(os.environ, FAULT=str(fault), PROPTEST_RNG_SEED="20261121")
    process = subprocess.Popen(
        [path], cwd=pathlib.Path(manifest).parent, env=environment,
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, errors="replace",
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
        return ("timeout" if not failed and took >= limit else "caught"), failed or f"exit {code}", took
    return "missed", None, took


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--sample", type=int, default=12, help="faults drawn from each file")
    parser.add_argument("--seed", type=int, default=20261121)
    parser.add_argument("--only", action="append", help="files whose path holds this")
    parser.add_argument("--root", action="store_true", help="what the packages miss meets the root's tests too")
    options = parser.parse_args()
    folder = options.folder.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    source = folder / "source"
    if not source.exists():
        subprocess.run(["git", "clone", "-q", PROJECT, source], check=True)
        (folder / "left_out.txt").write_text("")
    tool_target = folder / "switches"
    build = ["cargo", "build", "--release", "--manifest-path", HERE / "Cargo.toml", "--target-dir", tool_target]
    subprocess.run(build, check=True)
    tool = tool_target / "release/fault-switches"
    if not (folder / "faults.json").exists():
        faults = chosen(source, options)
        (folder / "faults.json").write_text(json.dumps(faults))
    faults = json.loads((folder / "faults.json").read_text())

    own = [word for package in PACKAGES for word in ("-p", package)] + ["--lib", "--tests"]
    stages = [built(source, folder, tool, own)]
    if options.root:
        named = [word for test in ROOT_TESTS for word in ("--test", test)]
        stages.append(built(source, folder, tool, named))
    left_out = {int(line) for line in (folder / "left_out.txt").read_text().split()}
    usual = {}
    for program in [program for stage in stages for program in stage]:
        outcome, failed, usual[program] = run(program, 0, 3600)
        if outcome != "missed":
            raise SystemExit(f"{program[1]} fails without a fault: {failed}")
    results = folder / "results.jsonl"
    known = [json.loads(line) for line in results.read_text().splitlines()] if results.exists() else []
    done = {entry["id"] for entry in known}
    for number, fault in enumerate(faults, 1):
        if number in left_out or number in done:
            continue
        crate = fault["file"].split("/")[1]
        programs = [p for p in stages[0] if f"/crates/{crate}/" in p[0]]
        programs = sorted(programs, key=usual.get) + sorted(sum(stages[1:], []), key=usual.get)
        outcome, failed, by = "missed", None, None
        for program in programs:
            outcome, failed, _ = run(program, number, 60 + 8 * usual[program])
            if outcome != "missed":
                by = program[1]
                break
        entry = {"id": number, "file": fault["file"], "name": fault["name"], "outcome": outcome, "by": by, "test": failed}
        known.append(entry)
        with results.open("a") as file:
            file.write(json.dumps(entry, ensure_ascii=False) + "\n")
    table = collections.defaultdict(collections.Counter)
    for entry in known:
        table[entry["file"]][entry["outcome"]] += 1
    for file, counts in table.items():
        print(file, dict(counts))
    for entry in known:
        if entry["outcome"] == "missed":
            print("missed:", entry["name"])


if __name__ == "__main__":
    main()
