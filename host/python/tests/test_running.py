"""Work runs without the interpreter's lock, tells of its progress, and stops by Ctrl-C."""

import os
import signal
import threading

import pytest

import stickslip


def test_ctrl_c_stops_a_diagnosis(bench):
    begun = threading.Event()

    def interrupt():
        begun.wait()
        os.kill(os.getpid(), signal.SIGINT)

    threading.Thread(target=interrupt).start()
    finished = False
    with pytest.raises(KeyboardInterrupt):
        stickslip.diagnose(bench, progress=lambda stage, done, steps: stage == "diagnosing" and begun.set())
        finished = True
    assert begun.is_set() and not finished
    # What was given up leaves nothing behind that the next call would meet.
    assert stickslip.check(bench).trials > 0


def test_other_threads_go_on_while_work_runs(bench):
    turns, done = [0], threading.Event()

    def count():
        while not done.wait(0.001):
            turns[0] += 1

    thread = threading.Thread(target=count)
    thread.start()
    seen = []
    try:
        stickslip.compare(bench, stickslip.Model(), progress=lambda *now: seen.append(turns[0]))
    finally:
        done.set()
        thread.join()
    assert len(seen) >= 2 and seen[-1] > seen[0], "no turn of the other thread from first to last progress"


def test_two_threads_compute_at_once(demo):
    hashes = []
    threads = [threading.Thread(target=lambda: hashes.append(stickslip.replay(demo).hash)) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(hashes) == 4 and len(set(hashes)) == 1


def test_progress_rises_to_the_end_of_a_stage(bench):
    told = []
    stickslip.compare(bench, stickslip.Model(), progress=lambda *now: told.append(now))
    comparing = [now for now in told if now[0] == "comparing"]
    assert comparing, told
    assert all(done <= steps for _, done, steps in comparing)
    assert [now[1] for now in comparing] == sorted(now[1] for now in comparing)


def test_what_a_progress_callback_raises_stops_the_work_and_is_raised(bench):
    def tired(stage, done, steps):
        raise LookupError("enough")

    with pytest.raises(LookupError, match="enough"):
        stickslip.diagnose(bench, progress=tired)
