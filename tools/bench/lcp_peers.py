"""Complementarity solvers on the same problems, on one core, in one run.

Generates problems with `stickslip lcp --generate --save`, solves them with our dense solver,
our contact solver cold and warm, and with QuantEcon (numba), Drake (Moby) and Siconos, and
prints one table. Answers are judged here, by the residual of docs/solver.md, for every solver
alike: `claimed` counts answers that the solver says are right and that have a residual of 1e-8
or less, `right` all such answers, also those that the solver calls failures; `false` are claims
with a larger residual. Needs Python packages numpy, quantecon, drake, and a C compiler with
libsiconos-numerics-dev for Siconos; what is missing is said and left out.

Every solver has a bounded time a file (--patience): it starts no further problem after half
of it, and is stopped at its end. The column `problems` says how many each one reached; ratios
are of the medians over grasps.

Usage: python lcp_peers.py STICKSLIP [--number 40] [--contacts 10] [--files FILE.lcp ...]
"""

import argparse
import multiprocessing
import os
import pathlib
import struct
import subprocess
import sys
import tempfile
import time

import numpy as np

HERE = pathlib.Path(__file__).parent
REPETITIONS = 5
# A solve slower than this is not repeated.
SLOW_US = 2e4


def read_problems(path):
    data = path.read_bytes()
    magic, number, n, _, _, _ = struct.unpack_from("<6i", data)
    assert magic == 0x4C435031, path
    values = np.frombuffer(data, "<f8", offset=24).reshape(number, n * n + n)
    return [(v[: n * n].reshape(n, n).copy(), v[n * n :].copy()) for v in values]


def read_answers(path):
    data = path.read_bytes()
    number, n = struct.unpack_from("<2i", data)
    offset, answers = 8, []
    for _ in range(number):
        status, _, repetitions, _ = struct.unpack_from("<4i", data, offset)
        values = np.frombuffer(data, "<f8", repetitions + n, offset + 16)
        offset += 16 + 8 * (repetitions + n)
        answers.append((status == 0, float(np.median(values[:repetitions])), values[repetitions:]))
    return answers


def residual(m, q, z):
    if not np.all(np.isfinite(z)):
        return np.inf
    w = m @ z + q
    largest = np.abs(z).max()
    size = np.abs(q) + np.abs(m).sum(axis=1) * largest
    size[size == 0] = 1.0
    if largest == 0:
        return max(0.0, (-w / size).max())
    return max(-z.min() / largest, (-w / size).max(), (np.abs(z) / largest * np.abs(w) / size).sum())


def timed(problems, solve, patience):
    answers, began = [], time.perf_counter()
    for m, q in problems:
        if time.perf_counter() - began > patience / 2:
            break
        times = []
        for _ in range(REPETITIONS):
            start = time.perf_counter()
            claims, z = solve(m, q)
            times.append(1e6 * (time.perf_counter() - start))
            if times[-1] > SLOW_US:
                break
        answers.append((claims, float(np.median(times)), z))
    return answers


def bounded(patience, run, *arguments):
    """`run` in a process of its own, which is stopped when it takes longer; None then."""

    def send():
        try:
            sender.send(run(*arguments))
        except subprocess.SubprocessError as error:
            print(error, file=sys.stderr)

    context = multiprocessing.get_context("fork")
    receiver, sender = context.Pipe(duplex=False)
    process = context.Process(target=send)
    process.start()
    sender.close()
    answers = None
    try:
        # A program that the process has started is stopped by the process itself.
        if receiver.poll(patience + 1.0):
            answers = receiver.recv()
    except EOFError:
        pass
    if process.is_alive() and answers is None:
        process.kill()
    process.join()
    return answers


def ours(program, solver, factors):
    def run(path, _, patience):
        source = path.with_suffix(".fac") if factors else path
        if not source.exists():
            return None
        with tempfile.NamedTemporaryFile(suffix=".res") as out:
            command = [program, "lcp", str(source), "--solver", solver, "--out", out.name]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL, timeout=patience)
            return read_answers(pathlib.Path(out.name))

    return run


def quantecon(tolerances=None):
    from quantecon.optimize import lcp_lemke
    from quantecon.optimize.linprog_simplex import PivOptions

    options = PivOptions(*tolerances) if tolerances else PivOptions()

    def solve(m, q):
        result = lcp_lemke(m, q, max_iter=3000, piv_options=options)
        return bool(result.success), result.z

    solve(np.eye(3), -np.ones(3))  # compiles
    return lambda _, problems, patience: timed(problems, solve, patience)


def drake():
    from pydrake.solvers import MathematicalProgram, MobyLcpSolver

    # The regularised Lemke of Moby is not in the Python interface by itself: the program that
    # holds one complementarity constraint calls it. Building the program is not timed.
    solver = MobyLcpSolver()

    def run(_, problems, patience):
        answers, began = [], time.perf_counter()
        for m, q in problems:
            if time.perf_counter() - began > patience / 2:
                break
            program = MathematicalProgram()
            z = program.NewContinuousVariables(len(q))
            program.AddLinearComplementarityConstraint(m, q, z)
            times = []
            for _ in range(REPETITIONS):
                start = time.perf_counter()
                result = solver.Solve(program, None, None)
                times.append(1e6 * (time.perf_counter() - start))
                if times[-1] > SLOW_US:
                    break
            answers.append((result.is_success(), float(np.median(times)), result.GetSolution(z)))
        return answers

    return run


def siconos(method):
    program = pathlib.Path(tempfile.gettempdir()) / "stickslip_siconos_lcp"
    includes = [f"-I/usr/include/siconos{part}" for part in ("", "/numerics", "/externals")]
    subprocess.run(
        ["cc", "-O2", "-w", *includes, "-o", program, HERE / "siconos_lcp.c",
         "-lsiconos_numerics", "-lsiconos_externals", "-lm"],
        check=True,
    )

    def run(path, _, patience):
        with tempfile.NamedTemporaryFile(suffix=".res") as out:
            command = [program, str(path), method, out.name, str(REPETITIONS), str(patience / 2)]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL,
                           stderr=subprocess.DEVNULL, timeout=patience)
            return read_answers(pathlib.Path(out.name))

    return run


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("stickslip")
    parser.add_argument("--number", type=int, default=40, help="problems of each family")
    parser.add_argument("--contacts", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--patience", type=float, default=5.0, help="seconds a solver and file")
    parser.add_argument("--files", nargs="*", type=pathlib.Path, help="these .lcp files instead")
    args = parser.parse_args()
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    with tempfile.TemporaryDirectory() as directory:
        if args.files:
            files = args.files
        else:
            command = [args.stickslip, "lcp", "--generate", str(args.number), "--contacts",
                       str(args.contacts), "--seed", str(args.seed), "--save", directory]
            subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
            files = sorted(pathlib.Path(directory).glob("*.lcp"))
        sets = [(path, read_problems(path)) for path in files]
        solvers = [
            ("(b) contact, warm", lambda: ours(args.stickslip, "warm", True)),
            ("(b) contact, cold", lambda: ours(args.stickslip, "contact", True)),
            ("(a) dense", lambda: ours(args.stickslip, "dense", False)),
            ("QuantEcon lcp_lemke", quantecon),
            # Of the tolerances tried (pivots 1e-10 to 1e-6, ratios 1e-15 to 1e-8) those with which
            # it recognises most of its right answers.
            ("QuantEcon, wider tolerances", lambda: quantecon((1e-6, 1e-6, 1e-8))),
            ("Drake Moby, regularised", drake),
            ("Siconos Lemke", lambda: siconos("lemke")),
            ("Siconos Newton F-B", lambda: siconos("newton")),
        ]
        table = []
        for name, make in solvers:
            print(name, file=sys.stderr)
            try:
                solve = make()
            except (ImportError, OSError, subprocess.CalledProcessError) as error:
                print(f"{name} left out: {error}", file=sys.stderr)
                continue
            groups = {"grasp": [], "degenerate": [], "sequence": []}
            for path, problems in sets:
                answers = bounded(args.patience, solve, path, problems, args.patience)
                if answers is None:
                    print(f"{name}: no answer to {path.stem} in {args.patience:.0f} s", file=sys.stderr)
                    continue
                stem = path.stem.rstrip("0123456789_").removeprefix("b_")
                group = {"sequence": "sequence", "force": "grasp", "approach": "grasp"}.get(
                    stem.rstrip("68"), "degenerate")
                for (m, q), (claims, us, z) in zip(problems, answers):
                    groups[group].append((claims, residual(m, q, z), us))
            table.append((name, groups))
    print_table(table)


def print_table(table):
    reference = next((groups for name, groups in table if name.startswith("Quant")), None)
    print("| solver | problems | claimed % grasp / degenerate / sequence | right % | false > 1e-8 "
          "| false > 1e-4 | median us grasp / sequence | p99 us all | times faster than QuantEcon |")
    print("|---|---|---|---|---|---|---|---|---|")
    medians = lambda groups: [np.median([us for _, _, us in groups[k]]) if groups[k] else np.nan
                              for k in ("grasp", "sequence")]
    for name, groups in table:
        everything = [x for group in groups.values() for x in group]
        if not everything:
            print(f"| {name} | 0 | - | - | - | - | - | - | - |")
            continue
        share = lambda good: " / ".join(
            f"{100 * np.mean([good(c, r) for c, r, _ in v]):.1f}" if v else "-" for v in groups.values())
        median = medians(groups)
        ratio = [a / b for a, b in zip(medians(reference), median)] if reference else [np.nan] * 2
        claims = [r for c, r, _ in everything if c]
        print(f"| {name} | {len(everything)} | {share(lambda c, r: c and r <= 1e-8)} "
              f"| {share(lambda c, r: r <= 1e-8)} | {sum(r > 1e-8 for r in claims)} "
              f"| {sum(r > 1e-4 for r in claims)} | {median[0]:.1f} / {median[1]:.1f} "
              f"| {np.percentile([us for _, _, us in everything], 99):.0f} "
              f"| {ratio[0]:.1f} / {ratio[1]:.1f} |", flush=True)


if __name__ == "__main__":
    main()
