#!/usr/bin/env python3
"""Puts one small fault after another into the code, and asks of each that a test fails. The faults stand in tests/mutants/list.

  tools/run.sh mutants [ID...]   all faults, or the named ones anew; an interrupted run goes on where it ended
  tools/run.sh mutants --check   only that each place of the list is found exactly once

All faults are compiled into one copy of the tree (build/mutants/source): a place becomes
`(dvdx_mutant(number) ? (fault) : (original))`, and the environment variable DVDX_MUTANT says which fault is active. With none
active every test case must pass by itself, the golden hashes among them, and records the places that it reaches: no other case can
catch a fault there. Verdicts are kept in build/mutants/results.json, for as long as neither the tree nor the fault changes; the case
that caught a fault last is kept longer, and is tried first.
"""

import concurrent.futures
import hashlib
import json
import os
import re
import resource
import signal
import struct
import subprocess
import sys
import zlib
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).resolve().parents[2]
LIST = ROOT / "tests/mutants/list"
WORK = ROOT / "build/mutants"
SOURCE = WORK / "source"
BUILD = WORK / "build"
RESULTS = WORK / "results.json"
CASES = WORK / "cases.json"
RECORDS = WORK / "records"

HEADER = """#pragma once
#include <cstdlib>
#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

inline const long dvdx_active_mutant = [] {
  const char* number = std::getenv("DVDX_MUTANT");
  return number ? std::atol(number) : 0L;
}();

// Shared by a test and the processes that it starts, and complete whatever becomes of them.
inline unsigned char* const dvdx_reached = [] {
  const char* path = std::getenv("DVDX_REACHED");
  const int file = path ? ::open(path, O_RDWR | O_CLOEXEC) : -1;
  void* bytes = file < 0 ? MAP_FAILED : ::mmap(nullptr, 1 << 16, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (file >= 0) ::close(file);
  return bytes == MAP_FAILED ? nullptr : static_cast<unsigned char*>(bytes);
}();

[[gnu::noinline]] inline bool dvdx_reach(long number) noexcept {
  if (dvdx_reached) dvdx_reached[number & 0xFFFF] = 1;
  return false;
}

constexpr bool dvdx_mutant(long number) noexcept {
  return !__builtin_is_constant_evaluated() &&
         (dvdx_active_mutant == number || (dvdx_active_mutant < 0 && dvdx_reach(number)));
}
"""


class Stale(Exception):
    """An entry of the list that does not fit the code."""


@dataclass
class Place:
    file: str  # the end of its path: names one tracked file
    text: str  # code with «original → fault» in it


@dataclass
class Mutant:
    id: str
    kind: str
    equivalent: str = ""  # why no test can fail
    places: list = field(default_factory=list)

    def number(self):
        return 1 + zlib.crc32(self.id.encode()) % 0x7FFFFFFE

    def mark(self):
        """Its byte in the record of places that a test reaches. Two faults may share one: then more tests are tried than need be."""
        return self.number() & 0xFFFF

    def hash(self):
        return hashlib.sha256(repr((self.id, self.places)).encode()).hexdigest()[:16]


def read_list():
    mutants = []
    for number, line in enumerate(LIST.read_text(encoding="utf-8").splitlines(), 1):
        if not line.strip() or line.startswith("#"):
            continue
        if line.strip().startswith("equivalent:"):
            mutants[-1].equivalent = line.partition(":")[2].strip()
        elif line.startswith("    "):
            place = mutants[-1].places[-1]
            place.text = f"{place.text}\n{line.strip()}" if place.text else line.strip()
        elif line.startswith("  "):
            mutants[-1].places.append(Place(line.strip(), ""))
        elif re.fullmatch(r"[\w.]+ \| \w+", line):
            mutants.append(Mutant(*line.split(" | ")))
        else:
            raise Stale(f"line {number} is none of the list's forms: {line}")
    ids = [mutant.id for mutant in mutants]
    for id in ids:
        if ids.count(id) > 1 or not mutants[ids.index(id)].places:
            raise Stale(f"{id}: stands twice or has no place")
    return mutants


def tracked_files():
    command = ["git", "ls-files", "-co", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True)
    return [path for path in listed.stdout.splitlines() if (ROOT / path).is_file()]


def exactly(text):
    """The pattern of a text in which any white space stands for any other."""
    return r"\s+".join(re.escape(word) for word in text.split())


def is_expression(text):
    """Roughly: in brackets it is one operand, as a fault and what it replaces become in `(... ? (fault) : (original))`."""
    text = re.sub(r'"[^"\n]*"|\'[^\'\n]*\'', "0", text)
    for _ in range(2):  # arguments of a template, and theirs
        text = re.sub(r"\b(\w+)<[\w:, ]*>(?=[({,])", r"\1", text)
    depth = 0
    for character in text:
        depth += (character in "([{") - (character in ")]}")
        if depth < 0 or depth == 0 and character in ",;":
            return False
    operators = r"[-+*/%<>=&|^,.?:]"
    return depth == 0 and not re.match(r"\s*([*&-]\s|[/%<>=|^,.?:]|&&|$)", text) and not re.search(operators + r"\s*$", text)


def find(mutant, place, files):
    """Where a place lies: its file, and the span that is replaced, and by what."""
    paths = [path for path in files if f"/{path}".endswith(f"/{place.file}") and not path.startswith("tests/")]
    if len(paths) != 1:
        raise Stale(f"{mutant.id}: {len(paths)} files are called {place.file}")
    parts = re.fullmatch(r"(.*)«(.*?)\s→\s?(.*)»(.*)", place.text, re.DOTALL)
    if not parts:
        raise Stale(f"{mutant.id}: no «original → fault» in: {place.text}")
    before, original, fault, after = parts.groups()
    pattern = [exactly(before), f"({exactly(original)})", exactly(after)]
    for i, gap in ((1, before[-1:]), (2, after[:1])):
        if gap.isspace():
            pattern[i] = r"\s+" + pattern[i]
    matches = list(re.finditer("".join(pattern), (ROOT / paths[0]).read_text(encoding="utf-8")))
    if len(matches) != 1:
        raise Stale(f"{mutant.id}: found {len(matches)} times in {paths[0]}: {place.text}")
    begin, end = matches[0].span(1)
    condition = f"dvdx_mutant({mutant.number()})"
    if re.search(r";\s*\}?$", original):  # statements
        return paths[0], begin, end, f"if ({condition}) {{ {fault} }} else {{ {original} }}"
    for text in (original, fault):
        if not is_expression(text):
            raise Stale(f"{mutant.id}: no expression of its own: {text}")
    return paths[0], begin, end, f"({condition} ? ({fault}) : ({original}))"


def with_faults(mutants, files):
    """The text of each file with all faults in it, by path; and every stale entry."""
    found, stale = {}, []
    for mutant in mutants:
        for place in mutant.places:
            try:
                path, begin, end, text = find(mutant, place, files)
                found.setdefault(path, []).append((begin, end, text, mutant.id))
            except Stale as error:
                stale.append(str(error))
    texts = {}
    for path, spans in found.items():
        text = (ROOT / path).read_text(encoding="utf-8")
        limit = len(text)
        for begin, end, replacement, id in sorted(spans, reverse=True):
            if end > limit:
                stale.append(f"{id}: overlaps another fault of {path}")
            text = text[:begin] + replacement + text[end:]
            limit = begin
        texts[path] = text
    return texts, stale


def write(path, content):
    """Leaves a file alone that is as it shall be, so that it is not compiled anew."""
    if not path.is_file() or path.read_bytes() != content:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)


def copy_tree(texts, files):
    for path in SOURCE.rglob("*"):
        if path.is_file() and str(path.relative_to(SOURCE)) not in files:
            path.unlink()
    for path in files:
        write(SOURCE / path, texts[path].encode() if path in texts else (ROOT / path).read_bytes())
        (SOURCE / path).chmod((ROOT / path).stat().st_mode)
    write(WORK / "mutant.hpp", HEADER.encode())


def build():
    def run(*command):
        subprocess.run(["cmake", *command], check=True, stdout=sys.stderr)

    # -O1 compiles sooner, but does not inline the operators of a wide number: its tests take four times as long.
    run("-S", SOURCE, "-B", BUILD, "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_CXX_FLAGS_RELEASE=-O2 -DNDEBUG",
        f"-DCMAKE_CXX_FLAGS=-include {WORK}/mutant.hpp -w", "-DDVDX_BUILD_BENCH=OFF", "-DDVDX_INSTALL=OFF")
    # -k 0: all that cannot be compiled is named at once.
    run("--build", BUILD, "--parallel", str(os.cpu_count()), "--target", "dvdx_tests", "dvdx_no_allocation",
        "dvdx_viewer", "--", "-k", "0")


PROGRAMS = ["tests/dvdx_tests", "tests/dvdx_no_allocation", "tools/dvdx", "tools/dvdx-mpi.so"]


def require_active(mutants):
    """A fault within a constant expression is never active: of such a one no program holds the number that it is compared with."""
    programs = b"".join((BUILD / path).read_bytes() for path in PROGRAMS)
    inert = [mutant.id for mutant in mutants if struct.pack("<i", mutant.number()) not in programs]
    if inert:
        raise Stale("what stands in a constant expression cannot be a fault: " + " ".join(inert))


def limit(seconds):
    for what, most in ((resource.RLIMIT_CPU, int(seconds)), (resource.RLIMIT_AS, 16 << 30), (resource.RLIMIT_FSIZE, 5 << 30),
                       (resource.RLIMIT_CORE, 0)):
        resource.setrlimit(what, (most, most))


def run_program(arguments, number, seconds, record=""):
    """The exit status of a test program with one fault active (0: none; -1: none, and a record of those that are reached), None
    at the time limit, and what it said. The limit is of processor time, which does not depend on what else the machine does, and
    for a deadlock four times as much of time."""
    environment = {**os.environ, "DVDX_MUTANT": str(number), "DVDX_REACHED": str(record)}
    process = subprocess.Popen(arguments, cwd=BUILD, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                               preexec_fn=lambda: limit(seconds), start_new_session=True)
    try:
        output = process.communicate(timeout=4 * seconds)[0].decode(errors="replace")
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return None, process.communicate()[0].decode(errors="replace")
    return None if process.returncode in (-signal.SIGXCPU, -signal.SIGKILL) else process.returncode, output


def failure(arguments, number, seconds):
    """Which test failed; "" if all passed."""
    status, output = run_program(arguments, number, seconds)
    if status == 0:
        return ""
    if status is None:
        return f"time limit of {seconds:.0f} s"
    error = re.search(r"^\S+:\d+: (?:FATAL )?ERROR: ", output, re.MULTILINE)
    if not error:
        return f"{Path(arguments[0]).name}: exit status {status}"
    # Cases that stand before the failing one have said something.
    cases = re.findall(r"(\w+)\.cpp:\d+:\s+(?:TEST SUITE:.*\s+)?TEST CASE:\s+(.*)$", output[: error.start()], re.MULTILINE)
    return ": ".join(cases[-1]).strip() if cases else "?"


TESTS = [str(BUILD / "tests/dvdx_tests"), "--no-intro", "--no-version", "--abort-after=1"]
ALLOCATIONS = [str(BUILD / "tests/dvdx_no_allocation")]


def arguments_of(cases):
    return [*TESTS, "--test-case=" + ",".join(case["name"].replace(",", "?") for case in cases)]  # a comma ends a filter


def unmutated():
    """Runs each test case alone and without a fault, which must pass: how long it takes, and the marks (Mutant.mark) of all places
    that it reaches. No other case can catch a fault there. The counted allocations are a program of their own, with no name."""
    RECORDS.mkdir(exist_ok=True)
    xml = subprocess.run([*TESTS, "--list-test-cases", "--reporters=xml"], check=True, stdout=subprocess.PIPE).stdout
    listed = [(Path(case.get("filename")).stem, case.get("name")) for case in ElementTree.fromstring(xml).iter("TestCase")]

    def run(file, name):
        record = RECORDS / hashlib.sha256(f"{file}: {name}".encode()).hexdigest()[:16]
        record.write_bytes(bytes(1 << 16))
        program = arguments_of([{"name": name}]) if name else ALLOCATIONS
        status, output = run_program(["bash", "-c", 'time "$@"', "time", *program], -1, 3600, record)
        if status != 0:
            sys.exit(f"{output[-4000:]}\nwithout a fault a test fails: exit status {status}")
        minutes, seconds = re.findall(r"^user\s+(\d+)m([0-9.]+)s$", output, re.MULTILINE)[-1]
        marks = [mark for mark, is_reached in enumerate(record.read_bytes()) if is_reached]
        return {"file": file, "name": name, "seconds": 60 * int(minutes) + float(seconds), "marks": marks}

    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(pool.map(lambda case: run(*case), [*listed, ("", "")]))


def programs(cases, last):
    """Test programs with the cases that reach a fault, and the seconds that each may take: first the case that caught it in an
    earlier run, then all from the shortest to the longest, a few at a time; then the golden hashes, which know that bits have
    changed and not what is right; then the counted allocations."""
    is_last = lambda case: last == f"{case['file']}: {case['name']}"
    order = lambda case: (not is_last(case), case["file"] == "golden_test", case["seconds"])
    together, seconds, enough = [], 0.0, 0.0
    for case in sorted((case for case in cases if case["name"]), key=order):
        together.append(case)
        seconds += case["seconds"]
        if seconds >= enough:
            yield arguments_of(together), 60 + 6 * seconds
            together, seconds, enough = [], 0.0, 4 * enough or 1.0
    if together:
        yield arguments_of(together), 60 + 6 * seconds
    yield from ((ALLOCATIONS, 60 + 6 * case["seconds"]) for case in cases if not case["name"])


def verdict(mutant, cases, last=""):
    reaching = [case for case in cases if mutant.mark() in case["marks"]]
    for arguments, seconds in programs(reaching, last):
        found = failure(arguments, mutant.number(), seconds)
        if found:
            return found
    return ""


def tree_hash(files):
    digest = hashlib.sha256()
    for path in files:
        if path.startswith(("kernel/", "layouts/", "tools/", "tests/")) and not path.startswith("tests/mutants/"):
            digest.update(path.encode() + b"\0" + (ROOT / path).read_bytes() + b"\0")
    return digest.hexdigest()[:16]


def read_results(tree):
    results = json.loads(RESULTS.read_text()) if RESULTS.is_file() else {}
    if results.get("tree") == tree:
        return results
    last = results.get("last", {}) | {v["id"]: v["test"] for v in results.get("verdicts", {}).values() if v["test"]}
    return {"tree": tree, "verdicts": {}, "last": last}


def read_cases(programs):
    """All test cases as `unmutated` finds them, kept for as long as the same faults stand in the same tree."""
    kept = json.loads(CASES.read_text()) if CASES.is_file() else {}
    if kept.get("programs") != programs:
        kept = {"programs": programs, "cases": unmutated()}
        write(CASES, json.dumps(kept).encode())
    return kept["cases"]


def show(mutants, results):
    caught = survived = equivalent = 0
    for mutant in mutants:
        result = results["verdicts"].get(mutant.hash())
        if result is None:
            continue
        text = result["test"]
        if text:
            caught += 1
        elif mutant.equivalent:
            equivalent += 1
            text = f"equivalent: {mutant.equivalent}"
        else:
            survived += 1
            text = "SURVIVED"
        print(f"{mutant.id:36} {mutant.kind:10} {text}")
    print(f"{caught + survived + equivalent} faults of {len(mutants)}: {caught} caught, {survived} survived, "
          f"{equivalent} explained")
    return caught >= 0.95 * len(mutants) and survived == 0


def main(arguments):
    mutants, files = read_list(), tracked_files()
    texts, stale = with_faults(mutants, files)
    if stale:
        raise Stale("\n  ".join(stale))
    print(f"{len(mutants)} faults at {sum(len(mutant.places) for mutant in mutants)} places, each found once")
    if arguments == ["--check"]:
        return
    unknown = set(arguments) - {mutant.id for mutant in mutants}
    if unknown:
        sys.exit("no such fault: " + " ".join(sorted(unknown)))

    copy_tree(texts, files)
    build()
    require_active(mutants)
    tree = tree_hash(files)
    results = read_results(tree)
    cases = read_cases(f"{tree} {hashlib.sha256(repr(sorted(mutant.hash() for mutant in mutants)).encode()).hexdigest()}")
    is_wanted = lambda mutant: mutant.id in arguments if arguments else mutant.hash() not in results["verdicts"]
    todo = [mutant for mutant in mutants if is_wanted(mutant)]
    print(f"no fault active: every test passes, {sum(case['seconds'] for case in cases):.0f} s; {len(todo)} faults to run", flush=True)
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        runs = {pool.submit(verdict, mutant, cases, results["last"].get(mutant.id, "")): mutant for mutant in todo}
        for run in concurrent.futures.as_completed(runs):
            mutant = runs[run]
            results["verdicts"][mutant.hash()] = {"id": mutant.id, "test": run.result()}
            write(RESULTS, json.dumps(results, indent=1).encode())
            print(f"{mutant.id:36} {run.result() or '-'}", flush=True)
    print()
    if not show(mutants, results) and not arguments:
        sys.exit(1)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except Stale as error:
        sys.exit(f"tests/mutants/list does not fit the code:\n  {error}")
    except subprocess.CalledProcessError:
        sys.exit(f"the copy with all faults in it cannot be built: see above, and {SOURCE}")
